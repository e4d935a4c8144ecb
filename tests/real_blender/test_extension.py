# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension in the real Blender, as a user has it: installed from the zip, offline, and rendered with."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from support.places import ROOT

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


@pytest.mark.real_blender
@pytest.mark.once
def test_the_extension_validates(run_blender, extension_zip):
    done = run_blender("--command", "extension", "validate", extension_zip)
    assert done.returncode == 0, done.stdout


@pytest.mark.real_blender
@pytest.mark.once
def test_the_zip_holds_the_wheel_and_no_leftovers(extension_zip):
    names = zipfile.ZipFile(extension_zip).namelist()
    assert len([name for name in names if name.startswith("wheels/") and name.endswith(".whl")]) == 1
    assert "blender_manifest.toml" in names
    assert not [name for name in names if "__pycache__" in name]


@pytest.mark.real_blender
@pytest.mark.once
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


INSTALL = """
import os, sys
# Nothing of the checkout: what a stranger has.
sys.path = [one for one in sys.path if not one.startswith(os.environ["PETZVAL_CHECKOUT"]) or ".venv" in one]
import bpy
# In a stranger's Blender there is no other Petzval.
assert not any(os.path.exists(os.path.join(one, "petzval")) for one in sys.path), sys.path
bpy.ops.extensions.package_install_files(filepath=sys.argv[1], repo="user_default", enable_on_install=True)
import petzval
home = os.environ["BLENDER_USER_RESOURCES"]
print("WHEEL", petzval.__file__.startswith(home), "ADDON", "bl_ext.user_default.petzval" in bpy.context.preferences.addons)
bpy.context.scene.petzval.samples = 2
sys.argv = ["x", sys.argv[2]]
"""


def test_the_extension_installs_into_this_blender(extension_zip, tmp_path):
    """Offline and with nothing of the checkout in sight; then it renders."""
    script, image = tmp_path / "install.py", tmp_path / "image.exr"
    script.write_text(INSTALL + RENDER + "sys.stdout.flush(); os._exit(0)\n")
    # Python takes no more of the environment's packages than bpy: its `.pth` names the checkout.
    place = subprocess.run(
        [sys.executable, "-c", "import importlib.util; print(importlib.util.find_spec('bpy').origin)"],
        capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    packages = tmp_path / "packages"
    packages.mkdir()
    site = Path(place.strip()).parent.parent
    for one in site.iterdir():
        if one.suffix != ".pth" and not one.name.startswith("petzval"):
            (packages / one.name).symlink_to(one)
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PETZVAL", "PYTHON"))}
    environment = kept | {
        "BLENDER_USER_RESOURCES": str(tmp_path / "user"),
        "PYTHONPATH": str(packages),
        "PETZVAL_CHECKOUT": str(ROOT),
        # A connection that leads nowhere.
        "http_proxy": "http://127.0.0.1:9",
        "https_proxy": "http://127.0.0.1:9",
    }
    done = subprocess.run(
        [sys.executable, "-S", script, extension_zip, image],
        capture_output=True, text=True, check=False, timeout=240, env=environment, cwd=tmp_path,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert "WHEEL True ADDON True" in done.stdout, done.stdout + done.stderr
    result = next(line for line in done.stdout.splitlines() if line.startswith("MEAN")).split()
    assert 0.001 < float(result[1]) < 10.0 and result[3] == "True", done.stdout + done.stderr
