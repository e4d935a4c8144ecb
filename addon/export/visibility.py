# SPDX-License-Identifier: GPL-3.0-or-later
"""The kinds of ray that things are hidden from, and the limits of bounces by kind."""

from __future__ import annotations

import bpy

from petzval.description import NO_LIMIT, RAYS, Caustics, KindLimits


def hidden_from(*holders: bpy.types.Object) -> tuple[str, ...]:
    """The kinds of rays that an object, a mesh or a light is hidden from; of several, those that any of them is hidden from."""
    return tuple(kind for kind in RAYS if not all(getattr(holder, f"visible_{kind.lower()}") for holder in holders))


def world_hidden_from(world: bpy.types.World) -> tuple[str, ...]:
    """The kinds of rays that the world is hidden from, by Cycles' own settings."""
    visibility = getattr(world, "cycles_visibility", None)
    names = {kind: "scatter" if kind == "VOLUME_SCATTER" else kind.lower() for kind in RAYS if kind != "SHADOW"}
    return tuple(kind for kind, name in names.items() if not getattr(visibility, name, True))


def bounces(scene: bpy.types.Scene) -> KindLimits:
    """The limits that Blender keeps in Cycles's settings, where there is Cycles."""
    cycles = getattr(scene, "cycles", None)
    if cycles is None:
        return KindLimits()
    transparent = cycles.transparent_max_bounces
    return KindLimits(
        **{kind: getattr(cycles, f"{kind}_bounces", NO_LIMIT) for kind in KINDS},
        # Before 5.0 paths passed one surface more than this says.
        transparent=transparent + (bpy.app.version < (5, 0, 0)),
        transparent_shadows=transparent,
        caustics=Caustics(**{kind: getattr(cycles, f"caustics_{kind}", True) for kind in CAUSTICS}),
    )


def limits_kinds(scene: bpy.types.Scene) -> bool:
    """True if paths of one kind of bounce end before others, and before those of a new scene do."""
    cycles, most = getattr(scene, "cycles", None), most_bounces(scene)
    if cycles is None:
        return False
    names = [f"{kind}_bounces" for kind in ("diffuse", "glossy", "transmission")]
    return any(getattr(cycles, name) < min(most, cycles.bl_rna.properties[name].default) for name in names)


def leaves_out_caustics(scene: bpy.types.Scene) -> bool:
    """True if light that is reflected or refracted after a diffuse scattering is left out."""
    caustics = bounces(scene).caustics
    return not (caustics.reflective and caustics.refractive)


def most_bounces(scene: bpy.types.Scene) -> int:
    """Petzval's own limit, or Cycles's where Petzval's was never set."""
    own, cycles = scene.petzval, getattr(scene, "cycles", None)
    if cycles is None or own.is_property_set("max_bounces"):
        return own.max_bounces
    return cycles.max_bounces


KINDS = ("diffuse", "glossy", "transmission", "volume")
CAUSTICS = ("reflective", "refractive")
