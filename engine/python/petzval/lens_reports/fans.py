# SPDX-License-Identifier: GPL-3.0-or-later
"""Fans: a row a field, the tangential on the left, the sagittal on the right."""

from __future__ import annotations

import argparse
from dataclasses import replace
from functools import partial
from typing import Any

from ..argument_types import natural
from .page import DARK, degrees, lengths, line_colours, line_names
from .report import LensReport
from .table import Table, per_line


def size_in(found: dict[str, Any]) -> tuple[float, float]:
    """The size of the report."""
    return 8.5, 1.9 * len(found["fields"]) + 0.7


def draw(found: dict[str, Any], figure: Any, key: str = "error_mm") -> None:
    """Draws into a figure: `error_mm`, transverse aberrations, or `path_waves`, optical path differences; all to one scale."""
    fields = found["fields"]
    lit = [line for f in fields if not f["is_dark"] for kind in ("tangential", "sagittal") for line in f[kind]]
    largest = max((abs(value) for line in lit for value in line[key]), default=0.0)
    factor, unit = lengths(largest) if key == "error_mm" else (1.0, "waves")
    axes = figure.subplots(len(fields), 2, squeeze=False, sharex=True, sharey=True)
    colours, names = line_colours(found["wavelengths_nm"]), line_names(found["wavelengths_nm"])
    for row, field in enumerate(fields):
        for column, kind in enumerate(("tangential", "sagittal")):
            at = axes[row][column]
            at.axhline(0.0, color=DARK, linewidth=0.6)
            at.axvline(0.0, color=DARK, linewidth=0.6)
            if row == 0:
                at.set_title(kind, color=DARK)
            if column == 0:
                at.set_ylabel(f"{degrees(field['angle_deg'])}\n{unit}")
            if row == len(fields) - 1:
                at.set_xlabel("place in the stop, of its radius")
            if field["is_dark"]:
                at.text(0.5, 0.6, "dark", transform=at.transAxes, ha="center", color=DARK)
                continue
            for line, colour in zip(field[kind], colours, strict=True):
                at.plot(line["pupil"], [v * factor for v in line[key]], color=colour, linewidth=1.2)
    axes[0][0].set_xlim(-1.05, 1.05)
    limit = 1.08 * largest * factor or 1.0
    axes[0][0].set_ylim(-limit, limit)
    handles = [axes[0][0].plot([], [], color=c, label=n)[0] for c, n in zip(colours, names, strict=True)]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), fontsize=8)


def _table(found: dict[str, Any], key: str = "error_mm") -> Table:
    """The largest of each fan."""
    unit = "mm" if key == "error_mm" else "waves"
    headings = ["field °", "fan", *per_line(found["wavelengths_nm"], f"largest, {unit}, at")]
    rows = []
    for field in found["fields"]:
        for kind in ("tangential", "sagittal"):
            if field["is_dark"]:
                rows.append([field["angle_deg"], kind, *["dark"] * len(found["wavelengths_nm"])])
                continue
            largest = [max(line[key], key=abs) if line[key] else None for line in field[kind]]
            rows.append([field["angle_deg"], kind, *largest])
    return Table(headings, rows)


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--rays", type=natural, default=201, metavar="N", help="of a fan; default: 201")
    parser.add_argument("--path", action="store_true", help="how long they take instead, in wavelengths")


def _drawn_as(arguments: argparse.Namespace, report: LensReport) -> LensReport:
    if not arguments.path:
        return report
    paths = "optical path beyond the middle ray's"
    return replace(
        report,
        draw=partial(draw, key="path_waves"),
        table=partial(_table, key="path_waves"),
        title=lambda _found: paths,
    )


REPORT = LensReport(
    name="fans",
    label="Ray Fans",
    help="how far rays across the pupil land from the middle one",
    description="How far rays across the pupil land from the middle one",
    place=20,
    size_in=size_in,
    draw=draw,
    table=_table,
    title=lambda _found: "ray fans: where rays land, from the middle one",
    options={"rays": 201},
    add_options=_add_options,
    options_of=lambda arguments: {"rays": arguments.rays},
    drawn_as=_drawn_as,
)
