# SPDX-License-Identifier: GPL-3.0-or-later
"""Tolerances: the effects of deviations in making and mounting on the picture, one by one and all together by the Monte Carlo method."""

from __future__ import annotations

import argparse
from typing import Any

from ..argument_types import natural, number
from .page import DARK, FIELDS, lengths
from .report import LensReport
from .table import Table

#: Deviations that are shown, the worst first.
_SHOWN = 14
_UNITS = {
    "radius": "%",
    "thickness": "mm",
    "index": "",
    "decenter_x": "mm",
    "decenter_y": "mm",
    "tilt_x": "°",
    "tilt_y": "°",
}
_COMPENSATORS = ("back-focus", "focus", "none")
_OPTIONS: dict[str, Any] = {
    # As shops call precision: 0.1 % of a radius are some fringes, a minute of arc is 0.0167 degrees.
    "radius_percent": 0.1,
    "thickness_mm": 0.05,
    "index": 0.0005,
    "decenter_mm": 0.03,
    "tilt_deg": 0.0167,
    "trials": 200,
    "seed": 0,
    "frequency_per_mm": 30.0,
    "rays": 21,
    "compensator": "back-focus",
    "distribution": "normal",
}


def size_in(_found: dict[str, Any]) -> tuple[float, float]:
    """The size of the report."""
    return 10.5, 5.2


def draw(found: dict[str, Any], figure: Any) -> None:
    """Draws into a figure: the cumulative part of lenses by quality, and the deviations with the largest effect."""
    chance, single = figure.subplots(1, 2)
    _by_chance(found, chance)
    _one_by_one(found, single)


def _by_chance(found: dict[str, Any], axes: Any) -> None:
    rms = sorted(one["rms_mm"] for one in found["trials"] if one is not None)
    count = len(found["trials"])
    factor, unit = lengths(max([*rms, found["nominal"]["rms_mm"]]))
    axes.plot(
        [value * factor for value in rms],
        [100.0 * (i + 1) / count for i in range(len(rms))],
        color=FIELDS[0],
        linewidth=1.5,
        label=f"{count} lenses",
    )
    axes.axvline(found["nominal"]["rms_mm"] * factor, color=DARK, linewidth=1.0, dashes=(4, 2), label="nominal")
    axes.set_xlim(0.0)
    axes.set_ylim(0.0, 100.0)
    axes.set_xlabel(f"RMS spot over the fields, {unit}")
    axes.set_ylabel("lenses at least as good, per cent")
    axes.legend(loc="lower right", fontsize=8)


def _one_by_one(found: dict[str, Any], axes: Any) -> None:
    nominal = found["nominal"]["rms_mm"]
    shown = found["sensitivities"][:_SHOWN]
    factor, unit = lengths(max((abs(value - nominal) for one in shown for value in _rms(one)), default=0.0))
    for row, one in enumerate(reversed(shown)):
        for value, colour in zip(_rms(one), (FIELDS[2], FIELDS[1]), strict=False):
            axes.plot([0.0, (value - nominal) * factor], [row, row], color=colour, linewidth=4.0)
    axes.axvline(0.0, color=DARK, linewidth=0.6)
    axes.set_yticks(list(range(len(shown))), [name_of(one) for one in reversed(shown)])
    axes.set_ylim(-0.8, max(len(shown), 1) - 0.2)
    axes.set_xlabel(f"change of the RMS spot by each alone, {unit}")
    axes.set_title("the deviations that do most", color=DARK)


def _rms(one: dict[str, Any]) -> list[float]:
    return [side["rms_mm"] for side in (one["plus"], one["minus"]) if side is not None]


def name_of(one: dict[str, Any]) -> str:
    """A deviation in words: its kind, its surfaces and its size."""
    surfaces = f"{one['first']}" if one["first"] == one["last"] else f"{one['first']}-{one['last']}"
    unit = _UNITS[one["kind"]]
    return f"{one['kind'].replace('_', ' ')} {surfaces} ±{one['size']:.4g}{f' {unit}' if unit else ''}"


def _table(found: dict[str, Any]) -> Table:
    nominal = found["nominal"]
    per_mm = found["options"]["frequency_per_mm"]
    headings = ["", "RMS spot mm", f"lowest MTF {per_mm:g}/mm", "distortion %"]
    rows: list[list[float | str | None]] = [
        ["nominal", nominal["rms_mm"], nominal["mtf"], nominal["distortion_percent"]]
    ]
    rows += [
        [f"{100 * one['part']:.0f} % of the lenses reach", one["rms_mm"], one["mtf"], _moved(one["distortion_percent"])]
        for one in found["quantiles"]
    ]
    rows.append(["one by one: change by + and -", None, None, None])
    for one in found["sensitivities"][:_SHOWN]:
        changes = [
            " / ".join(
                "dark" if side is None else f"{side[key] - nominal[key]:+.3g}" for side in (one["plus"], one["minus"])
            )
            for key in ("rms_mm", "mtf", "distortion_percent")
        ]
        rows.append([name_of(one), *changes])
    return Table(headings, rows)


def _moved(percent: float | None) -> str | None:
    return None if percent is None else f"±{percent:.3g}"


def _add_options(parser: argparse.ArgumentParser) -> None:
    def tolerance(option: str, key: str, what: str) -> None:
        parser.add_argument(
            option,
            dest=key,
            type=number,
            default=_OPTIONS[key],
            metavar="T",
            help=f"{what}; default: {_OPTIONS[key]:g}",
        )

    tolerance("--radius", "radius_percent", "of radii of curvature, per cent")
    tolerance("--thickness", "thickness_mm", "of thicknesses and gaps, mm")
    tolerance("--index", "index", "of indices")
    tolerance("--decenter", "decenter_mm", "of the places of elements across the axis, mm")
    tolerance("--tilt", "tilt_deg", "of the tilts of elements, degrees")
    tolerance("--frequency", "frequency_per_mm", "of the MTF, line pairs/mm")
    parser.add_argument("--trials", type=natural, default=_OPTIONS["trials"], metavar="N", help="lenses; default: 200")
    parser.add_argument(
        "--seed", type=natural, default=0, metavar="N", help="of the lenses drawn at random; default: 0"
    )
    parser.add_argument("--rays", type=natural, default=_OPTIONS["rays"], metavar="N", help="over the width of a beam")
    parser.add_argument(
        "--compensator", choices=_COMPENSATORS, default="back-focus",
        help="what makes up for deviations: the film's distance, the lens's own focusing, or nothing",
    )  # fmt: skip
    parser.add_argument(
        "--distribution", choices=("normal", "uniform"), default="normal",
        help="within the tolerance: normal, cut off at two standard deviations, or uniform",
    )  # fmt: skip


def _options_of(arguments: argparse.Namespace) -> dict[str, Any]:
    return {key: getattr(arguments, key) for key in _OPTIONS}


def _title(found: dict[str, Any]) -> str:
    options = found["options"]
    by = {"none": "not refocused", "back-focus": "refocused by the film", "focus": "refocused by its own focusing"}
    return f"tolerances, {options['trials']} lenses, {by[options['compensator']]}"


def _remarks(found: dict[str, Any]) -> list[str]:
    dark = sum(one is None for one in found["trials"])
    return [f"{dark} of the lenses pass no light from some field"] if dark else []


REPORT = LensReport(
    name="tolerance",
    label="Tolerances",
    help="what deviations in making and mounting do to the picture",
    description="What deviations in making and mounting do to the picture",
    place=80,
    size_in=size_in,
    draw=draw,
    table=_table,
    title=_title,
    options=_OPTIONS,
    add_options=_add_options,
    options_of=_options_of,
    remarks=_remarks,
)
