# SPDX-License-Identifier: GPL-3.0-or-later
"""Options of sensors that `petzval sensor expose` and `petzval render` share."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from . import argument_types as types
from .errors import CommandError

#: The words of shipped sensors, as the engine has them.
SENSORS = ("sony-a7r2", "nikon-d700")
#: Endings of raw files.
RAW_ENDINGS = (".dng", ".png", ".exr")


def add_noise(p: argparse.ArgumentParser) -> None:
    """Adds the options that decide electrons and noise beside the light, under names that begin as in `exposure_of`."""
    p.add_argument(
        "--mosaic",
        metavar="NAME",
        help="colour filters: rggb, bggr, grbg, gbrg, x-trans or none; default: the sensor's own",
    )
    p.add_argument("--pitch", type=types.positive, metavar="UM", help="of photosites; default: the sensor's own")
    p.add_argument(
        "--temperature", type=types.number, metavar="C", help="of the sensor; default: that of its dark current"
    )
    p.add_argument(
        "--exit-pupil", type=types.positive, metavar="MM", help="from the film, for cover glass and micro-lenses"
    )
    p.add_argument("--sensor-seed", type=types.natural, default=0, metavar="N", help="which copy of the sensor it is")
    p.add_argument("--noise-frame", type=types.natural, default=0, metavar="N", help="another draw of the noise")
    p.add_argument("--noiseless", action="store_true", help="the means alone, rounded")


def exposure_of(a: argparse.Namespace) -> dict[str, Any]:
    """The engine's exposure, as far as `add_noise` has it."""
    given = {
        "pitch_um": a.pitch,
        "mosaic": a.mosaic,
        "temperature_c": a.temperature,
        "exit_pupil_mm": a.exit_pupil,
        "seed": a.sensor_seed,
        "frame": a.noise_frame,
        "noiseless": a.noiseless,
    }
    return {name: value for name, value in given.items() if value is not None}


def check_raw(output: Path) -> None:
    """Raises `CommandError` where a file's ending is of no raw format."""
    if output.suffix.lower() not in RAW_ENDINGS:
        raise CommandError(f"unknown raw format: {output}: end its name in {', '.join(RAW_ENDINGS)}")


def told(output: Path, found: dict[str, Any]) -> str:
    """The digital exposure in a line: size, ISO, gain, white and saturated part."""
    width, height = found["size"]
    white = ", ".join(f"{electrons:.0f}" for electrons in dict.fromkeys(found["white_e"]))
    line = (
        f"{output}: {width} x {height} photosites, ISO {found['iso']:.4g}, {found['gain_dn_per_e']:.4g} DN for each electron; "
        f"white is {white} electrons; {100.0 * found['saturated'] / found['numbers']:.2f} % saturated"
    )
    if found["below_zero"]:
        line += f"; {found['below_zero']} photosites would have had less than no light, and have none"
    return line
