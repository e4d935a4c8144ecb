# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of a report, for a terminal: numbers in columns under their headings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Table:
    """Headings with their units, and rows of as many cells; None where there is no number."""

    headings: Sequence[str]
    rows: Sequence[Sequence[float | str | None]]

    def lines(self) -> list[str]:
        """The table as text, a line a row, columns set flush right."""
        rows = [[_text(cell) for cell in row] for row in self.rows]
        widths = [max(len(row[i]) for row in [self.headings, *rows]) for i in range(len(self.headings))]
        return [
            "  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
            for row in [self.headings, *rows]
        ]


def _text(cell: float | str | None) -> str:
    if cell is None:
        return "-"
    if isinstance(cell, str):
        return cell
    # What is left of a zero by rounding is none.
    return f"{0.0 if abs(cell) < 1e-12 else cell:.4g}"


def per_line(wavelengths_nm: Sequence[float], what: str) -> list[str]:
    """A heading for each wavelength."""
    return [f"{what} {nm:.4g} nm" for nm in wavelengths_nm]
