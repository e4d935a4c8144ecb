# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension in the real Blender, as a user has it: installed from the zip, offline, and rendered with."""

from __future__ import annotations

import zipfile

import pytest

pytestmark = [pytest.mark.real_blender, pytest.mark.once]

RENDER = """
import sys
import bpy
scene = bpy.context.scene
scene.render.engine = "PETZVAL"
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 48, 32, 100
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.filepath = sys.argv[-1]
bpy.ops.render.render(write_still=True)
pixels = bpy.data.images.load(sys.argv[-1]).pixels[:]
colours = [value for index, value in enumerate(pixels) if index % 4 != 3]
print("MEAN", sum(colours) / len(colours), "FINITE", all(value == value and abs(value) < 1e30 for value in pixels))
"""


def test_the_extension_validates(run_blender, extension_zip):
    done = run_blender("--command", "extension", "validate", extension_zip)
    assert done.returncode == 0, done.stdout


def test_the_zip_holds_the_wheel_and_no_leftovers(extension_zip):
    names = zipfile.ZipFile(extension_zip).namelist()
    assert len([name for name in names if name.startswith("wheels/") and name.endswith(".whl")]) == 1
    assert "blender_manifest.toml" in names
    assert not [name for name in names if "__pycache__" in name]


def test_the_installed_extension_renders(run_blender, installed_extension, tmp_path):
    script, image = tmp_path / "render.py", tmp_path / "image.exr"
    script.write_text(RENDER)
    # Blender's own start-up scene: a cube, a lamp, a grey world.
    done = run_blender(
        "-b",
        "--factory-startup",
        "--addons",
        installed_extension,
        "--python-exit-code",
        "3",
        "--python",
        script,
        "--",
        image,
    )
    assert done.returncode == 0, done.stdout
    result = next(line for line in done.stdout.splitlines() if line.startswith("MEAN")).split()
    assert 0.001 < float(result[1]) < 10.0, done.stdout
    assert result[3] == "True"
