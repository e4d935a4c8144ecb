#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps the pictures of the tests of Blender's window, output/window/*.png, in docs/ui/ where a person can look at it. `make
ui-pictures`."""

from __future__ import annotations

import sys
from pathlib import Path

import pages
from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
FROM, TO = ROOT / "output/window", ROOT / "docs/ui"
#: Name, caption, and the part of the screen: left, top, right, bottom; None is all.
PICTURES = (
    ("panel-drawing", "The camera's Lens panel with the drawing of the lens as it is set", None),
    ("gallery", "Lenses chosen by their pictures", None),
    ("panel-data", "Focus, film and scale of a lens", None),
    ("panel-autofocus", "Autofocus: what it finds, and where", None),
    ("panel-sharp", "Three objects that the film is turned for", None),
    ("panel-missing", "A lens file that is missing is said in its panel", None),
    ("panel-thin", "A thin lens: Blender's own rows", None),
    ("panel-pinhole", "Through the Lens is off: an ordinary camera", None),
    ("panel-render", "Render properties", None),
    ("panel-view_layer", "View layer: passes", None),
    ("panel-object", "Object: visibility, motion blur, shadow terminator", None),
    ("panel-material", "Material", None),
    ("panel-light", "Light", None),
    ("panel-world", "World", None),
    ("rendering-1", "A final render on its way", None),
    ("rendered", "And at its end", None),
    ("error", "A lens that is missing, told by Blender", None),
    ("viewport-camera", "A 3D view through the lens", None),
    ("viewport-stopped-down", "The same at f/16", None),
    ("viewport-perspective", "Blender's own perspective: all is sharp", None),
    ("viewport-missing", "What is wrong is told in the view", None),
)
_WIDTH = 1200


def main() -> int:
    TO.mkdir(parents=True, exist_ok=True)
    lines = [
        "# The interface, as the tests saw it",
        "",
        "Blender 4.3 under Xvfb.",
        "",
    ]
    wanted = set()
    for name, text, part in PICTURES:
        source = FROM / f"{name}.png"
        if not source.exists():
            continue
        picture = Image.open(source).convert("RGB")
        picture = picture.crop(part) if part else picture
        picture = picture.resize((_WIDTH, round(_WIDTH * picture.height / picture.width)), Image.Resampling.LANCZOS)
        # A few dozen colours are the interface's own.
        picture.quantize(192, dither=Image.Dither.NONE).save(TO / f"{name}.png", optimize=True)
        wanted.add(f"{name}.png")
        lines += [f"## {text}", "", f"![{text}]({name}.png)", ""]
    if not wanted:
        print("ui-pictures: no pictures in output/window: run the window's tests first", file=sys.stderr)
        return 1
    for old in TO.glob("*.png"):
        if old.name not in wanted:
            old.unlink()
    text = "\n".join(lines).rstrip() + "\n"
    (TO / "README.md").write_text(pages.stamped(text, pages.made("docs/ui/README.md")), encoding="utf-8")
    print(f"{TO}: {len(wanted)} pictures")
    return 0


if __name__ == "__main__":
    sys.exit(main())
