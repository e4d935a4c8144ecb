# SPDX-License-Identifier: GPL-3.0-or-later
"""The legend of a plot: its lines and their names."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .figure import Figure
    from .lines import Line

#: Sizes in letters: a line's sample, the space after it and between columns; a row.
_SAMPLE, _SPACE, _BETWEEN, _ROW = 1.9, 0.7, 1.6, 1.5


@dataclass(frozen=True)
class Legend:
    """Rows and columns, filled column by column."""

    lines: list[Line]
    size_pt: float
    columns: int

    def size(self, figure: Figure) -> tuple[float, float]:
        """Width and height, pixels."""
        em = figure.pixels(self.size_pt)
        widths = self._widths(figure)
        return sum(widths) + _BETWEEN * em * (len(widths) - 1), _ROW * em * self._rows()

    def draw(self, figure: Figure, x: float, y: float) -> None:
        """Draws the legend with its upper left corner at (x, y)."""
        em = figure.pixels(self.size_pt)
        for widths, lines in zip(self._widths(figure), self._by_column(), strict=True):
            for i, line in enumerate(lines):
                middle = y - _ROW * em * (i + 0.5)
                ends = np.array([[x, middle], [x + _SAMPLE * em, middle]])
                line.sample(figure, ends)
                place = x + (_SAMPLE + _SPACE) * em
                figure.write(place, middle, line.label, fontsize=self.size_pt, va="center", color="#333333")
            x += widths + _BETWEEN * em

    def _rows(self) -> int:
        return -(-len(self.lines) // max(self.columns, 1))

    def _by_column(self) -> list[list[Line]]:
        # As many rows as the longest column needs; what is over goes to the first columns.
        count = min(self.columns, len(self.lines))
        short, over = divmod(len(self.lines), count) if count else (0, 0)
        starts = [i * short + min(i, over) for i in range(count + 1)]
        return [self.lines[a:b] for a, b in zip(starts, starts[1:], strict=False)]

    def _widths(self, figure: Figure) -> list[float]:
        em = figure.pixels(self.size_pt)
        names = [[figure.measure(line.label, self.size_pt) for line in lines] for lines in self._by_column()]
        return [(_SAMPLE + _SPACE) * em + max(found, default=0.0) for found in names]
