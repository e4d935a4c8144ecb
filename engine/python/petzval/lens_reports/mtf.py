# SPDX-License-Identifier: GPL-3.0-or-later
"""Modulation transfer: over the frequency, as designers have it, and over the height in the picture, as photographers do."""

from __future__ import annotations

import argparse
from typing import Any

from ..argument_types import natural, number
from .page import PALE, degrees, field_colour
from .report import LensReport, together
from .table import Table

_DASHES = (4, 2)
#: Colours from coarse to fine lines.
_FREQUENCIES = ("#0b2e59", "#1f5fae", "#5d9bd6", "#a6c8e8")


def size_in(found: dict[str, Any]) -> tuple[float, float]:
    """The size of the report."""
    return 10.0, 4.8


def draw(found: dict[str, Any], figure: Any) -> None:
    """Draws the report into a figure."""
    left, right = figure.subplots(1, 2, sharey=True)
    _by_frequency(found, left)
    _by_height(found, right)
    left.set_ylim(0.0, 1.0)


def _by_frequency(found: dict[str, Any], axes: Any) -> None:
    frequencies = found["frequencies_per_mm"]
    lit = [(i, field) for i, field in enumerate(found["fields"]) if not field["is_dark"]]
    if lit:
        limit = lit[0][1]["sagittal"]["limit"]
        axes.plot(
            frequencies, limit, color=PALE, linewidth=1.0, label=f"diffraction alone, {degrees(lit[0][1]['angle_deg'])}"
        )
    for i, field in lit:
        name = degrees(field["angle_deg"])
        axes.plot(
            frequencies, field["sagittal"]["contrast"], color=field_colour(i), linewidth=1.4, label=f"{name} sagittal"
        )
        if field["angle_deg"] != 0.0:
            axes.plot(
                frequencies, field["tangential"]["contrast"], color=field_colour(i), linewidth=1.4, dashes=_DASHES,
                label=f"{name} tangential",
            )  # fmt: skip
    axes.set_xlim(0.0, frequencies[-1])
    axes.set_xlabel("line pairs per mm of film")
    axes.set_ylabel("contrast")
    _legend(axes)


def _by_height(found: dict[str, Any], axes: Any) -> None:
    lit = [field for field in found["heights"] if not field["is_dark"]]
    heights = [abs(field["height_mm"]) for field in lit]
    for i, frequency in enumerate(found["height_frequencies_per_mm"][1:], start=1):
        colour, name = _FREQUENCIES[i - 1], f"{frequency:.4g} per mm"
        axes.plot(heights, [f["sagittal"]["contrast"][i] for f in lit], color=colour, linewidth=1.4, label=name)
        axes.plot(heights, [f["tangential"]["contrast"][i] for f in lit], color=colour, linewidth=1.4, dashes=_DASHES)
    if heights and max(heights) > 0.0:
        axes.set_xlim(0.0, max(heights))
    axes.set_xlabel("height in the picture, mm; full: sagittal, dashed: tangential")
    _legend(axes)


def _legend(axes: Any) -> None:
    # Below: curves of a good lens fill the top, those of a poor one the bottom.
    axes.legend(
        loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=4, fontsize=8, columnspacing=1.2, handlelength=1.8
    )


def _table(found: dict[str, Any]) -> Table:
    """Contrast at the frequencies that the picture has over the height."""
    frequencies = found["height_frequencies_per_mm"]
    headings = ["height mm"]
    headings += [f"{kind} {one:.4g}/mm" for one in frequencies[1:] for kind in ("sagittal", "tangential")]
    rows = []
    for field in found["heights"]:
        if field["is_dark"]:
            continue
        contrasts = [
            field[kind]["contrast"][i] for i in range(1, len(frequencies)) for kind in ("sagittal", "tangential")
        ]
        rows.append([abs(field["height_mm"]), *(f"{contrast:.3f}" for contrast in contrasts)])
    return Table(headings, rows)


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--frequency", type=number, default=100.0, metavar="N", help="the highest, line pairs/mm; default: 100"
    )
    parser.add_argument("--steps", type=natural, default=40, metavar="N", help="of the frequency; default: 40")
    parser.add_argument("--heights", type=natural, default=13, metavar="N", help="in the picture; default: 13")
    parser.add_argument(
        "--height-frequency", type=number, default=10.0, metavar="N",
        help="over the height are 1, 2, 3 and 4 times so many line pairs/mm; default: 10",
    )  # fmt: skip


REPORT = LensReport(
    name="mtf",
    label="MTF",
    help="how much contrast is left of fine lines",
    description="How much contrast is left of fine lines",
    place=30,
    size_in=size_in,
    draw=draw,
    table=_table,
    title=lambda found: f"modulation transfer with diffraction, {together(found)}",
    options={"highest_per_mm": 100.0, "steps": 40, "heights": 13, "height_step_per_mm": 10.0},
    add_options=_add_options,
    options_of=lambda arguments: {
        "highest_per_mm": arguments.frequency,
        "steps": arguments.steps,
        "heights": arguments.heights,
        "height_step_per_mm": arguments.height_frequency,
    },
)
