# SPDX-License-Identifier: GPL-3.0-or-later
"""A room, a table close by, and a chart."""

from __future__ import annotations

import bpy
import numpy as np

from parity_scenes.studio import (
    BLUE,
    GOLD,
    GREEN,
    RED,
    ball,
    cube,
    grey_world,
    lamp,
    material,
    monkey,
    plain,
    plane,
)
from support.scenes import image

from . import scene
from .outdoors import camera_at, glowing


@scene("Room: a window's light, things from one metre to six", focus_m=2.2)
def room():
    grey_world(0.05)
    plane(plain((0.35, 0.2, 0.1, 1.0), Roughness=0.3), (0, 3, 0), 8.0)
    plane(plain((0.7, 0.68, 0.62, 1.0)), (0, 6.5, 2), 9.0, (90, 0, 0))
    plane(plain((0.45, 0.5, 0.6, 1.0)), (-3.2, 3, 2), 8.0, (0, 90, 0))
    plane(plain((0.6, 0.55, 0.5, 1.0)), (3.2, 3, 2), 8.0, (0, -90, 0))
    lamp("AREA", 250.0, (2.8, 2.5, 2.2), (0, 75, 0), (1.0, 0.95, 0.85), shape="RECTANGLE", size=1.6, size_y=2.2)
    monkey(plain(GOLD, Roughness=0.25), (0.1, 2.2, 1.25), 0.7, turn=10)
    ball(plain((0.9, 0.9, 0.9, 1.0), Metallic=1.0, Roughness=0.08), (-0.6, 2.8, 0.95), 0.3)
    cube(plain(BLUE), (0.0, 2.4, 0.45), 0.9, turn=15)
    ball(plain(RED, Roughness=0.2), (0.55, 1.2, 1.0), 0.16)
    for i in range(10):
        cube(plain((RED, GREEN, BLUE, GOLD)[i % 4]), (-1.6 + 0.35 * i, 6.1, 1.0 + 0.9 * (i % 2)), 0.3, turn=7 * i)
    camera_at(1.4, -5.0)


@scene("Macro: small things a hand's breadth away, before soft light", focus_m=0.35)
def macro():
    grey_world(0.5)
    plane(plain((0.12, 0.1, 0.1, 1.0), Roughness=0.25), (0, 0.5, -0.03), 2.0)
    lamp("AREA", 1.2, (-0.3, 0.2, 0.4), (35, -40, 0), shape="RECTANGLE", size=0.3, size_y=0.2)
    random = np.random.default_rng(7)
    shiny = [plain(colour, Roughness=0.15) for colour in (RED, GREEN, BLUE, GOLD)]
    for i in range(40):
        y = random.uniform(0.22, 0.9)
        x = random.uniform(-0.4, 0.4) * y
        radius = random.uniform(0.004, 0.012)
        bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=radius, location=(x, y, radius - 0.03))
        bpy.ops.object.shade_smooth()
        bpy.context.object.data.materials.append(shiny[i % 4])
    monkey(plain(GOLD, Metallic=1.0, Roughness=0.25), (0.0, 0.35, -0.005), 0.06, turn=20)
    for i in range(12):
        bpy.ops.mesh.primitive_uv_sphere_add(
            segments=12, ring_count=8, radius=0.004, location=(0.05 * (i - 6) + 0.02, 1.3, 0.05 + 0.06 * (i % 3))
        )
        lit = bpy.context.object
        lit.data.materials.append(glowing((1.0, 0.9, 0.7), 25.0))
        lit.visible_diffuse = lit.visible_glossy = False
    camera_at(0.03, -3.0)


@scene("Chart: a flat test card two metres away, lines and edges to its corners", focus_m=2.0)
def chart():
    grey_world(1.0)
    size = 512
    y, x = np.mgrid[0:size, 0:size] / size
    lines = ((x * 16) % 1.0 < 0.08) | ((y * 16) % 1.0 < 0.08)
    squares = (np.floor(x * 16) + np.floor(y * 16)) % 2
    grey = np.where(lines, 0.02, 0.35 + 0.45 * squares)
    pixels = np.stack([grey, grey, grey, np.ones_like(grey)], 2)
    for i, colour in enumerate(((0.8, 0.1, 0.1), (0.1, 0.6, 0.15), (0.1, 0.15, 0.7))):
        pixels[(abs(x - 0.25 - 0.25 * i) < 0.02) & (abs(y - 0.5) < 0.2), :3] = colour
    card = image("Card", pixels, is_float=True, space="Non-Color")

    def shown(t):
        uv = t.node("TexCoord").outputs["UV"]
        picture = t.node("TexImage", {"image": card, "interpolation": "Closest"}, Vector=uv).outputs["Color"]
        t.shows(t.diffuse(picture))

    plane(material(shown), (0, 2.0, 0), 4.0, (90, 0, 0))
    camera_at(0.0)
