# SPDX-License-Identifier: GPL-3.0-or-later
"""Patterns, images, and the nodes that change colours and numbers."""

from __future__ import annotations

import bpy
import numpy as np

from support.scenes import image

from . import scene
from .studio import (
    BLUE,
    CREAM,
    DARK,
    GOLD,
    GREEN,
    RED,
    WHITE,
    Tree,
    ball,
    cube,
    empty_studio,
    material,
    monkey,
    plain,
    plane,
    test_card,
)

BROWN = (0.25, 0.1, 0.04, 1.0)


def _shown(build, *, coordinates: str = "Object") -> None:
    """A head, a ball and a cube whose colour `build(tree, coordinates)` makes."""
    empty_studio()

    def whole(t: Tree) -> None:
        t.shows(t.principled(Base_Color=build(t, t.coordinates(coordinates)), Roughness=0.5))

    surface = material(whole)
    monkey(surface, (-1.0, 0.3, 0.85), 1.5, turn=20)
    ball(surface, (0.55, -0.6, 0.6), 0.6)
    cube(surface, (1.6, 0.6, 0.6), 1.2)


@scene("Image Texture by UV: clip, extend, repeat")
def image_uv():
    empty_studio()
    card = image("card", test_card(), space="sRGB")

    def sheet(extension, interpolation="Linear"):
        def build(t):
            mapping = t.node("Mapping", Vector=t.coordinates("UV"), Scale=(1.8, 1.8, 1.0), Location=(-0.3, -0.2, 0.0))
            settings = {"image": card, "extension": extension, "interpolation": interpolation}
            t.shows(t.diffuse(t.node("TexImage", settings, Vector=mapping.outputs[0]).outputs["Color"]))

        return material(build)

    plane(sheet("REPEAT"), (-1.4, 0, 0.9), 1.2, (80, 0, 15))
    plane(sheet("CLIP", "Closest"), (0.0, 0, 0.9), 1.2, (80, 0, 0))
    plane(sheet("EXTEND"), (1.4, 0, 0.9), 1.2, (80, 0, -15))


@scene("Image Texture from three sides, as a ball, as a tube")
def image_projections():
    empty_studio()
    card = image("card", test_card(), space="sRGB")

    def thing(projection, **more):
        def build(t):
            settings = {"image": card, "projection": projection, **more}
            t.shows(t.diffuse(t.node("TexImage", settings, Vector=t.coordinates("Object")).outputs["Color"]))

        return material(build)

    cube(thing("BOX", projection_blend=0.3), (-1.4, 0, 0.6), 1.2)
    ball(thing("SPHERE"), (0.0, 0.2, 0.7), 0.7)
    ball(thing("TUBE"), (1.4, 0, 0.65), 0.65)


@scene("Image Texture's alpha as holes")
def image_alpha():
    empty_studio()
    y, x = np.mgrid[0:64, 0:64] / 64.0
    pixels = np.ones((64, 64, 4), np.float32)
    pixels[..., 0], pixels[..., 2] = 0.3 + 0.6 * x, 0.2
    pixels[..., 3] = np.clip(4.0 * (np.sin(20 * x) * np.sin(20 * y)) + 0.5, 0, 1)
    lace = image("lace", pixels, space="sRGB")

    def build(t):
        texture = t.node("TexImage", {"image": lace})
        t.shows(t.principled(Base_Color=texture.outputs["Color"], Alpha=texture.outputs["Alpha"], Roughness=0.7))

    plane(material(build), (0.0, -0.5, 1.2), 2.2, (80, 0, 10))
    monkey(plain(BLUE), (0.0, 1.2, 1.0), 1.6)


@scene("Images of other colour spaces")
def image_colour_spaces():
    empty_studio()

    def sheet(space, is_float=False):
        card = image(f"card {space}", test_card(), space=space, is_float=is_float)
        return material(lambda t: t.shows(t.diffuse(t.node("TexImage", {"image": card}).outputs["Color"])))

    plane(sheet("sRGB"), (-1.5, 0, 0.9), 1.3, (80, 0, 15))
    plane(sheet("Non-Color"), (0.0, 0, 0.9), 1.3, (80, 0, 0))
    plane(sheet("ACEScg", is_float=True), (1.5, 0, 0.9), 1.3, (80, 0, -15))


@scene("A missing image is magenta", warns=("gone.png",))
def image_missing():
    empty_studio()
    gone = bpy.data.images.new("gone", 4, 4)
    gone.source, gone.filepath = "FILE", "//nowhere/gone.png"
    lost = material(lambda t: t.shows(t.diffuse(t.node("TexImage", {"image": gone}).outputs["Color"])))
    monkey(lost, turn=20)


@scene("Marble: noise through a ramp")
def noise_ramp():
    def marble(t, where):
        noise = t.node("TexNoise", Vector=where, Scale=2.5, Detail=6.0, Roughness=0.6, Distortion=1.2)
        return t.ramp(noise.outputs[0], (0.35, DARK), (0.5, CREAM), (0.7, WHITE))

    _shown(marble)


@scene("Noise of the Musgrave kinds")
def noise_kinds():
    def ridges(t, where):
        settings = {"noise_type": "RIDGED_MULTIFRACTAL", "normalize": False}
        ridged = t.node("TexNoise", settings, Vector=where, Scale=1.5, Detail=4.0)
        settings = {"noise_type": "HETERO_TERRAIN", "normalize": False}
        terrain = t.node("TexNoise", settings, Vector=where, Scale=3.0, Detail=3.0)
        return t.mixed_colour(t.math("MULTIPLY", ridged.outputs[0], 0.4), BROWN, terrain.outputs["Color"])

    _shown(ridges)


@scene("Voronoi: cells, edges, smooth")
def voronoi():
    def stones(t, where):
        cells = t.node("TexVoronoi", Vector=where, Scale=3.0)
        edges = t.node("TexVoronoi", {"feature": "DISTANCE_TO_EDGE"}, Vector=where, Scale=3.0)
        joint = t.math("LESS_THAN", edges.outputs["Distance"], 0.06)
        return t.mixed_colour(joint, cells.outputs["Color"], DARK)

    _shown(stones)


@scene("Wood: waves in rings")
def wave():
    def wood(t, where):
        settings = {"wave_type": "RINGS", "rings_direction": "X", "wave_profile": "SAW"}
        rings = t.node("TexWave", settings, Vector=where, Scale=2.0, Distortion=3.0, Detail=2.0)
        return t.ramp(rings.outputs["Color"], (0.0, BROWN), (1.0, (0.6, 0.32, 0.12, 1.0)))

    _shown(wood)


@scene("Bricks and a checker")
def bricks_checker():
    def build(t):
        bricks = t.node("TexBrick", Vector=t.coordinates("UV"), Scale=4.0, Color1=RED, Color2=BROWN, Mortar=CREAM)
        t.shows(t.diffuse(bricks.outputs["Color"]))

    def checker(t):
        squares = t.node("TexChecker", Vector=t.coordinates("UV"), Scale=16.0, Color1=CREAM, Color2=GREEN)
        t.shows(t.principled(Base_Color=squares.outputs["Color"], Roughness=0.15))

    empty_studio(floor=material(checker))
    cube(material(build), (0.0, 0.0, 0.9), 1.8)


@scene("Magic and gradients")
def magic_gradient():
    def both(t, where):
        magic = t.node("TexMagic", Vector=where, Scale=2.0, Distortion=1.5)
        sphere = t.node("TexGradient", {"gradient_type": "SPHERICAL"}, Vector=where)
        return t.mixed_colour(sphere.outputs["Fac"], magic.outputs["Color"], GOLD)

    _shown(both)


@scene("White noise in squares")
def white_noise():
    def squares(t, where):
        snapped = t.node("VectorMath", {"operation": "SNAP"}, _0=where, _1=(0.25, 0.25, 0.25))
        return t.node("TexWhiteNoise", Vector=snapped.outputs[0]).outputs["Color"]

    # Inside of the cells, not on their faces.
    def moved(t, where):
        return squares(t, t.node("VectorMath", _0=where, _1=(0.11, 0.07, 0.13)).outputs[0])

    _shown(moved)


@scene("Hue, brightness, gamma, inverse, curves")
def colour_nodes():
    def changed(t, where):
        colour = t.node("TexVoronoi", Vector=where, Scale=2.0).outputs["Color"]
        colour = t.node("HueSaturation", Hue=0.6, Saturation=0.8, Value=0.9, Color=colour).outputs[0]
        colour = t.node("BrightContrast", Color=colour, Bright=0.05, Contrast=0.2).outputs[0]
        colour = t.node("Gamma", Color=colour, Gamma=1.4).outputs[0]
        colour = t.node("Invert", Fac=0.3, Color=colour).outputs[0]
        curves = t.node("RGBCurve", Color=colour)
        curves.mapping.curves[3].points.new(0.4, 0.55)
        curves.mapping.update()
        return curves.outputs[0]

    _shown(changed)


@scene("Colours mixed in every usual way")
def colour_mixes():
    def mixed(t, where):
        noise = t.node("TexNoise", Vector=where, Scale=3.0).outputs["Color"]
        colour = t.mixed_colour(0.7, noise, GOLD, "OVERLAY")
        colour = t.mixed_colour(0.5, colour, BLUE, "SCREEN")
        colour = t.mixed_colour(0.6, colour, noise, "DIFFERENCE")
        colour = t.mixed_colour(0.5, colour, CREAM, "SOFT_LIGHT")
        return t.mixed_colour(0.4, colour, RED, "COLOR")

    _shown(mixed)


@scene("Blackbody and numbers mapped to ranges")
def blackbody():
    def hot(t, where):
        height = t.node("SeparateXYZ", Vector=where).outputs["Z"]
        settings = {"interpolation_type": "SMOOTHSTEP"}
        kelvin = t.node("MapRange", settings, Value=height, From_Min=-0.8, From_Max=0.8, To_Min=1500.0, To_Max=9000.0)
        return t.mixed_colour(0.7, GREEN, t.node("Blackbody", Temperature=kelvin.outputs[0]).outputs[0], "MULTIPLY")

    _shown(hot)


@scene("Groups in groups, one node muted")
def groups():
    inner = bpy.data.node_groups.new("Inner", "ShaderNodeTree")
    outer = bpy.data.node_groups.new("Outer", "ShaderNodeTree")
    for group in (inner, outer):
        group.interface.new_socket("Vector", in_out="INPUT", socket_type="NodeSocketVector")
        group.interface.new_socket("Color", in_out="OUTPUT", socket_type="NodeSocketColor")
    t = Tree(inner, None)
    taken, given = inner.nodes.new("NodeGroupInput"), inner.nodes.new("NodeGroupOutput")
    noise = t.node("TexNoise", Vector=taken.outputs[0], Scale=4.0)
    inner.links.new(t.ramp(noise.outputs[0], (0.4, BLUE), (0.6, CREAM)), given.inputs[0])
    t = Tree(outer, None)
    taken, given = outer.nodes.new("NodeGroupInput"), outer.nodes.new("NodeGroupOutput")
    nested = t.node("Group", {"node_tree": inner}, _0=taken.outputs[0])
    muted = t.node("Invert", Color=nested.outputs[0])
    muted.mute = True
    outer.links.new(muted.outputs[0], given.inputs[0])
    _shown(lambda t, where: t.node("Group", {"node_tree": outer}, _0=where).outputs[0])
