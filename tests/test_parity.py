# SPDX-License-Identifier: GPL-3.0-or-later
"""The parity scenes, each by Petzval and by Cycles in the same Blender, block by block."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

TOP = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(TOP / "tests" / "scenes"), str(TOP / "tools")]

from parity.blocks import block_ratios, floor_of  # noqa: E402

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
    import beside_cycles
    from parity_scenes import photograph

    one = SCENES[name]
    one.open()
    photograph.prepare(WIDTH, HEIGHT, SAMPLES)
    beside_cycles.small_sky_table()

    def take(engine):
        return photograph.looks(engine, tmp_path, one.passes, one.frames)

    for done, share, ours, theirs in beside_cycles.looks(SAMPLES, take):
        told = sys.modules["petzval_addon"].statistics.last(blender.context.scene.name)
        assert all(np.isfinite(look).all() for look in ours.values())
        left = [line for line in told.warnings if not any(word in line for word in one.warns)]
        assert not left, left
        assert len(told.warnings) >= len(one.warns), told.warnings
        ratios = {look: block_ratios(ours[look], theirs[look], floor_of(look)) for look in ours}
        worst = max(np.abs(ratio - 1.0).max() for ratio in ratios.values())
        mean = max(abs(ours[look].mean() - theirs[look].mean()) / np.abs(theirs[look]).mean() for look in ours)
        print(f"{name}, {done} samples: worst block {worst:.4f}, mean {mean:.4f}")
        # The mean is of twelve blocks.
        if worst < share * (one.tolerance + one.noise) and mean < share * (one.tolerance + 0.3 * one.noise):
            return
    raise AssertionError(f"mean {mean:.4f}, blocks { {look: ratio.round(3) for look, ratio in ratios.items()} }")
