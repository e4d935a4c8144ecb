# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's window: the panels draw, a render finishes, Escape ends a long one."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

pytestmark = [pytest.mark.window, pytest.mark.once]

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="module")
def walked(run_blender, installed_extension, tmp_path_factory):
    """What window_steps.py saw, and all that Blender said meanwhile."""
    folder = tmp_path_factory.mktemp("window")
    done = run_blender(
        "--addons",
        installed_extension,
        "--python",
        ROOT / "tests/window_steps.py",
        "--",
        folder,
        window=True,
        timeout_s=240,
    )
    # Kept where a person can look at them.
    pictures = ROOT / "output/window"
    pictures.mkdir(parents=True, exist_ok=True)
    for picture in folder.glob("*.png"):
        shutil.copy(picture, pictures)
    seen = folder / "seen.json"
    assert seen.exists(), done.stdout
    return json.loads(seen.read_text()), done.stdout


def test_the_walk_goes_through(walked):
    seen, said = walked
    assert "error" not in seen, seen["error"] + said
    assert seen["rendered"]


def test_nothing_complains_on_the_way(walked):
    said = walked[1]
    assert "Traceback" not in said, said
    assert "Error" not in said, said


def test_escape_ends_a_long_render(walked):
    seen, said = walked
    assert seen["running_before_escape"], said
    assert seen["stopped"], said
    assert seen["stopped_after_s"] < 5.0
