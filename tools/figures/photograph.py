# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes the photographs: builds a scene once, renders it by the command `petzval render`, and reads the picture. Needs bpy."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np

from .figure import Shot, Taken

ROOT = Path(__file__).resolve().parents[2]
GALLERY = ROOT / "tests/scenes/gallery"
#: Pixels of width, samples of a shot that is hidden, and of one that is shown: a reader sees noise that a check does not mind.
SIZES = {"smallest": (120, 16, 16), "small": (240, 24, 24), "full": (480, 64, 128), "large": (960, 192, 512)}
#: The largest factor of samples of a shot that asks for more, but where noise decides.
MOST = {"smallest": 4.0, "small": 4.0, "full": 1.0, "large": 1.0}


class Studio:
    """The folder of scenes and photographs; files of a run with the same wishes are not made again."""

    def __init__(self, folder: Path, size: str, *, again: bool = True) -> None:
        self.folder, self.size, self.again = folder, size, again
        folder.mkdir(parents=True, exist_ok=True)
        self._scenes: dict[tuple[str, str], Path] = {}

    def scene(self, name: str, view: str) -> Path:
        """The .blend of a view."""
        path = self.folder / f"{name}{'-' + view if view else ''}.blend"
        if (name, view) not in self._scenes:
            if self.again or not path.exists():
                _run(sys.executable, GALLERY / f"{name}.py", path, *([view] if view else []))
            self._scenes[name, view] = path
        return path

    def take(self, shot: Shot) -> Taken:
        """Renders the shot."""
        width, hidden, shown = SIZES[self.size]
        samples = hidden if shot.is_hidden else shown
        times = shot.samples if "--noise-threshold" in shot.options else min(shot.samples, MOST[self.size])
        width, samples = round(width * shot.width), max(round(samples * times), 1)
        size = f"{width}x{round(width / shot.aspect)}"
        blend, exr, stats = self.scene(shot.scene, shot.view), self._of(shot, "exr"), self._of(shot, "json")
        asked = self._of(shot, "txt")
        options = ["--lens", shot.lens] if shot.lens else []
        options += [*shot.options, "--resolution", size]
        if "--samples" not in options:
            options += ["--samples", str(samples)]
        wish = " ".join(options)
        if self.again or not stats.exists() or not asked.exists() or asked.read_text() != wish:
            _run(sys.executable, "-m", "petzval", "render", blend, *options, "-o", exr, "--stats", stats)
            asked.write_text(wish)
        return Taken(shot, read(exr), exr, blend, json.loads(stats.read_text()))

    def _of(self, shot: Shot, ending: str) -> Path:
        return self.folder / f"{shot.name}.{ending}"


def _run(*command: object) -> None:
    done = subprocess.run([*map(str, command)], capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"{' '.join(map(str, command))}\n{done.stdout[-2000:]}{done.stderr[-4000:]}")


def read(exr: Path) -> np.ndarray:
    """Light of a file: (height, width, 3), the first row at the top."""
    import bpy

    image = bpy.data.images.load(str(exr), check_existing=False)
    image.colorspace_settings.name = "Non-Color"
    width, height = image.size
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(height, width, -1)[::-1, :, :3].astype(float)


def developed(taken: Taken, png: Path) -> np.ndarray:
    """The picture as the scene's view shows it: (height, width, 3), 0 to 255."""
    import bpy
    from PIL import Image

    bpy.ops.wm.open_mainfile(filepath=str(taken.blend), load_ui=False)
    image = bpy.data.images.load(str(taken.exr), check_existing=False)
    settings = bpy.context.scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "PNG", "RGB", "8"
    image.save_render(str(png), scene=bpy.context.scene)
    bpy.data.images.remove(image)
    return np.asarray(Image.open(png).convert("RGB"))
