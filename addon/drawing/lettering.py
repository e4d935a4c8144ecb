# SPDX-License-Identifier: GPL-3.0-or-later
"""Letters for plots: the outlines that Blender's own text objects have, with the font of its interface.

They are there without a window and in every version; Blender's `blf` draws into pictures in some versions alone.
"""

from __future__ import annotations

import os

import bpy
import numpy as np

_FONT = "Inter.woff2"
# What is drawn through; no data-block of the file has it after a plot.
_NAME = "Petzval's letters"
# Pieces of a curve between two of its points.
_PIECES = 5


class Letters:
    """Outlines of letters by Blender's text objects, for use in a `with`: at its end Blender's file is as before."""

    def __init__(self) -> None:
        self._known: dict[str, tuple[list[np.ndarray], float]] = {}

    def __enter__(self) -> Letters:
        self._fonts_before = set(bpy.data.fonts.keys())
        self._curve = bpy.data.curves.new(_NAME, "FONT")
        self._font = _interface_font()
        if self._font is not None:
            self._curve.font = self._font
        self._holder = bpy.data.objects.new(_NAME, self._curve)
        self._depsgraph = bpy.context.evaluated_depsgraph_get()
        # In units of the capitals' height; spaces have width only between letters.
        capital = self._shapes("H")
        self._capital = max(shape[:, 1].max() for shape in capital)
        self._bar = self._advance("||")
        return self

    def __exit__(self, *_error: object) -> None:
        bpy.data.objects.remove(self._holder)
        bpy.data.curves.remove(self._curve)
        for name in set(bpy.data.fonts.keys()) - self._fonts_before:
            bpy.data.fonts.remove(bpy.data.fonts[name])

    def outline(self, text: str) -> tuple[list[np.ndarray], float]:
        """See `petzval.plotting.figure.Lettering`."""
        if text not in self._known:
            shapes = [shape / self._capital for shape in self._shapes(text)] if text.strip() else []
            self._known[text] = shapes, (self._advance(f"|{text}|") - self._bar) / self._capital
        return self._known[text]

    def _advance(self, text: str) -> float:
        """The distance from the first letter to the last one, which are alike."""
        shapes = self._shapes(text)
        lefts = [shape[:, 0].min() for shape in shapes]
        return max(lefts) - min(lefts)

    def _shapes(self, text: str) -> list[np.ndarray]:
        self._curve.body = text
        drawn = self._holder.to_curve(self._depsgraph)
        shapes = [_line_of(spline.bezier_points) for spline in drawn.splines if spline.type == "BEZIER"]
        self._holder.to_curve_clear()
        return [shape for shape in shapes if len(shape) > 2]


def _interface_font() -> bpy.types.VectorFont | None:
    """Blender's interface font; None: the font that every text object has."""
    folder = bpy.utils.system_resource("DATAFILES", path="fonts")
    path = os.path.join(folder, _FONT) if folder else ""
    if not os.path.isfile(path):
        return None
    try:
        return bpy.data.fonts.load(path)
    except RuntimeError:
        return None


def _line_of(points: bpy.types.bpy_prop_collection) -> np.ndarray:
    """A closed Bézier curve as a polygon."""
    count = len(points)
    values = np.empty((3, count * 3), dtype=np.float32)
    for row, name in zip(values, ("handle_left", "co", "handle_right"), strict=True):
        points.foreach_get(name, row)
    before, at, after = (row.reshape(count, 3)[:, :2] for row in values)
    ends, before_ends = np.roll(at, -1, axis=0), np.roll(before, -1, axis=0)
    t = (np.arange(_PIECES) / _PIECES)[None, :, None]
    parts = ((1 - t) ** 3, 3 * (1 - t) ** 2 * t, 3 * (1 - t) * t**2, t**3)
    corners = (at, after, before_ends, ends)
    line = sum(part * corner[:, None] for part, corner in zip(parts, corners, strict=True))
    return line.reshape(-1, 2)
