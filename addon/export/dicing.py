# SPDX-License-Identifier: GPL-3.0-or-later
"""Adaptive subdivision: how finely the engine divides an object's mesh before it is displaced, by Cycles' settings."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy

from .memory import Room
from .report import Report

#: The settings of dicing: True for pixels of Blender's own camera, else units of the mesh's space; the length of an edge; the off-screen
#: scale; the most times that an edge is halved; the triangles that there is room for.
Dicing = tuple[bool, float, float, int, int]
#: Cycles' own least dicing rate, pixels.
LEAST_PIXELS = 0.1
LEAST_UNITS = 1e-4
#: A rounded surface is divided as Catmull and Clark until it has so many faces, but no more than so often; further pieces lie on these.
ROUND_FACES = 4096
MOST_LEVELS = 6
#: The engine makes no more triangles of a scene (engine/render/src/scene/dicing.rs), so that more room is the same to it, and a render of
#: the same picture is known by the same numbers.
MOST_TRIANGLES = 12_000_000


def of_scene(scene: bpy.types.Scene, is_render: bool) -> tuple[float, float, int]:
    """The dicing rate in pixels, the off-screen scale and the most subdivisions."""
    own = getattr(scene, "cycles", None)
    if own is None:
        return 1.0 if is_render else 8.0, 4.0, 12
    return own.dicing_rate if is_render else own.preview_dicing_rate, own.offscreen_dicing_scale, own.max_subdivisions


def camera(depsgraph: bpy.types.Depsgraph) -> bpy.types.Object | None:
    """The camera by whose pixels meshes are diced, as Cycles keeps it; None: the scene's."""
    scene = depsgraph.scene_eval
    holder = getattr(getattr(scene, "cycles", None), "dicing_camera", None)
    own = None if scene.camera is None else scene.camera.original
    if holder is None or holder.type != "CAMERA" or holder.original == own:
        return None
    return holder.evaluated_get(depsgraph)


def of(holder: bpy.types.Object, scene: bpy.types.Scene, is_render: bool, room: Room, report: Report) -> Dicing | None:
    """The dicing of an object's mesh; None where the mesh stays as Blender's modifiers make it."""
    modifier = holder.modifiers[-1] if holder.modifiers else None
    if (
        holder.type != "MESH"
        or modifier is None
        or modifier.type != "SUBSURF"
        or not (modifier.show_render if is_render else modifier.show_viewport)
    ):
        return None
    own = getattr(scene, "cycles", None)
    rate, off_screen, most = of_scene(scene, is_render)
    is_in_units = False
    if hasattr(modifier, "use_adaptive_subdivision"):
        is_diced, pixels = modifier.use_adaptive_subdivision, modifier.adaptive_pixel_size
        is_in_units = modifier.adaptive_space == "OBJECT"
    else:
        # Before Blender 5 the object says so, where Cycles' experimental features are on.
        is_diced = own is not None and own.feature_set == "EXPERIMENTAL" and holder.cycles.use_adaptive_subdivision
        pixels = holder.cycles.dicing_rate if is_diced else 1.0
    if not is_diced:
        return None
    if not any(_is_displaced(slot.material) for slot in holder.material_slots):
        if modifier.subdivision_type != "SIMPLE":
            report.warn(
                f"Object '{holder.name}': adaptive subdivision without displacement is not supported yet, it is divided as often as "
                "its modifier's levels say"
            )
        return None
    if is_in_units:
        length = max(modifier.adaptive_object_edge_length, LEAST_UNITS)
    else:
        length = max(rate * pixels, LEAST_PIXELS)
    return not is_in_units, length, off_screen, most, min(room.left_triangles(), MOST_TRIANGLES)


def _is_displaced(material: bpy.types.Material | None) -> bool:
    """True if a material moves vertices."""
    if material is None or material.node_tree is None or material.displacement_method == "BUMP":
        return False
    ends = [node for node in material.node_tree.nodes if node.type == "OUTPUT_MATERIAL"]
    return any(end.inputs["Displacement"].is_linked for end in ends)


@contextmanager
def cage(holder: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Iterator[bpy.types.Mesh]:
    """The mesh of an evaluated object before its last modifier, a Subdivision Surface; a rounded one is divided so far that it is round."""
    modifier = holder.modifiers[-1]
    before = modifier.levels, modifier.render_levels
    try:
        is_simple = modifier.subdivision_type == "SIMPLE"
        # Once at least: the vertices of a cage do not lie on the rounded surface.
        level = 0 if is_simple else 1
        while True:
            # Of the evaluated object alone, which is thrown away; Blender runs its modifiers again.
            modifier.levels = modifier.render_levels = level
            made = holder.to_mesh(preserve_all_data_layers=True, depsgraph=depsgraph)
            if is_simple or len(made.polygons) >= ROUND_FACES or level == MOST_LEVELS or not made.polygons:
                break
            level += 1
        yield made
    finally:
        holder.to_mesh_clear()
        modifier.levels, modifier.render_levels = before
