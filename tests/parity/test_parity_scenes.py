# SPDX-License-Identifier: GPL-3.0-or-later
"""The parity scenes, each by Petzval and by Cycles in the same Blender, block by block."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from parity.blocks import block_ratios, floor_of

try:
    from parity_scenes import SCENES
except ModuleNotFoundError as error:
    # Without Blender there are none to test.
    if error.name != "bpy":
        raise
    SCENES = {}

pytestmark = pytest.mark.once

WIDTH, HEIGHT, SAMPLES = 64, 48, 256
#: Scenes that `make test-all` has, and what holds the same in every run.
ELSEWHERE = {
    # A ball of each in test_closures.py.
    "principled_metal": "principled metal",
    "principled_specular_tint": "principled, tinted",
    "principled_anisotropic": "principled, brushed",
    "principled_emission": "principled, shining",
    "principled_alpha": "principled, half clear",
    "principled_thin_film": "principled, film",
    "metallic": "tinted metal",
    # Each kind of lamp in test_lamps.py, and many of them in test_noise.py.
    "area": "lamps",
    "area_spread": "lamps",
    "spot": "lamps",
    "many_lamps": "sixteen points in a grey world",
    # Cycles takes half a minute; its closed form is in test_closed_forms.py.
    "world_low_fog": "low fog",
}
#: Cycles takes long to get these ready for each picture: it takes one of all samples.
AT_ONCE = {"demo", "fire", "volume_object"}


def scenes() -> list:
    return [pytest.param(name, marks=[pytest.mark.recipe] * (name in ELSEWHERE)) for name in SCENES]


@pytest.mark.parametrize("name", scenes())
def test_parity(blender, tmp_path, name):
    from parity_scenes import photograph
    from support import beside_cycles

    one = SCENES[name]
    one.open()
    samples = one.times * SAMPLES
    photograph.prepare(WIDTH, HEIGHT, samples)
    beside_cycles.small_sky_table()

    def take(engine):
        return photograph.looks(engine, tmp_path, one.passes, one.frames)

    chapter = Path(sys.modules[one.fill.__module__].__file__)
    looks = beside_cycles.looks(samples, take, theirs_at_once=name in AT_ONCE, blocks=(3, 4), chapter=chapter)
    for done, share, ours, theirs in looks:
        told = sys.modules["petzval_addon"].render.statistics.last(blender.context.scene.name)
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
