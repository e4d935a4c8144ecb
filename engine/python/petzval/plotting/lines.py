# SPDX-License-Identifier: GPL-3.0-or-later
"""A line of a plot, or the marks at its points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .strokes import clipped, dashed, marks, stroke

if TYPE_CHECKING:
    from .figure import Figure


def colour_of(text: str) -> tuple[float, float, float]:
    """#rrggbb, white or black, as numbers."""
    text = {"white": "#ffffff", "black": "#000000"}.get(text, text)
    red, green, blue = (int(text[i : i + 2], 16) / 255.0 for i in (1, 3, 5))
    return red, green, blue


@dataclass
class Line:
    """A line of a plot, its look as matplotlib's words have it; lengths in points."""

    x: Any
    y: Any
    color: str = "black"
    linewidth: float = 1.5
    dashes: Sequence[float] = ()
    label: str = ""
    marker: str = ""
    markersize: float = 6.0
    has_line: bool = True
    alpha: float = 1.0
    zorder: float = 2.0
    #: The direction of an infinite line: "x" where `x` is its place, "y" where `y` is.
    endless: str = ""
    hollow: bool = False

    def paint(self, figure: Figure, points: Any, low: Any, high: Any) -> None:
        """Within a box of pixels."""
        width = max(figure.pixels(self.linewidth), 0.8)
        colour = colour_of(self.color)
        if self.has_line:
            pieces = clipped(points, low, high)
            if self.dashes:
                # A dash is so many widths of the line.
                pattern = [dash * max(width, 1.2) for dash in self.dashes]
                pieces = [dash for piece in pieces for dash in dashed(piece, pattern)]
            figure.canvas.fill([shape for piece in pieces for shape in stroke(piece, width)], colour, self.alpha)
        if self.marker:
            inside = points[np.all((points >= np.asarray(low) - 1e-6) & (points <= np.asarray(high) + 1e-6), axis=1)]
            size = max(figure.pixels(self.markersize), 1.6)
            if self.hollow:
                rings = [edge for shape in marks(inside, self.marker, size) for edge in stroke(shape, 1.6, closed=True)]
                figure.canvas.fill(rings, colour, self.alpha)
            else:
                figure.canvas.fill(marks(inside, self.marker, size), colour, self.alpha)

    def sample(self, figure: Figure, ends: Any) -> None:
        """Draws a sample of the line in a legend."""
        low, high = (0.0, 0.0), (figure.width, figure.height)
        if self.has_line:
            Line(0, 0, self.color, self.linewidth, self.dashes, alpha=self.alpha).paint(figure, ends, low, high)
        if self.marker:
            look = Line(0, 0, self.color, marker=self.marker, markersize=self.markersize, has_line=False, hollow=self.hollow)  # fmt: skip
            look.paint(figure, ends.mean(axis=0, keepdims=True), low, high)
