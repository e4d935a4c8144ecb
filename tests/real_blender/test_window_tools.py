# SPDX-License-Identifier: GPL-3.0-or-later
"""The lens tools in Blender's window: focus picked with the mouse, Escape, a report in a window of its own."""

from __future__ import annotations

import json

import pytest

from support.places import SUPPORT

pytestmark = [pytest.mark.window, pytest.mark.once]

STEPS = SUPPORT / "window_tools_steps.py"


def test_tools_work_in_the_window(run_blender, installed_extension, tmp_path):
    arguments = ("--addons", installed_extension, "--python", STEPS, "--", tmp_path, installed_extension)
    done = run_blender(*arguments, window=True, timeout_s=200)
    found = tmp_path / "seen.json"
    assert found.exists(), done.stdout
    seen = json.loads(found.read_text())
    assert "error" not in seen, seen["error"] + done.stdout
    assert seen["after escape"] == seen["before"] and seen["modal"] == []
    # The picked pixel is the middle of the picture to a pixel or two, where the cube has an edge towards the camera.
    assert seen["picked"] != seen["before"]
    assert seen["picked"] == pytest.approx(seen["by number"], rel=0.01)
    assert seen["report"] == ["FINISHED"] and seen["shown"] == ["Lens Report: Drawing"]
    assert "Error" not in done.stdout, done.stdout
