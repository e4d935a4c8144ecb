# SPDX-License-Identifier: GPL-3.0-or-later
"""Light from all around: images, skies, nodes."""

from __future__ import annotations

import bpy
import numpy as np

from support.scenes import image

from . import scene
from .studio import CREAM, GOLD, RED, WHITE, Tree, ball, empty_studio, monkey, plain, world


def _under(build) -> None:
    """Things under a world, without a wall to hide it."""
    empty_studio(lit=False)
    wall = next(one for one in bpy.data.objects if one.type == "MESH" and one.location.y > 3)
    bpy.data.objects.remove(wall)
    world(build)
    monkey(plain(CREAM, Roughness=0.4), (-0.75, 0.0, 0.85), 1.7, turn=20)
    ball(plain(GOLD, Metallic=1.0, Roughness=0.35), (1.15, -0.3, 0.8), 0.8)


def _panorama():
    """A sky with clouds, land, and a sun that is bright."""
    y, x = np.mgrid[0:128, 0:256]
    turn, height = 2.0 * np.pi * x / 256, np.pi * (y / 128 - 0.5)
    pixels = np.ones((128, 256, 4), np.float32)
    above = np.clip(height * 6, 0, 1)[..., None]
    sky = np.stack([0.25 + 0.1 * np.cos(3 * turn), 0.4 + 0.1 * np.cos(3 * turn), 0.9 + 0 * turn], 2)
    land = np.stack([0.2 + 0.1 * np.sin(9 * turn), 0.15 + 0 * turn, 0.08 + 0 * turn], 2)
    pixels[..., :3] = above * sky + (1 - above) * land
    apart = (turn - 4.2) ** 2 + (height - 0.8) ** 2
    pixels[..., :3] += np.array([900.0, 800.0, 600.0]) * (apart < 0.002)[..., None]
    return image("panorama", pixels, is_float=True, space="Linear Rec.709")


@scene("A panorama with a sun in it")
def hdri():
    panorama = _panorama()

    def build(t: Tree):
        where = t.node("Mapping", Vector=t.coordinates("Generated"), Rotation=(0.0, 0.0, 0.7))
        texture = t.node("TexEnvironment", {"image": panorama}, Vector=where.outputs[0])
        t.shows(t.node("Background", Color=texture.outputs["Color"], Strength=1.0).outputs[0])

    _under(build)


@scene("Preetham's sky")
def preetham():
    def build(t: Tree):
        sky = t.node("TexSky", {"sky_type": "PREETHAM", "turbidity": 3.0, "sun_direction": (0.4, -0.3, 0.6)})
        t.shows(t.node("Background", Color=sky.outputs[0], Strength=0.15).outputs[0])

    _under(build)


@scene("Hosek and Wilkie's sky")
def hosek():
    def build(t: Tree):
        sky = t.node("TexSky", {"sky_type": "HOSEK_WILKIE", "turbidity": 4.0, "sun_direction": (0.4, -0.3, 0.6)})
        t.shows(t.node("Background", Color=sky.outputs[0], Strength=1.5).outputs[0])

    _under(build)


@scene("A sky of scattered light, and its sun", noise=0.025)
def scattering():
    def build(t: Tree):
        older = "SINGLE_SCATTERING" not in bpy.types.ShaderNodeTexSky.bl_rna.properties["sky_type"].enum_items
        settings = {"sky_type": "NISHITA" if older else "MULTIPLE_SCATTERING", "sun_rotation": 2.4, "sun_size": 0.02}
        sky = t.node("TexSky", {**settings, "sun_elevation": 0.5})
        t.shows(t.node("Background", Color=sky.outputs[0], Strength=0.06).outputs[0])

    _under(build)


@scene("A sky of nodes: gradient and clouds")
def nodes():
    def build(t: Tree):
        where = t.coordinates("Generated")
        height = t.node("SeparateXYZ", Vector=where).outputs["Z"]
        clouds = t.node("TexNoise", Vector=where, Scale=3.0, Detail=4.0).outputs[0]
        base = t.ramp(height, (0.0, (0.1, 0.06, 0.04, 1.0)), (0.1, (0.9, 0.6, 0.4, 1.0)), (0.6, (0.1, 0.25, 0.6, 1.0)))
        t.shows(t.node("Background", Color=t.mixed_colour(t.math("MULTIPLY", clouds, 0.8), base, WHITE)).outputs[0])

    _under(build)


@scene("A backdrop for the camera alone")
def camera_backdrop():
    def build(t: Tree):
        seen = t.node("LightPath").outputs["Is Camera Ray"]
        light = t.node("Background", Color=CREAM, Strength=0.8).outputs[0]
        t.shows(t.mix(seen, light, t.node("Background", Color=RED, Strength=0.3).outputs[0]))

    _under(build)


@scene("A plain colour")
def plain_world():
    _under(lambda t: t.shows(t.node("Background", Color=(0.6, 0.75, 1.0, 1.0), Strength=0.7).outputs[0]))
