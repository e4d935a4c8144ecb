# SPDX-License-Identifier: GPL-3.0-or-later
"""The figures of docs/figures.md at a low resolution, each held against exact rays by its own reader (tools/figures)."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest
from figures import blur, sharpness

from support.places import ROOT

pytestmark = pytest.mark.once


#: The quickest, of colours' places, by exact rays; the others take up to a minute each. What they show is held against exact rays in
#: `make test`, too, by engine/render/tests/all/exact_pictures.
AT_ONCE = ("fig-14",)
LATER = ("fig-08", "fig-09", "fig-10", "fig-11", "fig-12", "fig-13", "fig-15")
#: Every figure passes its check at the smallest size but this one: its detail of a few pixels is lost in noise there.
LARGER = "fig-09"


@pytest.mark.slow
@pytest.mark.parametrize("key", [*AT_ONCE, *(pytest.param(key, marks=pytest.mark.recipe) for key in LATER)])
def test_a_figure_shows_what_its_caption_says(key, tmp_path):
    size = "small" if key == LARGER else "smallest"
    paths = os.pathsep.join(filter(None, [str(ROOT / "tools"), os.environ.get("PYTHONPATH")]))
    done = subprocess.run(
        [sys.executable, "-m", "figures", "--size", size, "--check", "--only", key, "--output", tmp_path],
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": paths},
        timeout=900,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert (tmp_path / f"{key}.json").exists()


def polygon(corners: int, radius: float, size: int = 96) -> np.ndarray:
    """A bright polygon on a dark ground, with soft edges; no corners: a disc."""
    y, x = (np.mgrid[0 : 4 * size, 0 : 4 * size] + 0.5) / 4.0 - 0.5 * size
    away, turn = np.hypot(x, y), np.arctan2(y, x) + 0.2
    if corners:
        sector = 2.0 * np.pi / corners
        away = away * np.cos((turn % sector) - 0.5 * sector) / np.cos(0.5 * sector)
    fine = (away < radius).astype(float).reshape(size, 4, size, 4).mean((1, 3))
    grey = sharpness.box(fine, 2) + 0.01
    return np.repeat(grey[..., None], 3, axis=2)


@pytest.mark.parametrize("corners", [0, 5, 6, 7])
def test_corners_are_counted(corners):
    light = polygon(corners, 30.0) + np.random.default_rng(1).normal(0.0, 0.05, (96, 96, 3))
    found = blur.harmonics(blur.edge(light))
    first, second = sorted(found, key=lambda k: -found[k])[:2]
    assert (first if found[first] > 0.02 else 0) == corners
    assert corners == 0 or found[first] > 2.0 * found[second]


def test_noise_is_no_sharpness():
    """The detail that is left: all of it in the same picture, a known part of blurred stripes, nothing in noise of its own."""
    chance = np.random.default_rng(2)
    stripes = 1.0 + 0.3 * np.sin(np.arange(200) * 2.0 * np.pi / 5.0)[None, :] * np.ones((80, 1))
    light = np.repeat(stripes[..., None], 3, axis=2)
    noisy = [light + chance.normal(0.0, 0.02, light.shape) for _ in range(2)]
    everywhere = (slice(None), slice(None))
    assert sharpness.contrast(noisy[0], noisy[1], everywhere, 4) == pytest.approx(1.0, abs=0.03)
    weaker = 1.0 + 0.25 * (light - 1.0)
    assert sharpness.contrast(weaker, light, everywhere, 4) == pytest.approx(0.25, abs=0.01)
    grey = np.ones_like(light) + chance.normal(0.0, 0.3, light.shape)
    assert abs(sharpness.contrast(grey, light, everywhere, 4)) < 0.03
