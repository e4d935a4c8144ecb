# SPDX-License-Identifier: GPL-3.0-or-later
"""The owners of settings, the settings that they have by Blender's own account (RNA), and the values that each is given. Inside of bpy."""

from __future__ import annotations

import fnmatch
from collections.abc import Callable
from typing import Any, NamedTuple

import bpy

#: The owners of settings, by a name that the page shows.
OWNERS: dict[str, Callable[[], Any]] = {
    "scene": lambda: bpy.context.scene,
    "scene.render": lambda: bpy.context.scene.render,
    "scene.cycles": lambda: bpy.context.scene.cycles,
    "scene.cycles_curves": lambda: bpy.context.scene.cycles_curves,
    "view layer": lambda: bpy.context.view_layer,
    "view layer.cycles": lambda: bpy.context.view_layer.cycles,
    "layer collection": lambda: bpy.context.view_layer.layer_collection.children["Things"],
    "camera": lambda: bpy.context.scene.camera.data,
    "camera.dof": lambda: bpy.context.scene.camera.data.dof,
    "camera object": lambda: bpy.context.scene.camera,
    "camera object.cycles": lambda: bpy.context.scene.camera.cycles,
    "subdivision": lambda: bpy.data.objects["Relief"].modifiers[0],
    "world": lambda: bpy.context.scene.world,
    "world.cycles": lambda: bpy.context.scene.world.cycles,
    "world.cycles_visibility": lambda: bpy.context.scene.world.cycles_visibility,
    "world.light_settings": lambda: bpy.context.scene.world.light_settings,
    "world.mist_settings": lambda: bpy.context.scene.world.mist_settings,
}
for _kind, _name in (("mesh", "Ball"), ("hair", "Hair"), ("fog", "Fog"), ("light", "Area")):
    OWNERS[f"object ({_kind})"] = lambda name=_name: bpy.data.objects[name]
    OWNERS[f"object ({_kind}).cycles"] = lambda name=_name: bpy.data.objects[name].cycles
for _name in ("Point", "Sun", "Spot", "Area"):
    OWNERS[f"light ({_name.lower()})"] = lambda name=_name: bpy.data.lights[name]
    OWNERS[f"light ({_name.lower()}).cycles"] = lambda name=_name: bpy.data.lights[name].cycles
for _name in ("Floor", "Veil", "Glow", "Relief", "Fog"):
    OWNERS[f"material ({_name.lower()})"] = lambda name=_name: bpy.data.materials[name]
    OWNERS[f"material ({_name.lower()}).cycles"] = lambda name=_name: bpy.data.materials[name].cycles
#: The settings that only contexts set: Petzval's own.
NOT_WALKED = {
    "camera.petzval": lambda: bpy.context.scene.camera.data.petzval,
    "scene.petzval": lambda: bpy.context.scene.petzval,
}


#: A name is none, and with nodes is all that newer Blenders know: to ask is deprecated.
NAMES_LEFT_OUT = {"name", "use_nodes"}


class Setting(NamedTuple):
    """A property and its values beside the one that the stage has."""

    owner: str
    name: str
    values: list[Any]


def settings(given: list[dict[str, Any]] | None = None) -> list[Setting]:
    """All of the stage that is open. `given`: values by owner and name, of which each is a pattern; they also bring in strings and things
    by name (`@materials/Floor`), which have none of their own accord."""
    found = []
    own_of_every_id = set(bpy.types.ID.bl_rna.properties.keys())
    for owner, of in OWNERS.items():
        holder = of()
        for one in holder.bl_rna.properties:
            name = one.identifier
            values = next(
                (
                    row["values"]
                    for row in given or []
                    if fnmatch.fnmatchcase(owner, row["owner"]) and name == row["name"]
                ),
                None,
            )
            is_plain = one.type in {"BOOLEAN", "INT", "FLOAT", "ENUM"} and not one.is_readonly
            if name in own_of_every_id or (values is None and not is_plain) or name in NAMES_LEFT_OUT:
                continue
            found.append(Setting(owner, name, others(one, getattr(holder, name)) if values is None else values))
    return found


def others(one: bpy.types.Property, now: Any) -> list[Any]:
    """Values beside the one that a property has now: the other choices, or a smaller and a larger number."""
    if one.type == "ENUM":
        if one.is_enum_flag:
            return [sorted({item.identifier for item in one.enum_items} - set(now))]
        return [item.identifier for item in one.enum_items if item.identifier != now]
    if getattr(one, "is_array", False):
        flat = [number for row in now for number in (row if hasattr(row, "__len__") else [row])]
        if one.type == "BOOLEAN":
            return [[not number for number in flat]]
        if len(flat) == 16:
            # A place alone: programs make different things of cameras that are sheared.
            return [[number + 0.3 * (index in (3, 7, 11)) for index, number in enumerate(flat)]]
        moved = [number + (0.2 + 0.2 * abs(number)) * (-1) ** index for index, number in enumerate(flat)]
        if one.type == "INT":
            moved = [number + 1 for number in flat]
        return [[min(max(number, one.soft_min), one.soft_max) for number in moved]]
    if one.type == "BOOLEAN":
        return [not now]
    low, high = one.soft_min, one.soft_max
    if one.type == "INT":
        return sorted({max(low, now // 2), min(high, max(2 * now, now + 1))} - {now})
    # A step away from zero within a short range, else of one unit.
    step = 0.5 * (high - low) if high - low <= 10.0 else 1.0
    asked = {now - step, now + step} if now == 0.0 else {0.6 * now, 1.6 * now}
    return sorted({min(max(number, low), high) for number in asked} - {now})


def put(owner: str, name: str, value: Any) -> str:
    """Gives a property a value; returns the fault if it does not take it."""
    holder = (OWNERS | NOT_WALKED)[owner]()
    try:
        if isinstance(value, str) and value.startswith("@"):
            kind, _, which = value[1:].partition("/")
            value = getattr(bpy.data, kind)[which]
        elif isinstance(value, list) and holder.bl_rna.properties[name].type == "ENUM":
            value = set(value)
        elif isinstance(value, list) and name.startswith("matrix"):
            value = [value[4 * row : 4 * row + 4] for row in range(4)]
        setattr(holder, name, value)
    except (TypeError, ValueError, AttributeError, KeyError) as error:
        return str(error)
    return ""
