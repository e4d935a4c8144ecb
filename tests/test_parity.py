# SPDX-License-Identifier: GPL-3.0-or-later
"""The parity scenes, each by Petzval and by Cycles in the same Blender, block by block."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

TOP = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(TOP / "tests" / "scenes"), str(TOP / "tools")]

from parity.blocks import block_ratios  # noqa: E402

try:
    from parity_scenes import SCENES
except ModuleNotFoundError as error:
    # Without Blender there are none to test.
    if error.name != "bpy":
        raise
    SCENES = {}

pytestmark = pytest.mark.once

WIDTH, HEIGHT, SAMPLES = 64, 48, 256


@pytest.mark.parametrize("name", SCENES)
def test_parity(blender, tmp_path, name):
    from parity_scenes import photograph

    one = SCENES[name]
    one.open()
    photograph.prepare(WIDTH, HEIGHT, SAMPLES)
    ours = photograph.take("PETZVAL", tmp_path)
    told = sys.modules["petzval_addon"].statistics.last(blender.context.scene.name)
    theirs = photograph.take("CYCLES", tmp_path)
    assert np.isfinite(ours).all()
    left = [line for line in told.warnings if not any(word in line for word in one.warns)]
    assert not left, left
    assert len(told.warnings) >= len(one.warns), told.warnings
    ratio = block_ratios(ours, theirs)
    assert np.abs(ratio - 1.0).max() < one.tolerance + one.noise, ratio.round(3)
    # The mean is of twelve blocks.
    assert abs(ours[..., :3].mean() / theirs[..., :3].mean() - 1.0) < one.tolerance + 0.3 * one.noise
