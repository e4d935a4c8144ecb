# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture with plots: those of matplotlib's methods that Petzval's drawings use, with their names and their meaning."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from .axes import Axes, Place
from .legend import Legend
from .lines import Line, colour_of
from .raster import Canvas, Polygon
from .strokes import stroke

#: Points of an inch.
_POINTS = 72.0
#: Parts of a letter's size: its capitals, and a bold letter's stroke.
CAPITALS, _BOLD = 0.72, 0.055
#: Room between plots one below the other and side by side, in letters.
_GAP, _GAP_ACROSS = 0.9, 2.4


class Lettering(Protocol):
    """The source of letters' outlines."""

    def outline(self, text: str) -> tuple[list[Polygon], float]:
        """The outlines of a line of text, capitals as high as 1, from the origin of its first letter; and its width."""


class GridSpec:
    """A grid of plots: `grid[row, column]` is the place of one, `grid[row, :]` that of one over a whole row."""

    def __init__(self, columns: int) -> None:
        self._columns = columns

    def __getitem__(self, key: tuple[int, int | slice]) -> Place:
        row, column = key
        if isinstance(column, slice):
            return row, 0, self._columns - 1
        return row, column, column


class Figure:
    """A figure so many inches wide and high. `has_grid`: plots have lines at their ticks, and no box."""

    def __init__(
        self, size_in: tuple[float, float], lettering: Lettering, *, dpi: float = 150.0, has_grid: bool = True
    ) -> None:
        self.dpi, self.lettering, self.has_grid = dpi, lettering, has_grid
        self.width, self.height = round(size_in[0] * dpi), round(size_in[1] * dpi)
        self.axes: list[Axes] = []
        #: Pixels that plots may take: left, low, right, high.
        self.room = (0.01 * self.width, 0.01 * self.height, 0.99 * self.width, 0.99 * self.height)
        self.font_size = 9.0
        self.canvas = Canvas(self.width, self.height)
        self._grid: tuple[int, int, Sequence[float]] | None = None
        self._texts: list[tuple[float, float, str, dict[str, Any]]] = []
        self._legend: tuple[Legend, str, tuple[float, float]] | None = None

    def pixels(self, points: float) -> float:
        """The pixels of a length in points."""
        return points * self.dpi / _POINTS

    def subplots(
        self, rows: int = 1, columns: int = 1, *, squeeze: bool = True, sharex: bool = False, sharey: bool = False,
        width_ratios: Sequence[float] | None = None,
    ) -> Any:  # fmt: skip
        """Plots in a grid; an array of them, but one alone, or one row."""
        self._grid = rows, columns, width_ratios or [1.0] * columns
        grid = [[Axes(self, (row, column, column)) for column in range(columns)] for row in range(rows)]
        for row, line in enumerate(grid):
            for column, axes in enumerate(line):
                axes.share_x = grid[0][0] if sharex else axes
                axes.share_y = grid[0][0] if sharey else axes
                axes.names_x = not sharex or row == rows - 1
                axes.names_y = not sharey or column == 0
                self.axes.append(axes)
        if not squeeze:
            return grid
        return (grid[0][0] if columns == 1 else grid[0]) if rows == 1 else grid

    def add_gridspec(self, rows: int, columns: int) -> GridSpec:
        """A grid for `add_subplot`."""
        self._grid = rows, columns, [1.0] * columns
        return GridSpec(columns)

    def add_subplot(self, place: Place) -> Axes:
        """A plot in a place of the grid."""
        axes = Axes(self, place)
        self.axes.append(axes)
        return axes

    def add_axes(self, rectangle: tuple[float, float, float, float]) -> Axes:
        """A plot in that part of the picture: left, low, width, height."""
        left, low, width, height = rectangle
        axes = Axes(self, None)
        axes.box = (left * self.width, low * self.height, (left + width) * self.width, (low + height) * self.height)
        self.axes.append(axes)
        return axes

    def text(self, x: float, y: float, text: str, **look: Any) -> None:
        """Adds text at parts of the width and height."""
        self._texts.append((x * self.width, y * self.height, text, look))

    def legend(
        self, *, handles: list[Line] | None = None, loc: str, ncols: int = 1, fontsize: float | None = None,
        bbox_to_anchor: tuple[float, float] = (0.0, 0.0), **_look: Any,
    ) -> None:  # fmt: skip
        """Adds a legend under all plots, in the middle ("outside lower center") or at a place ("lower left")."""
        lines = handles or [line for axes in self.axes for line in axes.lines if line.label]
        self._legend = Legend(lines, fontsize or self.font_size, ncols), loc, bbox_to_anchor

    def measure(self, text: str, size: float) -> float:
        """Width in pixels of a line of text of that many points."""
        return self.lettering.outline(text)[1] * CAPITALS * self.pixels(size)

    def write(
        self, x: float, y: float, text: str, *, fontsize: float | None = None, color: str = "black", ha: str = "left",
        va: str = "baseline", weight: str = "normal", turned: bool = False, linespacing: float = 1.35,
    ) -> None:  # fmt: skip
        """Lines of text at a pixel; `turned`: from below to above."""
        size = fontsize or self.font_size
        capital, lines = CAPITALS * self.pixels(size), text.split("\n")
        step = linespacing * self.pixels(size)
        tall = capital + step * (len(lines) - 1)
        top = {"top": 0.0, "center": 0.5 * tall, "bottom": tall, "baseline": tall}[va]
        shapes = []
        for i, line in enumerate(lines):
            outlines, width = self.lettering.outline(line)
            across = {"left": 0.0, "center": -0.5, "right": -1.0}[ha] * width * capital
            for outline in outlines:
                placed = outline * capital + (across, top - capital - i * step)
                placed = np.stack([-placed[:, 1], placed[:, 0]], axis=1) if turned else placed
                shapes.append(placed + (x, y))
        self.canvas.fill(shapes, colour_of(color))
        if weight == "bold":
            edges = [edge for shape in shapes for edge in stroke(shape, _BOLD * capital / CAPITALS, closed=True)]
            self.canvas.fill(edges, colour_of(color))

    def drawn(self) -> npt.NDArray[np.float32]:
        """The picture, (height, width, 4), first row at the bottom, as a screen shows it."""
        self._place()
        for axes in self.axes:
            axes.draw()
        if self._legend:
            legend, loc, (x, y) = self._legend
            width, height = legend.size(self)
            if loc.startswith("outside"):
                legend.draw(self, 0.5 * (self.width - width), self.room[1] + height)
            else:
                legend.draw(self, x * self.width, y * self.height + height + self.pixels(6.0))
        for x, y, text, look in self._texts:
            self.write(x, y, text, **look)
        pixels = np.ones((self.height, self.width, 4), dtype=np.float32)
        pixels[:, :, :3] = self.canvas.pixels
        return pixels

    def _place(self) -> None:
        """Gives the plots of the grid their boxes, all with room for the words about them."""
        if self._grid is None:
            return
        rows, columns, ratios = self._grid
        left, low, right, high = self.room
        if self._legend and self._legend[1].startswith("outside"):
            low += self._legend[0].size(self)[1] + self.pixels(4.0)
        gap, across = _GAP * self.pixels(self.font_size), _GAP_ACROSS * self.pixels(self.font_size)
        lefts, rights, lows, highs = [0.0] * columns, [0.0] * columns, [0.0] * rows, [0.0] * rows
        for axes in self.axes:
            if axes.place is None:
                continue
            row, first, last = axes.place
            around = axes.margins()
            for most, i, margin in ((lefts, first, around[0]), (lows, row, around[1]), (rights, last, around[2]), (highs, row, around[3])):  # fmt: skip
                most[i] = max(most[i], margin)
        wide = right - left - sum(lefts) - sum(rights) - across * (columns - 1)
        tall = (high - low - sum(lows) - sum(highs) - gap * (rows - 1)) / rows
        for axes in self.axes:
            if axes.place is None:
                continue
            row, first, last = axes.place
            # The left edges of the plots in the first and in the last of its columns.
            begin, end = (
                left + sum(lefts[: c + 1]) + sum(rights[:c]) + across * c + wide * sum(ratios[:c]) / sum(ratios)
                for c in (first, last)
            )
            y = high - sum(highs[: row + 1]) - sum(lows[:row]) - (gap + tall) * row
            axes.box = (begin, y - tall, end + wide * ratios[last] / sum(ratios), y)
