# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes of light by lobe against Cycles in the same Blender, block by block, and their sum against the picture."""

from __future__ import annotations

import numpy as np
import pytest

NAMES = (
    "Diffuse Direct", "Diffuse Indirect", "Diffuse Color", "Glossy Direct", "Glossy Indirect", "Glossy Color",
    "Transmission Direct", "Transmission Indirect", "Transmission Color", "Emission", "Environment",
)  # fmt: skip


@pytest.fixture
def room(blender):
    import pass_parts

    scene = pass_parts.room()
    pass_parts.ask_for_light(scene.view_layers[0])
    return pass_parts


def test_each_is_as_cycles_has_it(room, tmp_path):
    ours = room.photograph(tmp_path / "petzval.exr", samples=256)
    theirs = room.photograph(tmp_path / "cycles.exr", "CYCLES", samples=256)
    assert ours.keys() == theirs.keys()
    # 256 samples: the noise of a block's dimmest passes is a few per cent.
    room.same(ours, theirs, NAMES, mean=0.02, block=0.05)
    assert np.abs(room.summed(ours) - ours["Combined"][..., :3]).max() < 1e-5 * ours["Combined"].max()
