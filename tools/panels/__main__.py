# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m panels`, tools/ on the path, Pillow installed, the extension built: docs/images/panel-*.png. `make panel-pictures`."""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pages
from PIL import Image, ImageChops

ROOT = Path(__file__).resolve().parents[2]
PICTURES = ROOT / "docs/images"
ADDON = "bl_ext.user_default.petzval"
#: Rows of a picture at most: longer panels are cut off below.
MOST_ROWS = 760
#: The border of the area; and the line with the scene's or the camera's name, above the panels.
_BORDER_PX, _CONTEXT_PX = 12, 38


def main() -> int:
    asked = argparse.ArgumentParser(prog="panels", description="Photographs the panels.")
    asked.add_argument("--extension", type=Path, help="default: the newest in dist/")
    asked.add_argument("--output", type=Path, default=PICTURES)
    options = asked.parse_args()
    began, origin = time.monotonic(), pages.made("docs/panel.md")
    built = sorted((ROOT / "dist").glob("petzval-*.zip"), key=lambda one: one.stat().st_mtime)
    if not (options.extension or built):
        print("panels: no extension in dist/: run make extension", file=sys.stderr)
        return 1
    extension = (options.extension or built[-1]).resolve()
    with tempfile.TemporaryDirectory(prefix="petzval-panels-") as folder:
        os.environ["TMPDIR"] = folder
        _blender("--command", "extension", "install-file", "-r", "user_default", "--enable", extension)
        said = _blender(
            "--in-window",
            ROOT / "tests/scenes/demo.blend",
            "--addons",
            ADDON,
            "--python",
            Path(__file__).with_name("steps.py"),
            "--",
            folder,
            ADDON,
        )
        found = Path(folder) / "seen.json"
        if not found.exists():
            raise SystemExit(f"panels: Blender ended before its time:\n{said[-4000:]}")
        seen = json.loads(found.read_text())
        if "error" in seen:
            raise SystemExit(f"panels: {seen['error']}\n{said[-4000:]}")
        for name, box in seen.items():
            picture = _trimmed(Image.open(Path(folder) / f"{name}.png").convert("RGB").crop(box))
            target = options.output / f"panel-{name}.png"
            # A few dozen colours are the interface's own.
            picture.quantize(192, dither=Image.Dither.NONE).save(target, optimize=True)
            print(f"{target}: {picture.width} x {picture.height}")
    if options.output == PICTURES:
        pages.stamp("docs/panel.md", origin.took(time.monotonic() - began))
    return 0


def _trimmed(picture: Image.Image) -> Image.Image:
    """The picture without the line above the panels, and the empty rows below the last."""
    width, height = picture.size
    picture = picture.crop((0, _CONTEXT_PX, width, height - _BORDER_PX))
    ground = Image.new("RGB", picture.size, picture.getpixel((_BORDER_PX, picture.height - 1)))
    # At the right edge stands a scroll bar.
    inner = (_BORDER_PX, 0, width - _BORDER_PX, picture.height)
    box = ImageChops.difference(picture, ground).crop(inner).getbbox()
    return picture.crop((0, 0, width, min((box[3] if box else height) + 4, MOST_ROWS)))


def _blender(*arguments: object) -> str:
    done = subprocess.run(
        [str(ROOT / "tools/blender"), *map(str, arguments)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        check=False,
        timeout=600,
    )
    if done.returncode:
        raise SystemExit(f"panels: Blender ended with {done.returncode}:\n{done.stdout[-4000:]}")
    return done.stdout


if __name__ == "__main__":
    sys.exit(main())
