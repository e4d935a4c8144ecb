# SPDX-License-Identifier: GPL-3.0-or-later
"""What the film makes of the light, pixel by pixel, against Cycles in the same Blender."""

from __future__ import annotations

import numpy as np
import pytest

WIDTH, HEIGHT, SAMPLES = 24, 18, 1024


@pytest.fixture
def edges(blender):
    """A small square that glows, turned, in a dim sky: all that is seen are edges."""
    from support import scenes as parts

    scene = parts.set_up(WIDTH, HEIGHT, SAMPLES)
    scene.world = parts.grey_world(0.1)
    square = parts.square("Square", (0.1, 4.0, -0.05), 0.9, parts.emitter((0.9, 0.6, 0.3), 2.0))
    square.rotation_euler = (0.0, 0.3, 0.0)
    return parts


def alike(folder, block: float = 0.04, **cycles_settings) -> np.ndarray:
    """Each pixel is as Cycles has it. Gives Petzval's picture."""
    from support import beside_cycles

    return beside_cycles.alike(folder, SAMPLES, side=1, mean=0.005, block=block, floor=0.5, **cycles_settings)


FILTERS = [("BOX", 3.0), ("GAUSSIAN", 1.3), ("BLACKMAN_HARRIS", 0.01), ("BLACKMAN_HARRIS", 2.5)]


@pytest.mark.parametrize(("kind", "width"), FILTERS, ids=lambda value: str(value))
def test_the_pixel_filter(edges, blender, tmp_path, kind, width):
    alike(tmp_path, pixel_filter_type=kind, filter_width=width)


def test_petzvals_own_width_overrules_cycless_filter(edges, blender, tmp_path):
    scene = blender.context.scene
    scene.petzval.samples = 64
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "GAUSSIAN", 3.0
    theirs = edges.render(tmp_path)
    scene.petzval.filter_width = 1.5
    own = edges.render(tmp_path)
    assert np.abs(own - theirs).max() > 0.1
    scene.petzval.property_unset("filter_width")
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BLACKMAN_HARRIS", 1.5
    assert (edges.render(tmp_path) == own).all()


# Fitted to the width and to the height; wide pixels make this picture wider, tall ones upright.
@pytest.mark.parametrize("aspect", [(1.0, 2.0), (1.5, 1.0)], ids=["tall", "wide"])
@pytest.mark.parametrize("fit", ["AUTO", "HORIZONTAL", "VERTICAL"])
@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_pixels_that_are_not_square(edges, blender, tmp_path, kind, fit, aspect):
    render, camera = blender.context.scene.render, blender.context.scene.camera.data
    render.pixel_aspect_x, render.pixel_aspect_y = aspect
    camera.type, camera.ortho_scale, camera.sensor_fit, camera.sensor_height = kind, 2.0, fit, 30.0
    camera.shift_x, camera.shift_y = 0.03, -0.05
    alike(tmp_path)


def test_what_the_camera_sees_is_clamped(edges, blender, tmp_path):
    """In the mean of the channels."""
    alike(tmp_path, sample_clamp_direct=0.8)


def test_what_is_scattered_once_is_clamped(edges, blender, tmp_path):
    """The light of one lamp on a wall: of several each program samples others, and clamps what that makes of them."""
    scene = blender.context.scene
    scene.world = edges.grey_world(0.0, "Dark")
    wall, tree, surface = edges.material("Wall")
    diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (0.7, 0.5, 0.3, 1.0)
    tree.links.new(diffuse.outputs[0], surface)
    blender.data.objects["Square"].data.materials[0] = wall
    lamp = blender.data.objects.new("Lamp", blender.data.lights.new("Lamp", "POINT"))
    lamp.data.shadow_soft_size, lamp.data.energy, lamp.location = 0.0, 60.0, (0.5, 3.0, 0.3)
    scene.collection.objects.link(lamp)
    alike(tmp_path, sample_clamp_direct=0.3)


def test_pixel_jitter_is_named(edges, blender, tmp_path):
    cycles = blender.context.scene.cycles
    if not hasattr(cycles, "use_pixel_jitter"):
        pytest.skip("this Blender has no such setting")
    blender.context.scene.petzval.samples = 1
    cycles.use_pixel_jitter = True
    edges.render(tmp_path)
    (warning,) = edges.part("render.statistics").last("Scene").warnings
    assert "Pixel Jitter" in warning


def test_what_is_scattered_twice_is_clamped_as_cycles_says(edges, blender, tmp_path, monkeypatch):
    """Where Petzval's own clamp was never set. A wall that the lamp does not see is lit by one that it sees."""
    from support import beside_cycles

    scene = blender.context.scene
    scene.world = edges.grey_world(0.0, "Dark")
    wall, tree, surface = edges.material("Wall")
    diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (0.7, 0.5, 0.3, 1.0)
    tree.links.new(diffuse.outputs[0], surface)
    blender.data.objects["Square"].data.materials[0] = wall
    edges.square("Behind", (0.0, -0.5, 0.0), 9.0, wall)
    lamp = blender.data.objects.new("Lamp", blender.data.lights.new("Lamp", "SPOT"))
    # Light of one small lamp, scattered evenly: both programs clamp the same samples.
    lamp.data.shadow_soft_size, lamp.data.energy, lamp.location = 0.0, 600.0, (0.0, 1.5, 0.0)
    lamp.data.spot_size, lamp.rotation_euler = 2.6, (-np.pi / 2, 0.0, 0.0)
    scene.collection.objects.link(lamp)
    plain = beside_cycles.without_tricks

    def prepare(samples: int) -> None:
        plain(samples)
        scene.petzval.property_unset("clamp_indirect")

    monkeypatch.setattr(beside_cycles, "without_tricks", prepare)
    # Few of the wall's directions find the bright patch: pixels are noisy.
    clamped = beside_cycles.alike(
        tmp_path, SAMPLES, side=6, mean=0.01, block=0.04, floor=0.5, sample_clamp_indirect=0.2
    )
    scene.petzval.clamp_indirect = 0.0
    whole = edges.render(tmp_path, "whole.exr")[..., :3]
    assert clamped.mean() < 0.8 * whole.mean()


def test_the_seed_is_that_of_cycles_until_one_is_set(blender, parts):
    scene = parts.set_up()
    seed = parts.part("export.settings").seed
    scene.cycles.seed = 5
    scene.frame_set(3)
    assert seed(scene) == 5
    scene.cycles.use_animated_seed = True
    found = []
    for frame in (3, 4, -7):
        scene.frame_set(frame)
        found.append(seed(scene))
    assert len({5, *found}) == 4 and all(0 <= one < 2**31 for one in found)
    scene.petzval.seed = 7
    assert seed(scene) == 7
