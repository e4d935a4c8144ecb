# SPDX-License-Identifier: GPL-3.0-or-later
"""Geometry of other kinds than a mesh of one material, and the demo scene."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np

from . import scene
from .studio import BLUE, CREAM, GOLD, GREEN, RED, ball, empty_studio, lamp, monkey, plain, put


@scene("Text and curves")
def text_curves():
    empty_studio()
    text = bpy.data.curves.new("Text", "FONT")
    text.body, text.extrude, text.bevel_depth, text.align_x = "f/1.35", 0.08, 0.02, "CENTER"
    text.materials.append(plain(RED, Roughness=0.3))
    put(bpy.data.objects.new("Text", text), (0.0, -0.8, 0.3), (80, 0, 0), 1.1)
    bpy.ops.curve.primitive_bezier_circle_add(radius=0.8, location=(0.0, 0.8, 1.3), rotation=(1.2, 0.3, 0.0))
    ring = bpy.context.object.data
    ring.bevel_depth = 0.15
    ring.materials.append(plain(GOLD, Metallic=1.0, Roughness=0.3))


@scene("Metaballs and a surface")
def metaballs():
    empty_studio()
    bpy.ops.object.metaball_add(type="BALL", radius=0.9, location=(-1.2, 0.2, 0.8))
    first = bpy.context.object
    first.data.materials.append(plain(GREEN, Roughness=0.3))
    first.data.render_resolution = 0.1
    second = first.data.elements.new()
    second.co, second.radius = (0.8, -0.2, 0.1), 0.7
    bpy.ops.surface.primitive_nurbs_surface_torus_add(radius=0.8, location=(1.2, 0.2, 0.7), rotation=(0.9, 0.2, 0.0))
    bpy.context.object.data.materials.append(plain(CREAM))


@scene("Several materials and flat, smooth and sharp faces")
def faces():
    empty_studio()
    head = monkey(plain(CREAM), (-0.9, 0.0, 0.85), 1.6, turn=20, levels=0)
    head.data.materials.append(plain(RED, Roughness=0.2))
    index = (np.arange(len(head.data.polygons)) % 7 < 2).astype(np.int32)
    head.data.polygons.foreach_set("material_index", index)
    bpy.ops.mesh.primitive_cylinder_add(
        vertices=24, radius=0.7, depth=1.3, location=(1.1, 0.0, 0.75), rotation=(0.5, 0.3, 0)
    )
    bpy.ops.object.shade_smooth_by_angle(angle=np.radians(40))
    bpy.context.object.data.materials.append(plain(BLUE, Roughness=0.3))


@scene("Shadow terminators: left alone, lifted more, dimmed")
def terminators():
    """Coarse balls, smooth, lit from the side."""
    empty_studio(lit=False, strength=0.05)
    lamp("SUN", 3.0, (0, 0, 4), (0, 75, 20), angle=np.radians(2.0))
    for i, (geometry, shading) in enumerate(((0.0, 0.0), (0.5, 0.0), (0.1, 0.6))):
        bpy.ops.mesh.primitive_uv_sphere_add(segments=10, ring_count=6, radius=0.75, location=(1.7 * i - 1.7, 0, 0.75))
        bpy.ops.object.shade_smooth()
        holder = bpy.context.object
        holder.data.materials.append(plain((CREAM, BLUE, GREEN)[i], Roughness=0.4))
        own = holder if hasattr(holder, "shadow_terminator_geometry_offset") else holder.cycles
        own.shadow_terminator_geometry_offset = geometry
        if own is holder:
            own.shadow_terminator_shading_offset = shading
        else:
            own.shadow_terminator_offset = shading


@scene("Instances of a collection, and by particles")
def instances():
    empty_studio()
    group = bpy.data.collections.new("Tree")
    stem = ball(plain((0.3, 0.15, 0.06, 1.0)), (0.0, 0.0, 0.25), 0.25)
    crown = ball(plain(GREEN), (0.0, 0.0, 0.7), 0.4)
    for part in (stem, crown):
        group.objects.link(part)
        bpy.context.scene.collection.objects.unlink(part)
    for i in range(12):
        empty = bpy.data.objects.new("Instance", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", group
        put(empty, (-2.2 + 1.1 * (i % 5), -0.8 + 1.2 * (i // 5), 0.0), (0, 0, 40 * i), 0.7 + 0.05 * i)


@scene("Mirrored, stretched and turned objects")
def transforms():
    empty_studio()
    head = monkey(plain(GOLD, Roughness=0.3), (-1.2, 0.0, 0.9), 1.4, turn=25)
    for i, scale in enumerate([(-1.0, 1.0, 1.0), (1.3, 0.5, 0.8)]):
        put(head.copy(), (0.2 + 1.5 * i, 0.2, 0.9), (0, 15, 25), scale)


# Caustics of both: seeds of Cycles differ by 8 % in a block, and by 0.8 % of 1024 samples.
@scene("The demo scene", noise=0.1)
def demo():
    bpy.ops.wm.open_mainfile(filepath=str(Path(__file__).parent.parent / "demo.blend"), load_ui=False)
