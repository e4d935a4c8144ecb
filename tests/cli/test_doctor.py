# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval doctor`: what is there, what is missing, what to do."""

from __future__ import annotations

import os
import sys

import pytest

from petzval import _native, doctor_command
from support.command_line import answer

pytestmark = pytest.mark.once


@pytest.fixture
def blender(tmp_path):
    """A program that says what Blender says; called with a version."""
    if sys.platform == "win32":
        pytest.skip("a shell script stands for Blender")

    def make(version: str, folder: str = "blender"):
        program = tmp_path / folder / "blender"
        program.parent.mkdir(exist_ok=True)
        program.write_text(f'#!/bin/sh\necho "Blender {version}"\n')
        program.chmod(0o755)
        return program

    return make


def test_what_is_there_is_told(petzval_cli, blender):
    program = blender("4.5.3 LTS")
    told = answer(petzval_cli("doctor", "--json", "--blender", program))
    assert told["engine"]["version"] == _native.__version__ and told["engine"]["processor"] == _native.PROCESSOR
    assert {"program": str(program), "version": "4.5.3"} in told["blenders"]
    assert told["python"]["program"] and told["packages"]["numpy"] and told["lenses"] >= 60
    assert told["missing"] == []
    text = petzval_cli("doctor", "--blender", program)
    assert text.returncode == 0 and f"petzval      {_native.__version__}" in text.stdout and "4.5.3" in text.stdout


def test_an_old_blender_and_one_that_does_not_run(petzval_cli, blender, tmp_path):
    old, none = blender("3.6.12"), tmp_path / "none"
    advice = answer(petzval_cli("doctor", "--json", "--blender", old))["advice"]
    assert f"{old} is 3.6.12, and the add-on needs 4.2 or later: update it" in advice
    advice = answer(petzval_cli("doctor", "--json", "--blender", none))["advice"]
    assert f"{none} does not say its version: does it run?" in advice


def test_an_engine_that_cannot_be_loaded_is_missing(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "petzval._native", None)
    monkeypatch.delattr("petzval._native", raising=False)
    parsed = doctor_command.argparse.Namespace(blender=None, json=False)
    assert doctor_command.run(parsed) == 1
    said = capsys.readouterr().out
    assert "petzval      cannot be loaded" in said and "! no engine: " in said and "install the wheel" in said


def test_what_could_be_had_is_named(monkeypatch, tmp_path):
    monkeypatch.setattr(doctor_command, "_installed", lambda name: "1.0" if name == "numpy" else None)
    monkeypatch.setattr(doctor_command, "_programs", lambda named: [])
    monkeypatch.setattr(doctor_command.denoiser_library, "find", lambda homes: None)
    found = doctor_command.examine()
    assert found["missing"] == []
    for word in ("petzval[bpy]", "pip install pyoidn", "petzval[plots]"):
        assert any(word in line for line in found["advice"]), word


def test_an_extension_of_another_version_is_named(monkeypatch, tmp_path):
    folder = tmp_path / "extensions/user_default/petzval"
    folder.mkdir(parents=True)
    (folder / "blender_manifest.toml").write_text('version = "0.0.9"\n')
    broken = tmp_path / "extensions/other/petzval"
    broken.mkdir(parents=True)
    (broken / "blender_manifest.toml").write_text("version =\n")
    monkeypatch.setenv("BLENDER_USER_RESOURCES", str(tmp_path))
    found = doctor_command.examine()
    assert {"folder": str(folder), "version": "0.0.9"} in found["extensions"]
    assert {"folder": str(broken), "version": "broken"} in found["extensions"]
    assert any(f"{os.fspath(folder)} is 0.0.9, and this is {_native.__version__}" in line for line in found["advice"])


@pytest.mark.parametrize(
    ("system", "program", "variables"),
    [
        ("win32", "Blender Foundation/Blender 5.2/blender.exe", ("ProgramFiles",)),
        ("linux", "blender-5.2.0-linux-x64/blender", ("HOME",)),
        ("darwin", "Applications/Blender.app/Contents/MacOS/Blender", ("HOME",)),
    ],
)
def test_blenders_are_found_where_installers_put_them(monkeypatch, tmp_path, system, program, variables):
    place = tmp_path / program
    place.parent.mkdir(parents=True)
    place.write_text("")
    for name in variables:
        monkeypatch.setenv(name, str(tmp_path))
    monkeypatch.delenv("ProgramW6432", raising=False)
    monkeypatch.setattr(doctor_command.sys, "platform", system)
    monkeypatch.setattr(doctor_command.shutil, "which", lambda name: None)
    assert place in doctor_command._programs(None)
