# SPDX-License-Identifier: GPL-3.0-or-later
"""Spot diagrams: a row a field, a column a place of the film."""

from __future__ import annotations

import argparse
import math
from typing import Any

from ..argument_types import natural, number
from .page import DARK, degrees, lengths, line_colours, line_names
from .report import LensReport
from .table import Table, per_line

#: Inches of a spot.
_SIDE_IN = 2.6
_MARKS = ("o", "^", "s", "D", "v")


def size_in(found: dict[str, Any]) -> tuple[float, float]:
    """The size of the report."""
    rows, columns = _shape(found)
    return max(_SIDE_IN * columns + 0.6, 6.6), _SIDE_IN * rows + 0.6


def _shape(found: dict[str, Any]) -> tuple[int, int]:
    """Rows and columns. Of one place of the film the fields stand side by side."""
    places, fields = len(found["defocus"]), len(found["defocus"][0]["fields"])
    return (fields, places) if places > 1 else (1, fields)


def draw(found: dict[str, Any], figure: Any) -> None:
    """Draws into a figure: all spots to one scale."""
    every = [(place, field) for place in found["defocus"] for field in place["fields"]]
    lit = [field["largest_mm"] for _, field in every if not field["is_dark"]]
    half_mm = _round_up(1.08 * max([*lit, found["airy_radius_mm"] or 0.0, 1e-9]))
    factor, unit = lengths(half_mm)
    rows, columns = _shape(found)
    grid = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    for i, (place, field) in enumerate(every):
        # Places go across and fields down, or fields across.
        row, column = (i % rows, i // rows) if rows > 1 else (0, i)
        axes = grid[row][column]
        _spot(found, field, axes, half_mm, (factor, unit))
        angle = degrees(field["angle_deg"])
        if column == 0:
            axes.set_ylabel(f"{angle}\ntangential, {unit}" if rows > 1 else f"tangential, {unit}")
        if row == rows - 1:
            axes.set_xlabel(f"sagittal, {unit}")
        if rows == 1:
            axes.set_title(angle, color=DARK)
        elif row == 0:
            axes.set_title(f"film {place['defocus_mm']:+.4g} mm", color=DARK)
    _legend(found, figure)


def _spot(found: dict[str, Any], field: dict[str, Any], axes: Any, half_mm: float, scale: tuple[float, str]) -> None:
    factor, unit = scale
    axes.set_aspect("equal")
    axes.set_xlim(-half_mm * factor, half_mm * factor)
    axes.set_ylim(-half_mm * factor, half_mm * factor)
    axes.spines[["top", "right"]].set_visible(True)
    axes.tick_params(length=2, labelsize=7.5)
    if field["is_dark"]:
        axes.text(0.0, 0.0, "dark", ha="center", va="center", color=DARK)
        return
    for i, (line, colour) in enumerate(zip(field["lines"], line_colours(found["wavelengths_nm"]), strict=True)):
        if line["points_mm"]:
            x, y = ([place * factor for place in places] for places in zip(*line["points_mm"], strict=True))
            mark = {"marker": _MARKS[i % len(_MARKS)], "markersize": 1.3, "markeredgewidth": 0.0}
            # As points of a picture: thousands of shapes would make the file as many lines long.
            axes.plot(x, y, linestyle="none", color=colour, rasterized=True, **mark)
    if found["airy_radius_mm"] is not None:
        airy = found["airy_radius_mm"] * factor
        turn = [2.0 * math.pi * i / 90 for i in range(91)]
        axes.plot([airy * math.cos(t) for t in turn], [airy * math.sin(t) for t in turn], color="black", linewidth=0.7)
    said = f"RMS {field['rms_mm'] * factor:.3g}   largest {field['largest_mm'] * factor:.3g} {unit}"
    axes.text(0.5, 0.985, said, transform=axes.transAxes, ha="center", va="top", fontsize=7.5, color=DARK)


def _legend(found: dict[str, Any], figure: Any) -> None:
    axes, wavelengths = figure.axes[0], found["wavelengths_nm"]
    handles = [
        axes.plot([], [], "o", markersize=4, color=colour, label=name)[0]
        for colour, name in zip(line_colours(wavelengths), line_names(wavelengths), strict=True)
    ]
    if found["airy_radius_mm"] is not None:
        label = f"Airy's first dark ring, {found['airy_radius_mm'] * 1e3:.3g} µm"
        handles.append(axes.plot([], [], color="black", linewidth=0.7, label=label)[0])
    figure.legend(handles=handles, loc="outside lower center", ncols=min(len(handles), 4), fontsize=7.5)


def _round_up(value: float) -> float:
    """The value rounded up to the next of 1, 1.5, 2, 3, 5, 7 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in (1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0) if step * power >= value * (1 - 1e-12))


def _table(found: dict[str, Any]) -> Table:
    headings = ["film mm", "field °", "RMS mm", "largest mm", *per_line(found["wavelengths_nm"], "RMS mm at")]
    count = len(found["wavelengths_nm"])
    rows = []
    for place in found["defocus"]:
        for field in place["fields"]:
            lit = not field["is_dark"]
            numbers = [field["rms_mm"], field["largest_mm"]] if lit else ["dark", None]
            lines = [line["rms_mm"] for line in field["lines"]] if lit else [None] * count
            rows.append([place["defocus_mm"], field["angle_deg"], *numbers, *lines])
    return Table(headings, rows)


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--rays", type=natural, default=41, metavar="N", help="over the width of a beam; default: 41")
    parser.add_argument(
        "--defocus", nargs="+", type=number, default=[0.0], metavar="MM", help="a column for each place of the film"
    )


REPORT = LensReport(
    name="spots",
    label="Spot Diagrams",
    help="where the rays of a point meet the film",
    description="Where the rays of points meet the film",
    place=10,
    size_in=size_in,
    draw=draw,
    table=_table,
    title=lambda _found: "spot diagrams, about the middle of their light",
    options={"rays": 41, "defocus_mm": [0.0]},
    add_options=_add_options,
    options_of=lambda arguments: {"rays": arguments.rays, "defocus_mm": list(arguments.defocus)},
)
