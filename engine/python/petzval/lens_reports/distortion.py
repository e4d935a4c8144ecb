# SPDX-License-Identifier: GPL-3.0-or-later
"""Field curvature, distortion and lateral colour, over the angle of the field."""

from __future__ import annotations

import argparse
from typing import Any

from ..argument_types import natural
from .page import DARK, lengths, line_colours, line_names
from .report import LensReport
from .table import Table

#: The half field from which on nobody wants a picture by the tangent: distortion is that from heights by the angle.
_FISHEYE_DEG = 60.0


def size_in(found: dict[str, Any]) -> tuple[float, float]:
    """The size of the report."""
    return 10.0, 4.2


def draw(found: dict[str, Any], figure: Any) -> None:
    """Draws the report into a figure."""
    curvature, distortion, colour = figure.subplots(1, 3, sharey=True)
    lit = [field for field in found["fields"] if not field["is_dark"]]
    for axes in (curvature, distortion, colour):
        axes.axvline(0.0, color=DARK, linewidth=0.6)
    _curvature(lit, curvature)
    _distortion(lit, distortion)
    _colour(found, lit, colour)
    if lit:
        low, high = min(field["angle_deg"] for field in lit), max(field["angle_deg"] for field in lit)
        curvature.set_ylim(low, high if high > low else low + 1.0)
    curvature.set_ylabel("field, degrees")


def _curvature(lit: list[dict[str, Any]], axes: Any) -> None:
    found = [abs(f[key]) for f in lit for key in ("sagittal_focus_mm", "tangential_focus_mm") if f[key] is not None]
    factor, unit = lengths(max(found, default=0.0))
    for key, name, dashes in (("sagittal_focus_mm", "sagittal", ()), ("tangential_focus_mm", "tangential", (4, 2))):
        points = [(f[key] * factor, f["angle_deg"]) for f in lit if f[key] is not None]
        if points:
            axes.plot(*zip(*points, strict=True), color="#1f5fae", linewidth=1.4, dashes=dashes, label=name)
    axes.set_title("field curvature", color=DARK)
    axes.set_xlabel(f"focus behind the film, {unit}")
    axes.legend(loc="best", fontsize=8)


def _distortion(lit: list[dict[str, Any]], axes: Any) -> None:
    is_fisheye = any(abs(field["angle_deg"]) >= _FISHEYE_DEG for field in lit)
    key = "even_height_mm" if is_fisheye else "straight_height_mm"
    # On the axis there is none.
    points = [
        (100.0 * (f["height_mm"] / f[key] - 1.0) if f[key] else 0.0, f["angle_deg"]) for f in lit if f[key] is not None
    ]
    if points:
        axes.plot(*zip(*points, strict=True), color="#c0392b", linewidth=1.4)
        widest = max(1.1 * max(abs(x) for x, _ in points), 0.1)
        axes.set_xlim(-widest, widest)
    axes.set_title("distortion from f θ" if is_fisheye else "distortion from f tan θ", color=DARK)
    axes.set_xlabel("per cent of the height")


def _colour(found: dict[str, Any], lit: list[dict[str, Any]], axes: Any) -> None:
    every = [abs(value) for field in lit for value in field["colour_mm"] if value is not None]
    factor, unit = lengths(max(every, default=0.0))
    wavelengths = found["wavelengths_nm"]
    for i, (colour, name) in enumerate(zip(line_colours(wavelengths), line_names(wavelengths), strict=True)):
        points = [(f["colour_mm"][i] * factor, f["angle_deg"]) for f in lit if f["colour_mm"][i] is not None]
        if points:
            axes.plot(*zip(*points, strict=True), color=colour, linewidth=1.4, label=name)
    axes.set_title("lateral colour", color=DARK)
    axes.set_xlabel(f"height from that at {wavelengths[found['main_wavelength']]:.4g} nm, {unit}")
    axes.legend(loc="best", fontsize=8)


def _table(found: dict[str, Any]) -> Table:
    headings = ["field °", "height mm", "from f tan θ %", "from f θ %", "sagittal focus mm", "tangential focus mm"]
    wavelengths, main = found["wavelengths_nm"], found["main_wavelength"]
    others = [i for i in range(len(wavelengths)) if i != main]
    headings += [f"{wavelengths[i]:.4g} nm from {wavelengths[main]:.4g} nm, mm" for i in others]

    def percent(field: dict[str, Any], key: str) -> float | None:
        if field[key] is None:
            return None
        return 100.0 * (field["height_mm"] / field[key] - 1.0) if field[key] else 0.0

    rows = [
        [
            field["angle_deg"],
            field["height_mm"],
            percent(field, "straight_height_mm"),
            percent(field, "even_height_mm"),
            field["sagittal_focus_mm"],
            field["tangential_focus_mm"],
            *(field["colour_mm"][i] for i in others),
        ]
        for field in found["fields"]
        if not field["is_dark"]
    ]
    return Table(headings, rows)


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--count", type=natural, default=41, metavar="N", help="of the fields; default: 41")


REPORT = LensReport(
    name="distortion",
    label="Distortion & Field Curvature",
    help="distortion, field curvature, lateral colour",
    description="Distortion, field curvature and lateral colour over the field",
    place=50,
    size_in=size_in,
    draw=draw,
    table=_table,
    title=lambda _found: "rays through the middle of the stop",
    is_over_the_field=True,
    options={"count": 41},
    add_options=_add_options,
    options_of=lambda arguments: {"count": arguments.count},
)
