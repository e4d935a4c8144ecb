# SPDX-License-Identifier: GPL-3.0-or-later
"""What fog of the world that lies low takes away, by its closed form."""

from __future__ import annotations

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
    import scene_parts as parts
    from node_tree import Tree

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
