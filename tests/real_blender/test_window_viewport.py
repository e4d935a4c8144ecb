# SPDX-License-Identifier: GPL-3.0-or-later
"""Rendered shading in a 3D view of Blender's window: what is shown, edits, undo, files, and the add-on turned off and on."""

from __future__ import annotations

import json
import shutil

import pytest

from support.places import ROOT, SCENES, SUPPORT

pytestmark = [pytest.mark.window, pytest.mark.once]


@pytest.fixture(scope="module")
def walked(run_blender, installed_extension, tmp_path_factory):
    """The observations of window_viewport_steps.py, and all that Blender said meanwhile."""
    folder = tmp_path_factory.mktemp("viewport")
    done = run_blender(
        "--addons",
        installed_extension,
        "--python",
        SUPPORT / "window_viewport_steps.py",
        "--",
        folder,
        installed_extension,
        SCENES / "demo.blend",
        window=True,
        timeout_s=420,
    )
    # Kept where a person can look at them.
    pictures = ROOT / "output/window"
    pictures.mkdir(parents=True, exist_ok=True)
    for picture in folder.glob("*.png"):
        shutil.copy(picture, pictures)
    seen = folder / "seen.json"
    assert seen.exists(), done.stdout
    seen = json.loads(seen.read_text())
    assert "error" not in seen, seen["error"] + done.stdout
    return seen, done.stdout


def test_nothing_complains_on_the_way(walked):
    said = walked[1]
    assert "Traceback" not in said, said
    assert not [line for line in said.splitlines() if "Error" in line and "no-such.lens" not in line], said


def test_the_view_shows_the_scene_and_its_edits(walked):
    shown = {name: values[0] for name, values in walked[0]["shown"].items()}
    print(walked[0]["seconds"])
    first = shown["viewport-camera"]
    assert first > 0.01
    # Brightness does not hang on the f-number, unless a physical exposure is asked for.
    assert shown["viewport-stopped-down"] == pytest.approx(first, rel=0.3)
    assert shown["viewport-dark"] < 0.95 * shown["viewport-stopped-down"]
    assert shown["viewport-undone"] == pytest.approx(shown["viewport-stopped-down"], rel=0.02)
    for name in (
        "viewport-hidden",
        "viewport-perspective",
        "viewport-orthographic",
        "viewport-loaded",
        "viewport-again",
    ):
        assert shown[name] > 0.005, name


def test_an_image_sequence_follows_the_frame(walked):
    """A red sky, then a blue one; the lamps in the room are what they were."""
    first, second = (walked[0]["shown"][f"viewport-frame-{frame}"] for frame in (1, 2))
    assert first[1] / first[3] > 1.2 * second[1] / second[3], (first, second)


def test_what_is_wrong_is_told_in_the_view(walked):
    assert "no such lens: no-such.lens" in walked[0]["told"]


def test_a_view_that_is_left_ends_its_work(walked):
    # Views and their sessions.
    assert walked[0]["left"] == [0, 0]
    assert walked[0]["threads"] == 1


def test_the_focus_can_be_dragged(walked):
    """By the mouse; what is left is the pixel's size and where the ring was taken."""
    assert walked[0]["dragged"] == pytest.approx(5.0, rel=0.05)


def test_settings_come_back_with_the_file(walked):
    assert walked[0]["loaded"] == ["PETZVAL", "double-gauss-f2-tronnier.lens"]


def test_turning_the_add_on_off_and_on_leaks_nothing(walked):
    memory = walked[0]["memory_mb"]
    print("MB:", [round(one) for one in memory])
    # The first turns load what is loaded once.
    assert memory[-1] < 1.03 * max(memory[4:8]), memory
