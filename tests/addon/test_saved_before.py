# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that older versions have saved open with the same settings."""

from __future__ import annotations

import json

import pytest

from support.places import ROOT

#: Of Petzval 0.1 in Blender 4.5: a file in which no setting has its default, and their values. Later ones by tools/saved_settings.py.
SAVED = ROOT / "tests/addon/saved_by_0.1"


@pytest.mark.parametrize("version", ["0.1", "1.0"])
def test_a_file_of_a_released_version_opens_with_its_settings(blender, version):
    saved = SAVED.with_name(f"saved_by_{version}")
    blender.ops.wm.open_mainfile(filepath=str(saved / "settings.blend"))
    scene = blender.context.scene
    assert scene.render.engine == "PETZVAL"
    holders = {"scene": scene.petzval, "camera": scene.camera.data.petzval}
    for where, values in json.loads((saved / "settings.json").read_text()).items():
        assert len(values) > 15
        for name, value in values.items():
            found = getattr(holders[where], name)
            assert (list(found) if isinstance(value, list) else found) == pytest.approx(value), (where, name)


def test_a_preset_of_the_version_before_loads(blender, parts):
    own = parts.set_up(model="LENS").camera.data.petzval
    preset = SAVED / "preset.py"
    assert blender.ops.script.execute_preset(filepath=str(preset), menu_idname="PETZVAL_PT_camera_presets") == {
        "FINISHED"
    }
    for line in preset.read_text().splitlines():
        if line.startswith("petzval."):
            name, value = line.removeprefix("petzval.").split(" = ")
            assert getattr(own, name) == pytest.approx(eval(value)), name


@pytest.fixture
def versions(parts):
    return parts.part("data.settings_version")


def test_a_file_of_the_version_before_gets_the_number_of_this_one(blender, versions):
    blender.ops.wm.open_mainfile(filepath=str(SAVED / "settings.blend"))
    assert versions.of_file() == versions.VERSION > 0 and versions.warnings() == []


def test_steps_are_taken_once_in_their_order(blender, versions, tmp_path, monkeypatch):
    taken = []
    monkeypatch.setattr(versions, "VERSION", 3)
    steps = {version: lambda version=version: taken.append(version) for version in (1, 2, 3, 4)}
    monkeypatch.setattr(versions, "STEPS", steps)
    blender.ops.wm.open_mainfile(filepath=str(SAVED / "settings.blend"))
    assert taken == [1, 2, 3]
    # Saved, and opened again: it is of this version.
    blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "new.blend"))
    blender.ops.wm.open_mainfile(filepath=str(tmp_path / "new.blend"))
    assert taken == [1, 2, 3] and versions.of_file() == 3


def test_a_file_of_a_newer_version_says_so_and_keeps_its_number(blender, parts, versions, tmp_path, monkeypatch):
    parts.set_up(model="PINHOLE")
    newer = versions.VERSION + 1
    with monkeypatch.context() as patch:
        patch.setattr(versions, "VERSION", newer)
        blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "newer.blend"))
    blender.ops.wm.open_mainfile(filepath=str(tmp_path / "newer.blend"))
    (line,) = versions.warnings()
    assert f"settings {newer}" in line and "update Petzval" in line
    blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "again.blend"))
    blender.ops.wm.open_mainfile(filepath=str(tmp_path / "again.blend"))
    assert versions.of_file() == newer
