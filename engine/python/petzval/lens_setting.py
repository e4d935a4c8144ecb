# SPDX-License-Identifier: GPL-3.0-or-later
"""How a lens is set and looked at, as the commands of `petzval lens` take it. Read by the engine by attribute."""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class LensSetting:
    """See `_native.pyi`."""

    scale: float | None = None
    focal_length_mm: float | None = None
    f_number: float | None = None
    pupil_diameter_mm: float | None = None
    blades: int = 0
    blade_curvature: float = 0.0
    blade_rotation_rad: float = 0.0
    aperture_mask: Any = None


@dataclass(frozen=True)
class LensLook:
    """See `_native.pyi`."""

    fields_deg: tuple[float, ...] = ()
    wavelengths_nm: tuple[float, ...] = ()
    azimuth_deg: float = 90.0
    focus_distance_mm: float | None = None
    best_focus: bool = False
    defocus_mm: float = 0.0


def number(text: str) -> float:
    """A finite one."""
    value = float(text)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"not a finite number: {text}")
    return value


def distance(text: str) -> float:
    """May be infinite."""
    value = float(text)
    if math.isnan(value):
        raise argparse.ArgumentTypeError(f"not a number: {text}")
    return value


# argparse names the type in its message: "invalid number value: 'x'".
distance.__name__ = "distance"


def add_look(parser: argparse.ArgumentParser, fields: str) -> None:
    """The options of `LensLook`; `fields` says what is shown without --fields."""
    parser.add_argument(
        "--fields", nargs="+", type=number, default=[], metavar="DEG", help=f"angles to the axis; default: {fields}"
    )
    parser.add_argument(
        "--wavelengths", nargs="+", type=number, default=[], metavar="NM",
        help="nanometres; the one nearest 587.6 is the main one; default: 486.1 587.6 656.3",
    )  # fmt: skip
    parser.add_argument(
        "--azimuth", type=number, default=90.0, metavar="DEG",
        help="direction of the fields, 0 to the right, 90 up; default: 90",
    )  # fmt: skip
    parser.add_argument(
        "--focus-distance", type=distance, metavar="MM|inf", help="from the entrance pupil to what is sharp"
    )
    parser.add_argument(
        "--best-focus", action="store_true", help="the film where the axis is sharpest, not where paraxial rays meet"
    )
    parser.add_argument("--film-shift", type=number, default=0.0, metavar="MM", help="the film so far behind that")


def look_of(arguments: argparse.Namespace) -> LensLook:
    """What `add_look` asked for."""
    return LensLook(
        fields_deg=tuple(arguments.fields),
        wavelengths_nm=tuple(arguments.wavelengths),
        azimuth_deg=arguments.azimuth,
        focus_distance_mm=arguments.focus_distance,
        best_focus=arguments.best_focus,
        defocus_mm=arguments.film_shift,
    )
