# SPDX-License-Identifier: GPL-3.0-or-later
"""The relative illumination of the film off the axis, at one or several f-numbers."""

from __future__ import annotations

import argparse
import math
from typing import Any

from ..argument_types import natural, number
from .page import PALE, field_colour
from .report import LensReport
from .table import Table


def size_in(found: list[dict[str, Any]]) -> tuple[float, float]:
    """The size of the report."""
    return 7.0, 4.2


def draw(found: list[dict[str, Any]], figure: Any) -> None:
    """Draws into a figure, a curve a setting."""
    axes = figure.subplots()
    most = 1.0
    for i, setting in enumerate(found):
        lit = [field for field in setting["fields"] if field["relative"] is not None]
        heights = [abs(field["height_mm"]) for field in lit]
        most = max([most, *(field["relative"] for field in lit)])
        axes.plot(
            heights,
            [100.0 * f["relative"] for f in lit],
            color=field_colour(i),
            linewidth=1.5,
            label=f"F/{setting['f_number']:.3g}",
        )
        if i == 0 and heights:
            fourth = [100.0 * math.cos(math.radians(field["angle_deg"])) ** 4 for field in lit]
            if all(abs(field["angle_deg"]) < 90.0 for field in lit):
                axes.plot(heights, fourth, color=PALE, linewidth=1.0, dashes=(4, 2), label="cos⁴ of the field")
            axes.set_xlim(0.0, max(heights) or 1.0)
    axes.set_ylim(0.0, 100.0 * 1.05 * most)
    axes.set_xlabel("height in the picture, mm")
    axes.set_ylabel("light, per cent of the middle")
    # The same in stops, where there is light enough to say so.
    stops = axes.secondary_yaxis("right")
    marks = [0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0]
    stops.set_yticks([100.0 * 0.5**stop for stop in marks], [f"−{stop:g}" if stop else "0" for stop in marks])
    stops.set_ylabel("stops")
    axes.legend(loc="lower left", fontsize=8)


def _table(found: list[dict[str, Any]]) -> Table:
    headings = ["field °", "height mm", *(f"F/{setting['f_number']:.3g} %" for setting in found)]
    by_angle = [{field["angle_deg"]: field for field in setting["fields"]} for setting in found]
    rows = []
    for angle in sorted({angle for fields in by_angle for angle in fields}):
        height = next(fields[angle]["height_mm"] for fields in by_angle if angle in fields)
        relative = [fields[angle]["relative"] if angle in fields else 0.0 for fields in by_angle]
        rows.append([angle, height, *(None if part is None else 100.0 * part for part in relative)])
    return Table(headings, rows)


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--count", type=natural, default=31, metavar="N", help="of the fields; default: 31")
    parser.add_argument(
        "--f-numbers", nargs="+", type=number, default=[], metavar="N", help="a curve for each, instead of --f-number"
    )


REPORT = LensReport(
    name="illumination",
    label="Illumination",
    help="how bright the picture is off its middle",
    description="How bright the picture is off its middle",
    place=60,
    size_in=size_in,
    draw=draw,
    table=_table,
    title=lambda _found: "light on the film, of a scene as bright everywhere",
    is_over_the_field=True,
    options={"count": 31},
    add_options=_add_options,
    options_of=lambda arguments: {"count": arguments.count},
    has_f_numbers=True,
)
