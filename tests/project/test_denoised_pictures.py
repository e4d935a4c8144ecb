# SPDX-License-Identifier: GPL-3.0-or-later
"""The page of `make denoising`: what it says of pictures, and the picture of the demo. The measuring itself: test_make.py."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("PIL")
from denoising import page  # noqa: E402 (needs Pillow)

pytestmark = pytest.mark.once

SAMPLES = (32, 64)


def result(name: str, flip: float, theirs: float) -> SimpleNamespace:
    """The result of a scene by others; without denoising twice the error."""
    errors, seconds = {}, {}
    for program, level in (("petzval", flip), ("cycles", theirs)):
        for count in SAMPLES:
            for quality, guides in page.ROWS:
                key = (program, count, quality, guides)
                times = 2.0 if quality == "off" else 1.0
                errors[key] = SimpleNamespace(flip=times * level, rel_mse=times * 0.0123)
                seconds[key] = 1.5
    scene = SimpleNamespace(name=name, is_by_others=True)
    return SimpleNamespace(scene=scene, errors=errors, seconds=seconds, left_out="")


def test_scenes_that_are_no_worse_than_cycles_are_counted():
    results = [result("one", 0.10, 0.11), result("two", 0.10, 0.10), result("three", 0.30, 0.10)]
    results[2].left_out = "it has no camera"
    text = page.text(results, SAMPLES, 1024, 135, 24, {"one": "somewhere"})
    assert "2 of 2 scenes" in text.replace("\n", " ")
    assert "- three: it has no camera" in text and "- one: somewhere" in text
    assert "| one | 0.200 | 0.100 | 0.110 | 0.110 | 1.5 / 1.5 |" in text
    # In the middle of the scenes, and seconds of all.
    assert "| high | both | 0.100 · 0.012 | 0.100 · 0.012 | 3.0 |" in text
    assert "| off | – | 0.200 · 0.025 | 0.200 · 0.025 | 3.0 |" in text


def test_pictures_stand_beside_each_other_with_their_parts_below():
    pictures = [np.full((36, 64, 3), level) for level in (0.0, 1.0)]
    pictures[0][:18, :32] = 0.5
    found = page.beside(pictures, ((0.0, 0.0, 0.5, 0.5),))
    assert found.size == (2 * 64 + page.GAP, 2 * 36 + page.GAP)
    assert found.getpixel((0, 0)) == found.getpixel((60, 36 + page.GAP + 30)) == (128, 128, 128)
    assert found.getpixel((60, 30)) == (0, 0, 0) and found.getpixel((64 + page.GAP, 0)) == (255, 255, 255)
    assert Path(page.PICTURE).suffix == ".jpg"
