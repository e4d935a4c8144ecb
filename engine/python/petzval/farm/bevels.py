# SPDX-License-Identifier: GPL-3.0-or-later
"""Bevel modifiers of the .blend that is open, applied for a job: Blender's Bevel goes by addresses of memory and makes other corners in each process,
of which parts could not be joined. A Subdivision Surface behind a Bevel is applied too: its result for a Bevel's texture coordinates, of
which many lie within rounding of each other, differs between processes even where the Bevel is the same."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

#: Modifiers whose result depends on the mesh and their own settings alone, as long as they name no other object.
_OF_THE_MESH = {
    "ARRAY", "BEVEL", "DECIMATE", "EDGE_SPLIT", "MIRROR", "REMESH", "SCREW", "SKIN", "SOLIDIFY", "SUBSURF", "TRIANGULATE", "WEIGHTED_NORMAL",
    "WELD", "WIREFRAME",
}  # fmt: skip
#: Properties of modifiers that name another object.
_OTHERS = ("mirror_object", "offset_object", "curve", "start_cap", "end_cap", "object")


def apply_all(bpy: Any, frame: int, *, moves: bool) -> tuple[list[str], list[str]]:
    """Applies each object's modifiers up to its last Bevel and the Subdivision Surface behind it, at a frame, as a render evaluates them. Names of the objects whose modifiers are applied, and
    of those whose are not; of linked data, their own .blend is asked. `moves`: more than one time is rendered."""
    done, left = [], []
    wanted: dict[Any, int] = {}
    for one in bpy.data.objects:
        ends = _ends(one)
        if not ends or one.library is not None:
            continue
        last = next((end for end in ends if _can_be_applied(one, end, moves=moves)), None)
        if last is None:
            left.append(one.name)
        else:
            wanted[one] = last
    for one, mesh in _evaluated(bpy, wanted, frame):
        if mesh is None:
            left.append(one.name)
            continue
        one.data = mesh
        for made in list(one.modifiers)[: wanted[one] + 1]:
            one.modifiers.remove(made)
        done.append(one.name)
    return done, left


def _ends(one: Any) -> list[int]:
    """Numbers of the modifiers up to which an object's may be applied, best first; none without a Bevel. Dicing by the size of pixels is of the render."""
    shown = [(i, made) for i, made in enumerate(one.modifiers) if made.show_render]
    bevel = max((i for i, made in shown if made.type == "BEVEL"), default=None)
    if bevel is None:
        return []
    behind = [i for i, made in shown if i > bevel and made.type == "SUBSURF" and not _is_adaptive(one, made)]
    return [*behind[-1:], bevel]


def _is_adaptive(one: Any, made: Any) -> bool:
    """True of a Subdivision Surface that Cycles dices by the size of pixels: a property of the modifier since Blender 5, of the object before."""
    own = getattr(one, "cycles", None)
    return bool(getattr(made, "use_adaptive_subdivision", False) or getattr(own, "use_adaptive_subdivision", False))


def _can_be_applied(one: Any, last: int, *, moves: bool) -> bool:
    """True of an object of this file whose mesh may be replaced by the result of its modifiers."""
    if (
        one.type != "MESH"
        or one.library is not None
        or one.data.library is not None
        or one.override_library is not None
    ):
        return False
    # Particles grow from the mesh as it was.
    if one.particle_systems:
        return False
    return not moves or _is_still(one, last)


def _is_still(one: Any, last: int) -> bool:
    """True where the result of the modifiers up to `last` is the same at all times."""
    for made in list(one.modifiers)[: last + 1]:
        if made.type not in _OF_THE_MESH or any(getattr(made, other, None) is not None for other in _OTHERS):
            return False
    blocks = [one.data, one.data.shape_keys]
    if one.data.shape_keys is not None or any(block is not None and block.animation_data for block in blocks):
        return False
    own = one.animation_data
    if own is None:
        return True
    curves = [*own.drivers, *_curves(own.action)]
    return not own.nla_tracks and not any(curve.data_path.startswith("modifiers") for curve in curves)


def _curves(action: Any) -> Iterator[Any]:
    """The curves of an action; of Blender 4.4 and later in layers."""
    if action is None:
        return
    layers = getattr(action, "layers", None)
    if layers is None:
        yield from action.fcurves
        return
    for layer in layers:
        for strip in layer.strips:
            for bag in strip.channelbags:
                yield from bag.fcurves


def _evaluated(bpy: Any, wanted: dict[Any, int], frame: int) -> list[tuple[Any, Any]]:
    """A new mesh for each object, of its modifiers up to the one with that number; None where Blender makes none."""
    if not wanted:
        return []
    # A scene of its own, in which nothing is hidden; its graph is of the viewport, so that modifiers are set as a render has them.
    stage = bpy.data.scenes.new("bevels")
    stage.render.use_simplify = False
    was: list[tuple[Any, str, Any]] = []

    def change(owner: Any, name: str, value: Any) -> None:
        was.append((owner, name, getattr(owner, name)))
        setattr(owner, name, value)

    for one, last in wanted.items():
        stage.collection.objects.link(one)
        change(one, "hide_viewport", False)
        for number, made in enumerate(one.modifiers):
            change(made, "show_viewport", made.show_render and number <= last)
            if made.type in {"SUBSURF", "MULTIRES"}:
                change(made, "levels", made.render_levels)
    try:
        stage.frame_set(frame)
        with bpy.context.temp_override(scene=stage, view_layer=stage.view_layers[0]):
            graph = bpy.context.evaluated_depsgraph_get()
        return [(one, _new_mesh(bpy, one, graph)) for one in wanted]
    finally:
        bpy.data.scenes.remove(stage)
        for owner, name, value in reversed(was):
            setattr(owner, name, value)


def _new_mesh(bpy: Any, one: Any, graph: Any) -> Any:
    made = one.evaluated_get(graph)
    if not made.is_evaluated:
        return None
    try:
        mesh = bpy.data.meshes.new_from_object(made, preserve_all_data_layers=True, depsgraph=graph)
    except RuntimeError:
        return None
    if mesh is not None:
        mesh.name = one.data.name
    return mesh
