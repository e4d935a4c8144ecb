# SPDX-License-Identifier: GPL-3.0-or-later
"""The life of an installation in the real Blender: from a static repository, through an update, to its removal."""

from __future__ import annotations

import os
import subprocess
import tomllib
import zipfile
from pathlib import Path

import pytest

from support.places import ROOT

pytestmark = [pytest.mark.real_blender, pytest.mark.once]

NAME = "bl_ext.petzval_releases.petzval"
#: What a user keeps: a favourite, a preset, the settings of a file; and what is seen of them.
KEEP = """
import json, os, sys
import bpy, importlib
addon = importlib.import_module("bl_ext.petzval_releases.petzval")
blend, picture, is_first = sys.argv[-3], sys.argv[-2], sys.argv[-1] == "first"
favourites = importlib.import_module(addon.__name__ + ".data.favourites")
if is_first:
    favourites.toggle("tessar-brendel")
    scene = bpy.context.scene
    scene.render.engine = "PETZVAL"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 24, 16, 100
    scene.petzval.samples, scene.petzval.seed = 2, 7
    scene.camera.data.petzval.model = "LENS"
    scene.camera.data.petzval.lens_file = "tessar-brendel.lens"
    scene.camera.data.petzval.f_number = 5.6
    folder = bpy.utils.user_resource("SCRIPTS", path=os.path.join("presets", "petzval", "camera"), create=True)
    with open(os.path.join(folder, "mine.py"), "w", encoding="utf-8") as out:
        out.write("import bpy\\n")
    bpy.ops.wm.save_as_mainfile(filepath=blend)
bpy.ops.wm.open_mainfile(filepath=blend)
scene = bpy.context.scene
own = scene.camera.data.petzval
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"
scene.render.filepath = picture
bpy.ops.render.render(write_still=True)
presets = bpy.utils.user_resource("SCRIPTS", path=os.path.join("presets", "petzval", "camera"))
pixels = bpy.data.images.load(picture).pixels[:]
print("KEPT", json.dumps({
    "favourites": favourites.all_of_them(), "presets": sorted(os.listdir(presets)), "engine": scene.render.engine,
    "settings": [scene.petzval.samples, scene.petzval.seed, own.model, own.lens_file, round(own.f_number, 5)],
    "pixels": [round(sum(pixels[i::4]), 3) for i in range(3)],
}), flush=True)
"""


class Installation:
    """A Blender with folders of its own, and a repository that it knows."""

    def __init__(self, folder: Path, extension: Path) -> None:
        self.user, self.repository, self.extension = folder / "user", folder / "repo é", extension
        self.user.mkdir()
        self.repository.mkdir()
        self.folder = folder

    def run(self, *arguments: object) -> str:
        environment = os.environ | {"BLENDER_USER_RESOURCES": str(self.user), "TMPDIR": str(self.folder)}
        done = subprocess.run(
            [ROOT / "tools/blender", *map(str, arguments)], env=environment, cwd=self.folder, stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace", timeout=300, check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stdout
        return done.stdout

    def publish(self, version: str) -> None:
        """Puts the extension there, under a version."""
        for old in self.repository.glob("*.zip"):
            old.unlink()
        out = self.repository / self.extension.name.replace(self.current, version)
        with zipfile.ZipFile(self.extension) as source, zipfile.ZipFile(out, "w", zipfile.ZIP_STORED) as target:
            for info in source.infolist():
                data = source.read(info)
                if info.filename == "blender_manifest.toml":
                    data = data.replace(f'\nversion = "{self.current}"'.encode(), f'\nversion = "{version}"'.encode())
                target.writestr(info, data)
        self.run("--command", "extension", "server-generate", "--repo-dir", self.repository)

    @property
    def current(self) -> str:
        with zipfile.ZipFile(self.extension) as archive:
            return tomllib.loads(archive.read("blender_manifest.toml").decode())["version"]

    def version(self) -> str:
        manifest = self.user / "extensions/petzval_releases/petzval/blender_manifest.toml"
        return tomllib.loads(manifest.read_text())["version"]

    def kept(self, *which: str) -> str:
        """The line about kept settings that a run of Blender prints."""
        script = self.folder / "keep.py"
        script.write_text(KEEP)
        words = ["-b", "--addons", NAME, "--python-exit-code", "3", "--python", script, "--"]
        said = self.run(*words, self.folder / "kept.blend", self.folder / "kept.exr", *which)
        return next(line for line in said.splitlines() if line.startswith("KEPT"))

    def own_files(self) -> list[str]:
        """Files of Petzval among the extensions, the list of what the repository offers left out."""
        found = [path for path in (self.user / "extensions").rglob("*") if path.is_file()]
        return [
            str(path)
            for path in found
            if "petzval" in path.relative_to(self.user).as_posix().split("petzval_releases")[-1]
        ]


def test_from_installation_through_an_update_to_removal(run_blender, extension_zip, tmp_path):
    one = Installation(tmp_path, extension_zip)
    one.publish("0.0.9")
    url = one.repository.as_uri() + "/index.json"
    one.run("--command", "extension", "repo-add", "--name", "Petzval", "--url", url, "petzval_releases")
    one.run("--online-mode", "--command", "extension", "sync")
    one.run("--online-mode", "--command", "extension", "install", "--enable", "petzval_releases.petzval")
    assert one.version() == "0.0.9"
    before = one.kept("first")
    assert '"favourites": ["tessar-brendel.lens"]' in before or '"favourites": ["tessar-brendel"]' in before
    assert '"mine.py"' in before and '"settings": [2, 7, "LENS", "tessar-brendel.lens", 5.6]' in before

    one.publish("9.9.9")
    one.run("--online-mode", "--command", "extension", "sync")
    one.run("--online-mode", "--command", "extension", "update")
    assert one.version() == "9.9.9"
    assert one.kept("again") == before

    assert len(one.own_files()) > 200
    one.run("--command", "extension", "remove", "petzval_releases.petzval")
    assert one.own_files() == []
    # What the user made stays: Blender keeps it for whoever installs the add-on again.
    assert (one.user / "config/petzval/favourite-lenses.json").is_file()
