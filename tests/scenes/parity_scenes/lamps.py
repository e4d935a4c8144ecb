# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps of every kind and shape, and meshes that glow."""

from __future__ import annotations

import numpy as np

from support.scenes import image

from . import scene
from .studio import (
    CREAM,
    GOLD,
    GREEN,
    RED,
    WHITE,
    ball,
    cube,
    empty_studio,
    grey_world,
    lamp,
    material,
    monkey,
    plain,
    plane,
    test_card,
)


def _things(**studio) -> None:
    """What the lamps shine on."""
    empty_studio(lit=False, **studio)
    monkey(plain(CREAM, Roughness=0.4), (-0.75, 0.0, 0.85), 1.7, turn=20)
    ball(plain(RED, Roughness=0.2), (1.15, -0.3, 0.8), 0.8)


@scene("Points, sharp and soft")
def point():
    _things(strength=0.03)
    lamp("POINT", 200.0, (-2.0, -2.0, 2.5), colour=(1.0, 0.8, 0.6), shadow_soft_size=0.0)
    lamp("POINT", 120.0, (2.2, -1.0, 2.8), colour=(0.6, 0.8, 1.0), shadow_soft_size=0.4)


@scene("Sun, low and soft")
def sun():
    _things(strength=0.2)
    lamp("SUN", 3.0, (0, 0, 5), (55, -15, -40), (1.0, 0.85, 0.7), angle=np.radians(5.0))


# In the corner that no spot reaches, seeds of Cycles differ by 2.6 % with 1500 samples.
@scene("Spots, hard and soft at the edge", noise=0.03)
def spot():
    _things(strength=0.03)
    lamp("SPOT", 700.0, (-2.5, -2.5, 4.0), (35, -30, 0), spot_size=np.radians(40), spot_blend=0.1, shadow_soft_size=0.05)  # fmt: skip
    lamp("SPOT", 500.0, (2.5, -2.0, 3.5), (35, 35, 0), (0.6, 0.8, 1.0), spot_size=np.radians(60), spot_blend=1.0, shadow_soft_size=0.2)  # fmt: skip


@scene("Area lamps: square, rectangle, disk, ellipse")
def area():
    _things(strength=0.03)
    lamp("AREA", 60.0, (-2.5, -1.5, 2.5), (50, -45, 0), (1, 0.8, 0.6), shape="SQUARE", size=0.6)
    lamp("AREA", 60.0, (2.5, -1.5, 2.5), (50, 45, 0), (0.6, 0.8, 1), shape="RECTANGLE", size=1.5, size_y=0.2)
    lamp("AREA", 60.0, (-0.8, 2.0, 3.0), (-30, 0, 0), (0.7, 1, 0.7), shape="DISK", size=0.8)
    lamp("AREA", 60.0, (1.2, 2.0, 3.0), (-30, 0, 0), (1, 0.7, 0.9), shape="ELLIPSE", size=1.2, size_y=0.4)


@scene("Area lamps that spread little", noise=0.06)
def area_spread():
    _things(strength=0.25)
    lamp("AREA", 120.0, (-1.2, -0.5, 4.0), (8, -8, 0), shape="SQUARE", size=1.2, spread=np.radians(30))
    lamp("AREA", 80.0, (1.6, -0.5, 3.5), (5, 10, 0), (0.6, 0.8, 1), shape="DISK", size=1.0, spread=np.radians(75))


@scene("A mesh that glows by a picture")
def emissive_texture():
    _things(strength=0.03)
    card = image("card", test_card(), space="sRGB")

    def screen(t):
        texture = t.node("TexImage", {"image": card})
        t.shows(t.node("Emission", Color=texture.outputs["Color"], Strength=8.0).outputs[0])

    plane(material(screen), (0.2, 2.0, 1.8), 2.4, (90, 0, 0))


@scene("A hundred small lamps")
def many_lamps():
    _things(strength=0.02)
    turn = np.random.default_rng(5)
    for _ in range(100):
        x, y, z = turn.uniform((-3, -1.5, 1.8), (3, 3, 3.5))
        colour = 0.4 + 0.6 * turn.random(3)
        lamp("POINT", float(turn.uniform(1.0, 12.0)), (x, y, z), colour=tuple(colour), shadow_soft_size=0.05)


@scene("A hundred small meshes that glow", noise=0.02)
def many_emitters():
    _things(strength=0.02)
    turn = np.random.default_rng(6)

    def glow(colour):
        return material(lambda t: t.shows(t.node("Emission", Color=(*colour, 1.0), Strength=25.0).outputs[0]))

    glows = [glow(0.3 + 0.7 * turn.random(3)) for _ in range(6)]
    for i in range(100):
        x, y, z = turn.uniform((-3, -1.5, 1.8), (3, 3, 3.5))
        cube(glows[i % 6], (x, y, z), float(turn.uniform(0.05, 0.12)), float(turn.uniform(0, 90)))


@scene("Lamps that light but do not shine", warns=())
def lamp_shares():
    """Diffuse light without specular light, and the other way about."""
    _things(strength=0.1)
    lamp("AREA", 150.0, (-2.5, -2.0, 3.0), (45, -40, 0), (1, 0.8, 0.6), shape="DISK", size=0.7, specular_factor=0.0)
    lamp("AREA", 150.0, (2.5, -2.0, 3.0), (45, 40, 0), (0.6, 0.8, 1), shape="DISK", size=0.7, diffuse_factor=0.0)


# Cycles' seeds differ by 3 to 4 % in a block, with a third more variance than ours.
@scene("Light from one room into another", noise=0.04)
def indirect():
    empty_studio(lit=False, strength=0.0)
    plane(plain(CREAM), (0, 0.5, 3.0), 8.0)
    plane(plain(GOLD), (-2.6, 0.5, 1.5), 6.0, (0, 90, 0))
    plane(plain(GREEN), (2.6, 0.5, 1.5), 6.0, (0, 90, 0))
    plane(plain(WHITE), (0.0, 1.5, 0.9), 1.8, (90, 0, 0))
    lamp("AREA", 150.0, (0, 2.6, 1.0), (120, 0, 0), shape="SQUARE", size=1.0)
    ball(plain(CREAM), (0.6, -0.3, 0.6), 0.6)
    grey_world(0.02)
