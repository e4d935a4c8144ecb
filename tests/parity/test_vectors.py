# SPDX-License-Identifier: GPL-3.0-or-later
"""A frame of an animation and its Vector pass beside Cycles, of every parity scene that moves: things and what instances them,
shapes by keys, bones, nodes and velocities, hair, points, and the camera."""

from __future__ import annotations

import numpy as np
import pytest

try:
    from parity_scenes import SCENES
except ModuleNotFoundError as error:
    # Without Blender there are none to test.
    if error.name != "bpy":
        raise
    SCENES = {}

pytestmark = pytest.mark.once

WIDTH, HEIGHT, SAMPLES = 64, 48, 32
#: When the shutter is open, and what has no surface: nothing of these is in the pass.
OF_THE_SHUTTER = {"shutter_start", "shutter_end", "shutter_curve", "rolling_shutter", "moving_lamp"}
#: Strands are thinner than pixels; of a ball Cycles tells the way of its middle, we that of the place that is seen.
OF_SMALL_THINGS = {"hair_goes_along", "hair_sways", "hair_sways_round", "points_move", "flies"}
MOVING = [name for name, one in SCENES.items() if one.chapter == "motion" and name not in OF_THE_SHUTTER]


@pytest.mark.parametrize("name", MOVING)
def test_a_frame_and_its_vectors(blender, tmp_path, name):
    from parity.blocks import block_ratios

    from parity_scenes import photograph
    from support import beside_cycles, scenes
    from support.multilayer import photograph as taken
    from support.multilayer import vectors

    SCENES[name].open()
    photograph.prepare(WIDTH, HEIGHT, SAMPLES)
    beside_cycles.small_sky_table()
    scene = blender.context.scene
    scene.render.use_motion_blur = False
    scene.view_layers[0].use_pass_vector = True
    scene.frame_set(scene.frame_current + 1)
    ours, _ = taken(scenes, scene, tmp_path / "petzval.exr", samples=SAMPLES)
    theirs, _ = taken(scenes, scene, tmp_path / "cycles.exr", "CYCLES", SAMPLES)
    both = [np.stack([one[f"combined.{c}"] for c in "rgb"], -1) for one in (ours, theirs)]
    worst = np.abs(block_ratios(*both) - 1.0).max()
    mine, own = vectors(ours), vectors(theirs)
    error = np.abs(mine - own).max(-1)
    moved = np.abs(own).max(-1) > 0.01
    print(f"{name}: blocks {worst:.3f}, {moved.mean():.2f} move up to {np.abs(own).max():.2f} px, off by "
          f"{np.quantile(error, 0.5):.4f}, {np.quantile(error, 0.9):.4f}, {error.mean():.4f}, mean {(mine[moved] - own[moved]).mean(0).round(4)}")  # fmt: skip
    # At this few samples: the frame is the right one.
    assert worst < 0.06
    if name in OF_SMALL_THINGS:
        # Before Blender 5 Cycles has another way for points that go by themselves.
        if name.startswith("hair") or blender.app.version >= (5, 0, 0):
            length = np.abs(own[moved]).mean(0).max()
            # A ball's front is nearer than its middle by 4 % of the distance.
            assert np.abs((mine[moved] - own[moved]).mean(0)).max() < 0.04 * length
        return
    # Half of a thing's pixels are whole; where several things share one, each engine has its own noise.
    assert np.quantile(error[moved], 0.5) < 0.01 + 0.002 * np.abs(own).max()
