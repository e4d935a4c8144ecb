# SPDX-License-Identifier: GPL-3.0-or-later
"""The options of `petzval lens` by which a lens is set, focused and reported on."""

from __future__ import annotations

import argparse
import math
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from . import processes
from .argument_types import number
from .description import MOST_BLADES, LensReportSettings, LensSettings, focal_length
from .errors import CommandError


def _distance(text: str) -> float:
    """May be infinite, or behind."""
    value = float(text)
    if math.isnan(value):
        raise argparse.ArgumentTypeError(f"not a number: {text}")
    return value


def _count(text: str) -> int:
    value = int(text)
    if value != 0 and not 3 <= value <= MOST_BLADES:
        raise argparse.ArgumentTypeError(f"a diaphragm has 3 to {MOST_BLADES} blades, or 0 for a round one: {text}")
    return value


# argparse names the type in its message: "invalid number value: 'x'".
_count.__name__, _distance.__name__ = "number", "distance"


def add_setting(parser: argparse.ArgumentParser) -> None:
    """The options of `LensSettings`."""
    parser.add_argument("--focal-length", type=number, metavar="MM", help="scale the lens to this focal length")
    opening = parser.add_mutually_exclusive_group()
    opening.add_argument("--f-number", type=number, metavar="N", help="stop the diaphragm down to this f-number")
    opening.add_argument(
        "--pupil-diameter", type=number, metavar="MM", help="or to this diameter of the entrance pupil, as of an eye's"
    )
    parser.add_argument(
        "--blades", type=_count, metavar="N", help=f"blades of the diaphragm, 3 to {MOST_BLADES}; 0 is round"
    )
    parser.add_argument("--blade-curvature", type=number, metavar="C", help="of the blades' edges: 0 straight, 1 round")
    parser.add_argument("--blade-rotation", type=number, metavar="DEG", help="turn of the diaphragm about the axis")
    parser.add_argument("--aperture-mask", metavar="FILE", help="a square picture of the opening, instead of blades")
    parser.add_argument(
        "--coating", metavar="NAME", help="wherever glass meets air: none, MgF2, double, triple, ..., or layer by layer"
    )
    parser.set_defaults(usage_error=parser.error)


def setting_of(arguments: argparse.Namespace) -> LensSettings:
    """The settings that the options of `add_setting` ask for. An option by the name of a setting is that setting, if it is given."""
    if arguments.aperture_mask and arguments.blades:
        arguments.usage_error("--aperture-mask stands instead of --blades: leave out the one or the other")
    own = vars(arguments)
    given: dict[str, Any] = {one.name: own[one.name] for one in fields(LensSettings) if own.get(one.name) is not None}
    given |= {
        "focal_length": focal_length(arguments.focal_length),
        "pupil_diameter_mm": arguments.pupil_diameter,
        "blade_rotation_rad": math.radians(arguments.blade_rotation or 0.0),
        "aperture_mask": _mask(arguments.aperture_mask) if arguments.aperture_mask else None,
    }
    return LensSettings(**given)


def settings_at(arguments: argparse.Namespace, f_numbers: list[float]) -> list[LensSettings]:
    """The settings that the options of `add_setting` ask for, at each of these f-numbers; at the opening that they ask for, if there are none."""
    for option, value in (("--f-number", arguments.f_number), ("--pupil-diameter", arguments.pupil_diameter)):
        if f_numbers and value is not None:
            arguments.usage_error(f"--f-numbers stands instead of {option}: leave out the one or the other")
    setting = setting_of(arguments)
    return [replace(setting, f_number=one) for one in f_numbers] or [setting]


def _mask(path: str) -> Any:
    """The picture of an opening, read by Blender as `petzval render` reads it."""
    if not Path(path).is_file():
        raise CommandError(f"no such picture: {path}: change --aperture-mask")
    processes.keep_own_voice()
    try:
        import bpy  # noqa: F401
    except ImportError as error:
        raise CommandError(f"no Blender in this Python to read {path}: {error}: pip install bpy") from None
    from .places import load_addon

    export = load_addon().export
    try:
        return export.aperture_mask.of_image(export.aperture_mask.load(str(Path(path).absolute())))
    except (RuntimeError, export.errors.ExportError) as error:
        raise CommandError(f"cannot read {path}: {' '.join(str(error).split())}: give a square picture") from None


def add_focus(parser: argparse.ArgumentParser) -> None:
    """The option of a lens's focus distance."""
    parser.add_argument(
        "--focus-distance", type=_distance, metavar="MM|inf", help="from the entrance pupil to what is sharp"
    )


def add_look(parser: argparse.ArgumentParser, fields: str) -> None:
    """The options of `LensReportSettings`; `fields` names the fields without --fields."""
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
    add_focus(parser)
    parser.add_argument(
        "--best-focus", action="store_true", help="the film where the axis is sharpest, not where paraxial rays meet"
    )
    parser.add_argument("--film-shift", type=number, default=0.0, metavar="MM", help="the film so far behind that")


def look_of(arguments: argparse.Namespace) -> LensReportSettings:
    """The settings that the options of `add_look` ask for."""
    return LensReportSettings(
        fields_deg=tuple(arguments.fields),
        wavelengths_nm=tuple(arguments.wavelengths),
        azimuth_deg=arguments.azimuth,
        focus_distance_mm=arguments.focus_distance,
        best_focus=arguments.best_focus,
        defocus_mm=arguments.film_shift,
    )
