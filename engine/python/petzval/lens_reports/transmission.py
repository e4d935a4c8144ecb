# SPDX-License-Identifier: GPL-3.0-or-later
"""The transmittance of a lens for each colour, by field, and the reflectance of its coatings."""

from __future__ import annotations

import argparse
from typing import Any

from ..argument_types import number
from .page import degrees, field_colour
from .report import LensReport
from .table import Table


def size_in(found: dict[str, Any]) -> tuple[float, float]:
    """The size of the report."""
    return 9.0, 4.2


def draw(found: dict[str, Any], figure: Any) -> None:
    """Draws into a figure: on the left the transmittance, on the right the reflectance of one surface of each coating."""
    through, back = figure.subplots(1, 2)
    spectrum = found["spectrum_nm"]
    for i, field in enumerate(field for field in found["fields"] if field["parts"]):
        parts = [100.0 * part for part in field["parts"]]
        through.plot(spectrum, parts, color=field_colour(i), linewidth=1.5, label=degrees(field["angle_deg"]))
    for i, coating in enumerate(found["coatings"]):
        name = f"{coating['name']}, first before {coating['before']}"
        back.plot(spectrum, [100.0 * r for r in coating["reflected"]], color=field_colour(i), linewidth=1.5, label=name)
    through.set_ylabel("light that passes, per cent")
    back.set_ylabel("reflected at right angles, per cent")
    for axes in (through, back):
        axes.set_xlim(spectrum[0], spectrum[-1])
        axes.set_xlabel("wavelength, nm")
        axes.legend(loc="best", fontsize=8)
    through.set_ylim(0.0, 100.0)
    most = max((100.0 * max(coating["reflected"]) for coating in found["coatings"]), default=1.0)
    back.set_ylim(0.0, 1.1 * most)


#: Wavelengths of the table: of a picture's curve there are too many for a terminal.
_IN_TABLE = 9


def _table(found: dict[str, Any]) -> Table:
    spectrum = found["spectrum_nm"]
    step = max((len(spectrum) - 1) // (_IN_TABLE - 1), 1)
    fields = [field for field in found["fields"] if field["parts"]]
    headings = ["nm", *(f"{field['angle_deg']:.4g}° %" for field in fields)]
    headings += [f"{coating['name']} reflects %" for coating in found["coatings"]]
    rows = [
        [
            f"{spectrum[i]:g}",
            *(100.0 * field["parts"][i] for field in fields),
            *(100.0 * coating["reflected"][i] for coating in found["coatings"]),
        ]
        for i in range(0, len(spectrum), step)
    ]
    return Table(headings, rows)


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--spectrum", nargs=3, type=number, default=[380.0, 780.0, 5.0], metavar=("FROM", "TO", "STEP"),
        help="nanometres; default: 380 780 5",
    )  # fmt: skip


def _spectrum_nm(first: float, last: float, step: float) -> list[float]:
    return [first + step * i for i in range(int((last - first) / step + 1e-9) + 1)]


def _options_of(arguments: argparse.Namespace) -> dict[str, Any]:
    first, last, step = arguments.spectrum
    steps = (last - first) / step if step > 0.0 else 0.0
    if not 1.0 <= steps <= 1999.0:
        arguments.usage_error("--spectrum FROM TO STEP: two wavelengths and a step between them, at most 2000 in all")
    return {"spectrum_nm": _spectrum_nm(first, last, step)}


def _title(found: dict[str, Any]) -> str:
    number_of_white = found["t_number"]
    return "light that passes" + ("" if number_of_white is None else f", T/{number_of_white:.3g} for white")


def _remarks(found: dict[str, Any]) -> list[str]:
    said = []
    if found["coating_is_assumed"]:
        said.append(f"its file names no coating: {found['coatings'][0]['name']} is assumed")
    if found["unknown_absorption"]:
        said.append(f"counted as clear, for their absorption is not known: {', '.join(found['unknown_absorption'])}")
    return said


REPORT = LensReport(
    name="transmission",
    label="Transmission",
    help="what is left of each colour, and what coatings reflect",
    description="What is left of each colour, and what coatings reflect",
    place=70,
    size_in=size_in,
    draw=draw,
    table=_table,
    title=_title,
    options={"spectrum_nm": _spectrum_nm(380.0, 780.0, 5.0)},
    add_options=_add_options,
    options_of=_options_of,
    remarks=_remarks,
)
