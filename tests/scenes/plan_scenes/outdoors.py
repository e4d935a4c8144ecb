# SPDX-License-Identifier: GPL-3.0-or-later
"""Far away, by day and by night."""

from __future__ import annotations

import bpy
import numpy as np

from parity_scenes.studio import cube, grey_world, lamp, material, plain, plane, put, world

from . import scene

_SKY = (0.35, 0.55, 0.95, 1.0)


def camera_at(height_m: float, pitch_degrees: float = 0.0) -> None:
    """Looks along +y, from so high, up by so many degrees."""
    made = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    made.data.clip_start, made.data.clip_end = 0.005, 1e5
    bpy.context.scene.camera = put(made, (0.0, 0.0, height_m), (90.0 + pitch_degrees, 0.0, 0.0))


def glowing(colour, strength: float):
    return material(lambda t: t.shows(t.node("Emission", Color=(*colour, 1.0), Strength=strength).outputs[0]))


@scene("Landscape: hills and trees against the sky, the sun; all of it far away", focus_m=None)
def landscape():
    def sky(t):
        up = t.node("SeparateXYZ", Vector=t.coordinates("Generated")).outputs["Z"]
        colour = t.ramp(up, (0.0, (0.85, 0.85, 0.8, 1.0)), (0.5, _SKY))
        t.shows(t.node("Background", Color=colour, Strength=1.0).outputs[0])

    world(sky)
    lamp("SUN", 3.0, (0, 0, 50), (50, 20, 0), (1.0, 0.95, 0.85), angle=0.009)
    plane(plain((0.2, 0.28, 0.1, 1.0), Roughness=0.9), (0, 2000, -2), 6000.0)
    random = np.random.default_rng(3)
    trunk, leaves, snow = plain((0.08, 0.05, 0.03, 1.0)), plain((0.06, 0.14, 0.04, 1.0)), plain((0.85, 0.87, 0.9, 1.0))
    for i in range(24):
        x, y = random.uniform(-0.8, 0.8), random.uniform(120, 400)
        size = random.uniform(4.0, 9.0)
        bpy.ops.mesh.primitive_cylinder_add(
            vertices=6, radius=0.05 * size, depth=size, location=(x * y, y, size / 2 - 2)
        )
        bpy.context.object.data.materials.append(trunk)
        bpy.ops.mesh.primitive_cone_add(vertices=9, radius1=0.35 * size, depth=1.2 * size, location=(x * y, y, size))
        bpy.context.object.data.materials.append((leaves, snow)[i % 5 == 0])
    for i in range(9):
        y, height = 2500 + 200 * (i % 3), random.uniform(150, 700)
        x = (i - 4) * 550 + random.uniform(-100, 100)
        bpy.ops.mesh.primitive_cone_add(vertices=7, radius1=1.3 * height, depth=height, location=(x, y, height / 2 - 2))
        bpy.context.object.data.materials.append(snow if height > 350 else plain((0.25, 0.24, 0.28, 1.0)))
    camera_at(6.0, 3.0)


@scene("Night street: lamps and lit windows before the dark, near and far", focus_m=8.0)
def night_street():
    grey_world(0.02, (0.3, 0.45, 1.0, 1.0))
    plane(plain((0.06, 0.06, 0.07, 1.0), Roughness=0.35), (0, 40, 0), 200.0)
    random = np.random.default_rng(5)
    walls = [plain(colour) for colour in ((0.35, 0.2, 0.15, 1.0), (0.3, 0.3, 0.28, 1.0), (0.2, 0.22, 0.3, 1.0))]
    panes = [glowing(colour, 1.5) for colour in ((1.0, 0.75, 0.4), (1.0, 0.9, 0.7), (0.5, 0.7, 1.0))]
    for side in (-1.0, 1.0):
        for i in range(6):
            y = 5.0 + 8.0 * i
            house = cube(walls[i % 3], (side * 7.0, y, 4.0), 1.0, turn=0.0)
            house.scale = (6.0, 7.5, 8.0)
            for floor in range(3):
                for column in range(3):
                    if random.random() < 0.6:
                        pane = plane(
                            panes[(i + floor) % 3], (side * 3.99, y - 2.2 + 2.2 * column, 1.6 + 2.4 * floor), 1.0
                        )
                        pane.rotation_euler = (0.0, -side * np.pi / 2, 0.0)
                        pane.scale = (1.2, 0.8, 1.0)
    # Bulbs small enough to be points in the picture, bright enough to show what the lens makes of points; each with a
    # lamp in it, so that they light the street without the noise of small bright meshes.
    for i in range(7):
        x, y = (-2.6, 2.6)[i % 2], 4.0 + 6.0 * i
        bpy.ops.mesh.primitive_uv_sphere_add(segments=12, ring_count=8, radius=0.07, location=(x, y, 3.6))
        bulb = bpy.context.object
        bulb.data.materials.append(glowing((1.0, 0.8, 0.5), 60.0))
        bulb.visible_diffuse = bulb.visible_glossy = bulb.visible_shadow = False
        lamp("POINT", 120.0, (x, y, 3.6), colour=(1.0, 0.8, 0.5), shadow_soft_size=0.3)
    camera_at(1.7, 4.0)
