# SPDX-License-Identifier: GPL-3.0-or-later
"""The noise of light from lamps beside that of Cycles in the same Blender, at equal samples, by number and kind of lights, on
surfaces that are partly transparent, in bodies, and on floors."""

from __future__ import annotations

import math

import numpy as np
import pytest

pytestmark = pytest.mark.once

SIDE, SEEDS = 64, 3
#: Of a variance from 3 seeds of 64 x 64 pixels and 3 colours, which go together: 1.5 % each; of a ratio of two a tenth is far off.
WITHIN = 1.2
#: From so many samples a pixel on half the side is enough: 3 % each, a fifth is far off a ratio of two.
MANY, FEWER = 256, 32


def suns(*rows):
    """(W/m², angle, tilt, turn), rad."""
    return [
        ("SUN", {"energy": energy, "angle": angle}, (0, 0, 0), (tilt, 0, turn)) for energy, angle, tilt, turn in rows
    ]


def points(places, radius, watts):
    return [("POINT", {"energy": watts, "shadow_soft_size": radius}, (x, y, 2), (0, 0, 0)) for x, y in places]


SQUARE = [(x, y) for x in (-2, 2) for y in (-2, 2)]
GRID = [(x, y) for x in (-3, -1, 1, 3) for y in (-3, -1, 1, 3)]
#: Lights, and the brightness of the world.
CASES = {
    "two suns": (suns((1, 0.2, 0.6, 0), (0.3, 0.009, -0.9, 0)), 0.0),
    "four suns": (suns((1, 0.1, 0.3, 0), (2, 0.1, 0.8, 1), (3, 0.1, 1.1, 2), (4, 0.1, 1.3, 4)), 0.0),
    "four points": (points(SQUARE, 0.5, 100), 0.0),
    "sixteen points in a grey world": (points(GRID, 0.2, 60), 0.5),
    "a sun and four points": ([*suns((1, 0.1, 0.5, 0)), *points(SQUARE, 0.3, 60)], 0.0),
}


@pytest.fixture
def stage(blender):
    """A diffuse plane seen from above."""
    from support import scenes as parts

    scene = parts.set_up(SIDE, SIDE, 16)
    blender.ops.mesh.primitive_plane_add(size=40)
    scene.camera.location, scene.camera.rotation_euler = (0, -6, 6), (math.pi / 4, 0, 0)
    scene.camera.data.lens = 35
    return scene


def variance(folder, engine: str, samples: int, by_channel: bool = False) -> tuple[float, float]:
    """Of a pixel, relative to the square of the picture's mean, or of each channel's, and the mean."""
    import bpy

    from support import beside_cycles

    scene, pictures = bpy.context.scene, []
    scene.render.resolution_x = scene.render.resolution_y = SIDE if samples < MANY else FEWER
    for seed in range(SEEDS):
        beside_cycles.prepare(samples)
        scene.petzval.seed = scene.cycles.seed = seed
        # Pixels of a square that shares a sequence are one draw: the variance of a pixel would have a noise of a fifth.
        scene.petzval.use_blue_noise = False
        pictures.append(beside_cycles.take(folder, engine).astype(np.float64))
    taken = np.stack(pictures)
    means = taken.mean((0, 1, 2)) if by_channel else taken.mean()
    return float((taken.var(0, ddof=1) / means**2).mean()), float(taken.mean())


@pytest.mark.parametrize("name", CASES)
def test_several_lights_are_no_noisier_than_in_cycles(stage, blender, tmp_path, name):
    from support import scenes as parts

    lights, grey = CASES[name]
    for kind, settings, place, turn in lights:
        data = blender.data.lights.new(name, kind)
        for key, value in settings.items():
            setattr(data, key, value)
        lamp = blender.data.objects.new(name, data)
        lamp.location, lamp.rotation_euler = place, turn
        blender.context.collection.objects.link(lamp)
    stage.world = parts.grey_world(grey)
    stage.cycles.use_light_tree = True
    assert_no_noisier(tmp_path, name, (16, 64, 256), WITHIN)


def assert_no_noisier(
    folder, name: str, samples: tuple[int, ...], within: float, by_channel: bool = False, alike: float = 0.005
) -> None:
    """At each of these samples a pixel the variance is that of Cycles, times `within` at most, and the means are `alike`."""
    for count in samples:
        ours, our_mean = variance(folder, "PETZVAL", count, by_channel)
        theirs, their_mean = variance(folder, "CYCLES", count, by_channel)
        print(f"{name}, {count} samples: {ours:.3g} / {theirs:.3g} = {ours / theirs:.2f}")
        assert our_mean == pytest.approx(their_mean, rel=alike)
        assert ours < within * theirs, f"{count} samples: {ours / theirs:.2f} of Cycles' variance"


#: A closure, by its node and the inputs that are set, the part of the light that passes, and the strength of a sun.
VEILS = {
    "half diffuse": ("ShaderNodeBsdfDiffuse", {}, 0.5, 2.0),
    "a tenth translucent": ("ShaderNodeBsdfTranslucent", {}, 0.9, 2.0),
    "a tenth passes the dark": ("ShaderNodeBsdfTranslucent", {"Color": (0.05, 0.05, 0.05, 1.0)}, 0.12, 2.0),
    # By itself: Cycles does not choose so weak a mesh among its lights.
    "a tenth glows": ("ShaderNodeEmission", {"Strength": 3.0}, 0.9, 0.0),
}


@pytest.mark.parametrize("name", VEILS)
def test_partly_transparent_surfaces_are_no_noisier_than_in_cycles(stage, blender, tmp_path, name):
    """The light sample and the emission of a surface do not depend on whether a path passes, which it does the likelier the darker the
    rest of the surface is."""
    kind, inputs, passed, strength = VEILS[name]
    ball_under_a_sun(stage, blender, kind, inputs, passed, strength)
    assert_no_noisier(tmp_path, name, (16, 64), 1.0)


#: Subsurface Scattering: colour, radius by channel, scale and anisotropy.
BODIES = {
    "wax": {"Color": (0.8, 0.6, 0.4, 1.0), "Radius": (1.0, 1.0, 1.0), "Scale": 0.1},
    "dark": {"Color": (0.4, 0.3, 0.2, 1.0), "Radius": (1.0, 0.2, 0.1), "Scale": 0.3},
    "forward": {"Color": (0.8, 0.6, 0.4, 1.0), "Radius": (1.0, 0.5, 0.3), "Scale": 0.3, "Anisotropy": 0.6},
}


@pytest.mark.parametrize("name", BODIES)
def test_bodies_are_no_noisier_than_in_cycles(stage, blender, tmp_path, name):
    """Random walks are guided to the surface."""
    ball_under_a_sun(stage, blender, "ShaderNodeSubsurfaceScattering", BODIES[name], 0.0, 2.0)
    assert_no_noisier(tmp_path, name, (16, 64), WITHIN)


#: What a floor is made of under a smooth sky: a closure, its inputs, its distribution, and how far down from level it is seen.
FLOORS = {
    # Its pixels are dark, so its paths are not faint: they end by chance no sooner than those of a bright floor.
    "dark": ("ShaderNodeBsdfDiffuse", {"Color": (0.04, 0.04, 0.04, 1.0)}, None, math.pi / 4),
    # Of its facets only those count that are seen from so low.
    "beckmann from low": ("ShaderNodeBsdfAnisotropic", {"Roughness": 0.3}, "BECKMANN", 0.1),
}


@pytest.mark.parametrize("name", FLOORS)
def test_floors_under_a_sky_are_no_noisier_than_in_cycles(stage, blender, tmp_path, name):
    """The sky's pixels are interpolated, and it is sampled by smaller cells."""
    from support import scenes as parts

    kind, inputs, distribution, down = FLOORS[name]
    stage.camera.location, stage.camera.rotation_euler = (0, -6, 6 * math.tan(down)), (math.pi / 2 - down, 0, 0)
    # The floor, and no sky, fills the picture.
    stage.camera.data.lens = 35 if down > 0.5 else 300
    blender.context.object.scale = (1.0, 1.0, 1.0) if down > 0.5 else (10.0, 10.0, 1.0)
    material = blender.data.materials.new("Floor")
    material.use_nodes = True
    tree = material.node_tree
    closure = tree.nodes.new(kind)
    for key, value in inputs.items():
        closure.inputs[key].default_value = value
    if distribution:
        closure.distribution = distribution
    tree.links.new(closure.outputs[0], tree.get_output_node("CYCLES").inputs["Surface"])
    blender.context.object.data.materials.append(material)
    # Bright to one side, and never dark.
    image = blender.data.images.new("Sky", 64, 32, float_buffer=True)
    turn, height = np.meshgrid(np.arange(64) / 64.0, np.arange(32) / 32.0)
    light = 0.3 + 0.7 * height * (0.5 + 0.5 * np.cos(2.0 * np.pi * turn))
    image.pixels.foreach_set(np.dstack([light, light, light, np.ones_like(light)]).astype(np.float32).ravel())
    stage.world = parts.grey_world(1.0)
    sky = stage.world.node_tree
    texture = sky.nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    sky.links.new(texture.outputs["Color"], sky.nodes["Background"].inputs["Color"])
    # At 256 samples so few pixels are taken that a limit could not be told from noise.
    assert_no_noisier(tmp_path, name, (16, 64), WITHIN)


def test_gloss_on_a_saturated_colour_is_no_noisier_than_in_cycles(stage, blender, tmp_path):
    """Red and blue come from the gloss alone, so the gloss is chosen by the mean of the channels: by luminance, which is high for
    green, it would be chosen half as often. Of each channel the relative variance counts."""
    from support import scenes as parts

    material = blender.data.materials.new("Floor")
    material.use_nodes = True
    principled = material.node_tree.nodes["Principled BSDF"]
    for key, value in {"Base Color": (0.008, 0.8, 0.005, 1.0), "Roughness": 0.5, "IOR": 1.5}.items():
        principled.inputs[key].default_value = value
    blender.context.object.data.materials.append(material)
    stage.camera.location, stage.camera.rotation_euler = (0, -6, 1.6), (math.pi / 2 - 0.26, 0, 0)
    stage.camera.data.lens, blender.context.object.scale = 300, (10.0, 10.0, 1.0)
    stage.world = parts.grey_world(0.5)
    # Both approximate what facets send on to other facets, and differ by half of the 1 % within which materials count as alike.
    assert_no_noisier(tmp_path, "saturated gloss", (16, 64), WITHIN, by_channel=True, alike=0.01)


def ball_under_a_sun(stage, blender, kind: str, inputs: dict, passed: float, strength: float) -> None:
    """A ball of a closure that lets a part of the light pass, in the sun and a grey world."""
    from support import scenes as parts

    blender.ops.mesh.primitive_uv_sphere_add(radius=1.5, location=(0, -0.5, 1.6))
    material = blender.data.materials.new("Ball")
    material.use_nodes = True
    tree = material.node_tree
    mix, closure = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new(kind)
    for key, value in inputs.items():
        closure.inputs[key].default_value = value
    mix.inputs[0].default_value = passed
    tree.links.new(closure.outputs[0], mix.inputs[1])
    tree.links.new(tree.nodes.new("ShaderNodeBsdfTransparent").outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], tree.get_output_node("CYCLES").inputs["Surface"])
    blender.context.object.data.materials.append(material)
    sun = blender.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle = strength, 0.1
    lamp = blender.data.objects.new("Sun", sun)
    lamp.rotation_euler = (0.6, 0.2, 0)
    blender.context.collection.objects.link(lamp)
    stage.world = parts.grey_world(0.2)


#: What glows of a ball of many faces, beside a lamp: the strength of its Principled BSDF's green emission; "bare": a floor that is a plain
#: colour, without a shader, around a grey ball.
GLOWS = {"bright": 10.0, "bare": None}


@pytest.mark.parametrize("name", GLOWS)
def test_what_glows_takes_no_light_samples_from_lamps(stage, blender, tmp_path, name):
    """A face that glows is hardly lit by the other faces of its own object, and a dim colour is found by closure samples: light samples
    are for the lamp. Of each channel the relative variance counts: red and blue are the lamp's."""
    floor = blender.context.object
    blender.ops.mesh.primitive_uv_sphere_add(radius=1.5, location=(0, -0.5, 1.6), segments=96, ring_count=48)
    grey = blender.data.materials.new("Ball")
    grey.use_nodes = True
    principled = grey.node_tree.nodes["Principled BSDF"]
    blender.context.object.data.materials.append(grey)
    if GLOWS[name] is not None:
        principled.inputs["Emission Color"].default_value = (0.04, 1.0, 0.04, 1.0)
        principled.inputs["Emission Strength"].default_value = GLOWS[name]
        # By itself: on a floor another choice shows, that between the ball and the lamp.
        blender.data.objects.remove(floor)
    else:
        plain = blender.data.materials.new("Floor")
        plain.use_nodes = True
        colour = plain.node_tree.nodes.new("ShaderNodeRGB")
        colour.outputs[0].default_value = (0.6, 0.6, 0.6, 1.0)
        output = plain.node_tree.get_output_node("CYCLES")
        plain.node_tree.links.new(colour.outputs[0], output.inputs["Surface"])
        floor.data.materials.append(plain)
    lamp = blender.data.lights.new("Lamp", "POINT")
    lamp.energy, lamp.shadow_soft_size = 60.0, 0.05
    placed = blender.data.objects.new("Lamp", lamp)
    placed.location = (2.0, -3.5, 4.0)
    blender.context.collection.objects.link(placed)
    assert_no_noisier(tmp_path, name, (16, 64), WITHIN, by_channel=True)
