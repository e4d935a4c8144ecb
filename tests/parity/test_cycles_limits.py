# SPDX-License-Identifier: GPL-3.0-or-later
"""The scenes in which Cycles' default settings are not exact: Petzval gives the truth there, and Cycles still does not."""

from __future__ import annotations

import numpy as np
import pytest

try:
    from cycles_limits import LIMITS
except ModuleNotFoundError as error:
    # Without Blender there are none to test.
    if error.name != "bpy":
        raise
    LIMITS = {}

pytestmark = pytest.mark.once

#: Cases that no part of their samples decides take minutes: `make test-all` has them.
NAMES = [name if one.quick else pytest.param(name, marks=pytest.mark.recipe) for name, one in LIMITS.items()]


@pytest.mark.parametrize("name", NAMES)
def test_petzval_gives_the_truth_and_cycles_does_not(blender, tmp_path, name):
    from parity_scenes import photograph

    one = LIMITS[name]
    means = {}
    for way in one.ways:
        one.open(way, one.quick or 1.0)
        picture = photograph.take(way.engine, tmp_path)[..., :3]
        assert np.isfinite(picture).all()
        means[way] = float(picture.mean(dtype=np.float64))
    truth = next(mean for way, mean in means.items() if way.is_truth)
    errors = {way: one.error_of(mean, truth) for way, mean in means.items()}
    print(name, {way.label: f"{means[way]:.4g}" for way in one.ways}, f"truth {truth:.4g}")
    for way, error in errors.items():
        if way.engine == "PETZVAL":
            assert error < one.tolerance, (way.label, error)
    # If Cycles becomes exact there, the page's chapter has to say so.
    assert max(errors.values()) > one.error, errors
