# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/figures.md and its pictures. Needs Pillow."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from .figure import Caption, Figure, Taken
from .photograph import developed

HEAD = """# Figures

Figures 8 to 12 of Wu et al. 2011, and three that the paper could not make, photographed through lenses of the library in scenes of
`tests/scenes/gallery`. Numbers below a figure are computed, by exact rays through the prescription or
from the picture itself, and the build fails where a picture contradicts them; `tools/figures` says how.
"""
#: The space between pictures, and that for the line below one, pixels.
GAP, FOOT = 8, 30


def montage(figure: Figure, taken: dict[str, Taken], folder: Path) -> Image.Image:
    """The figure's pictures with their labels."""
    shown = [shot for shot in figure.shots if not shot.is_hidden]
    pictures = [Image.fromarray(developed(taken[shot.name], folder / f"{shot.name}.png")) for shot in shown]
    pictures = [
        p if shot.widened == 1.0 else p.resize((round(p.width * shot.widened), p.height), Image.LANCZOS)
        for shot, p in zip(shown, pictures, strict=True)
    ]
    wide = max(picture.width for picture in pictures)
    pictures = [
        p if p.width == wide else p.resize((wide, round(p.height * wide / p.width)), Image.LANCZOS) for p in pictures
    ]
    rows = [list(range(i, min(i + figure.columns, len(shown)))) for i in range(0, len(shown), figure.columns)]
    heights = [max(pictures[i].height for i in row) + FOOT for row in rows]
    sheet = Image.new("RGB", (figure.columns * (wide + GAP) - GAP, sum(heights)), "white")
    pen, y = ImageDraw.Draw(sheet), 0
    letters = ImageFont.load_default(size=min(20, wide // 24))
    for row, height in zip(rows, heights, strict=True):
        for column, i in enumerate(row):
            x = column * (wide + GAP)
            sheet.paste(pictures[i], (x, y))
            pen.text((x + 4, y + pictures[i].height + 3), shown[i].label, fill="#222222", font=letters)
        y += height
    return sheet


def chapter(figure: Figure, caption: Caption) -> str:
    """The chapter of a figure on the page."""
    lines = [
        f"## {figure.title}",
        "",
        f"![{figure.title}](images/figures/{figure.key}.jpg)",
        "",
        " ".join(caption.sentences),
    ]
    if caption.rows:
        lines += ["", "| " + " | ".join(caption.head) + " |", "|---" + "|---:" * (len(caption.head) - 1) + "|"]
        lines += ["| " + " | ".join(row) + " |" for row in caption.rows]
    return "\n".join(lines) + "\n"


def save(sheet: Image.Image, path: Path) -> None:
    """Saves a sheet as a JPEG that a page can hold."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if sheet.width > 1940:
        sheet = sheet.resize((1940, round(sheet.height * 1940 / sheet.width)), Image.LANCZOS)
    sheet.save(path, quality=90)


def crop(light: np.ndarray, centre: tuple[float, float], radius: int) -> np.ndarray:
    """A square of pixels about (column, row)."""
    column, row = (round(at) for at in centre)
    return light[max(row - radius, 0) : row + radius + 1, max(column - radius, 0) : column + radius + 1]
