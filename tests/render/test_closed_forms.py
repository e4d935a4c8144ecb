# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures that are known by closed forms: fog that lies low, and ground that reaches far."""

from __future__ import annotations

import math

import numpy as np
import pytest

pytestmark = pytest.mark.once

#: Absorption on the ground, per unit, which falls to none at this height, and stays what it is below the ground.
GROUND, TOP = 0.5, 1.6
#: Of the camera, and of the glowing wall before it.
HEIGHT, DEPTH = 0.9, 5.0
PIXELS = (4, 24)
#: The wall's upper and lower end as the picture shows it.
ENDS = (HEIGHT + 1.5, HEIGHT - 1.5)


def depth_below(height):
    """The absorption from the ground up to a height, negative below."""
    within = np.clip(height, 0.0, TOP)
    return GROUND * (within - within**2 / (2.0 * TOP) + np.minimum(height, 0.0))


def passed(x, z):
    """The part of the light that comes from places of the wall to the camera."""
    length = np.sqrt(DEPTH**2 + x**2 + (z - HEIGHT) ** 2)
    return np.exp(-length * (depth_below(z) - depth_below(HEIGHT)) / (z - HEIGHT))


def test_what_low_fog_takes_is_that_of_its_closed_form(blender, tmp_path):
    from support import scenes as parts
    from support.node_tree import Tree

    width, height = PIXELS
    scene = parts.set_up(width, height, samples=1024)
    camera = scene.camera
    camera.location = (0.0, 0.0, HEIGHT)
    # Fog nearer than this is not there, as in Cycles.
    camera.data.clip_start = 0.001
    camera.data.sensor_fit, camera.data.sensor_height = "VERTICAL", 24.0
    camera.data.lens = 24.0 * DEPTH / (ENDS[0] - ENDS[1])
    scene.cycles.pixel_filter_type = "BOX"
    scene.petzval.property_unset("filter_width")
    parts.square("Wall", (0.0, DEPTH, HEIGHT), 8.0, parts.emitter())
    scene.world = parts.grey_world(0.0)
    tree = scene.world.node_tree
    fog = Tree(tree, tree.get_output_node("CYCLES").inputs["Volume"])
    at = fog.node("SeparateXYZ", Vector=fog.node("NewGeometry").outputs["Position"]).outputs["Z"]
    density = fog.node("MapRange", Value=at, _1=0.0, _2=TOP, _3=GROUND, _4=0.0).outputs[0]
    fog.shows(fog.node("VolumeAbsorption", Color=(0.0, 0.0, 0.0, 1.0), Density=density).outputs[0])

    picture = parts.render(tmp_path)[..., :3].mean(-1)
    # Four by four places of each pixel; its first row is the lowest.
    side = (ENDS[0] - ENDS[1]) / height
    z = ENDS[1] + side * (np.arange(4 * height) + 0.5) / 4.0
    x = side * (np.arange(4 * width) + 0.5 - 2.0 * width) / 4.0
    expected = passed(x, z[:, None]).reshape(height, 4, width, 4).mean((1, 3))
    assert expected.min() < 0.15 and expected.max() > 0.5
    # What passes is 0 or 1 for each sample at worst: the standard error of a row's mean.
    error = np.sqrt(expected * (1.0 - expected) / scene.petzval.samples).mean(-1) / np.sqrt(width)
    assert np.all(np.abs(picture.mean(-1) - expected.mean(-1)) < 4.0 * error), picture.mean(-1) / expected.mean(-1)
    assert picture.mean() == pytest.approx(expected.mean(), rel=0.005)


@pytest.mark.parametrize("side", [200.0, 2e4, 2e5])
def test_ground_does_not_hide_the_sky_from_itself(blender, tmp_path, side):
    """In a white world it is as bright as its albedo, however far it reaches. Rays that leave so large a triangle start nearer to it than
    the distance to it is known."""
    from support import scenes as parts

    scene = parts.set_up(16, 12, samples=64)
    blender.ops.mesh.primitive_plane_add(size=side)
    scene.camera.location, scene.camera.rotation_euler = (7.0, -30.0, 27.0), (math.radians(60.0), 0.0, 0.1)
    scene.camera.data.clip_end = 1e7
    scene.world = parts.grey_world(1.0)
    # One bounce more would fill in what the ground hides.
    scene.petzval.max_bounces = 0
    material, tree, surface = parts.material()
    diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (0.8, 0.8, 0.8, 1.0)
    tree.links.new(diffuse.outputs[0], surface)
    blender.context.object.data.materials.append(material)
    picture = parts.render(tmp_path)[..., :3]
    assert np.all(np.abs(picture - 0.8) < 1e-5), picture.min()
