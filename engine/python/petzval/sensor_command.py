# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval sensor info|expose|develop`: pictures on a sensor that counts photons. Reads arguments, asks the engine, prints its answer. Computes nothing."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from . import argument_types as types
from . import processes
from .errors import CommandError
from .scene_options import check_apart, check_writable
from .sensor_options import RAW_ENDINGS, SENSORS, add_noise, check_raw, exposure_of, told

_SENSOR = f"a sensor's file, or a shipped sensor: {', '.join(SENSORS)}"


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `sensor` with its actions."""
    parser = subparsers.add_parser("sensor", help="photograph rendered pictures with a sensor", allow_abbrev=False)
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)

    info = actions.add_parser("info", help="gain, noise, saturation, colours of a sensor", allow_abbrev=False)
    info.add_argument("sensor", metavar="SENSOR", help=_SENSOR)
    info.add_argument("--iso", type=types.positive, metavar="N", help="film speed; default: the sensor's own")
    info.add_argument("--json", action="store_true", help="print one JSON object")
    info.set_defaults(run=_info)

    expose = actions.add_parser(
        "expose",
        help="a linear picture into a raw file",
        description="Counts the photons of a linear picture on a sensor, one pixel for each photosite. Without --picture-iso, --lux-seconds, --nits "
        "or --photons the picture's value 1 is where a film of --iso saturates, 78/ISO lux seconds, as in pictures that are exposed physically.",
        allow_abbrev=False,
    )
    expose.add_argument("picture", metavar="PICTURE.exr", help="scene-linear R, G and B, Rec.709")
    expose.add_argument("--sensor", required=True, metavar="SENSOR", help=_SENSOR)
    expose.add_argument("-o", "--output", required=True, metavar=f"OUT{'|'.join(RAW_ENDINGS)}")
    expose.add_argument("--iso", type=types.positive, metavar="N", help="film speed; default: the sensor's own")
    expose.add_argument("--shutter", type=types.number, default=0.0, metavar="S", help="seconds; default: 0")
    light = expose.add_mutually_exclusive_group()
    light.add_argument(
        "--picture-iso", type=types.positive, metavar="N", help="of the film by which the picture was exposed"
    )
    light.add_argument("--lux-seconds", type=types.number, metavar="H", help="luminous exposure of the picture's white")
    light.add_argument(
        "--nits", type=types.number, metavar="L", help="luminance of the picture's white, with --f-number and --shutter"
    )
    light.add_argument(
        "--photons", type=types.number, metavar="N", help="for each photosite in the picture's white, of --wavelength"
    )
    expose.add_argument("--wavelength", type=types.positive, metavar="NM", help="of --photons")
    expose.add_argument("--f-number", type=types.positive, metavar="N", help="of --nits, and for the file")
    add_noise(expose)
    expose.add_argument("--json", action="store_true", help="print one JSON object")
    expose.set_defaults(run=_expose)

    develop = actions.add_parser("develop", help="a preview of a raw file, by rawpy", allow_abbrev=False)
    develop.add_argument("raw", metavar="RAW.dng")
    develop.add_argument("-o", "--output", required=True, metavar="OUT.png", help="16 bits, sRGB")
    develop.add_argument("--stops", type=types.number, default=0.0, metavar="EV", help="brighter by; default: 0")
    develop.set_defaults(run=_develop)


def run(arguments: argparse.Namespace) -> int:
    """Runs the action; returns the exit status."""
    status: int = arguments.run(arguments)
    return status


def _info(arguments: argparse.Namespace) -> int:
    from . import _native

    found = json.loads(_native.sensor_json(arguments.sensor, arguments.iso))
    print(json.dumps(found) if arguments.json else "\n".join(_lines(found)))
    return 0


def _lines(found: dict[str, Any]) -> list[str]:
    how = "so that the base speed saturates" if found["is_efficiency_found"] else "as its file has it"
    lines = [
        f"{found['name']}: {found['pixel_pitch_um']:g} um, mosaic {found['mosaic']}, {found['bits']} bits, black {found['black_level_dn']:g} DN",
        f"  quantum efficiency {100.0 * found['peak_quantum_efficiency']:.1f} % at most, with filters, {how}",
        f"  base speed ISO {found['base_iso']:.4g}; by saturation in D65 ISO {found['saturation_iso']:.4g}",
        f"at ISO {found['iso']:.4g}:",
        f"  gain {found['gain_dn_per_e']:.4g} DN for each electron, saturation at {found['saturation_e']:.0f} electrons",
        f"  read noise {found['read_noise_e']:.2f} electrons, dynamic range {found['dynamic_range_stops']:.1f} stops",
        f"  dark current {found['dark_current_e_per_s']:g} electrons a second, DSNU {found['dsnu_e']:g} electrons, PRNU {found['prnu_percent']:g} %",
        "  electrons for white of 1 lux second: "
        + ", ".join(f"{electrons:.0f}" for electrons in found["white_e_per_lx_s"]),
        f"  noise of white is above 1 % of it below {found['visible_below_lx_s']:.3g} lux seconds",
    ]
    if (matrix := found["channels_from_xyz"]) is not None:
        rows = ("  ".join(f"{value:8.4f}" for value in row) for row in matrix)
        lines += ["channels from XYZ, D65:", *(f"  {row}" for row in rows)]
    lines.append(f"curves: {found['source']}{', ' + found['licence'] if found['licence'] else ''}")
    if found["pixel_source"]:
        lines.append(f"numbers: {found['pixel_source']}")
    if found["assumed"]:
        lines.append(f"assumed, by no source: {', '.join(found['assumed'])}")
    return lines


def _expose(arguments: argparse.Namespace) -> int:
    from . import _native

    output, picture = Path(arguments.output), Path(arguments.picture)
    check_raw(output)
    if not picture.is_file():
        raise CommandError(f"no such picture: {picture}: name an OpenEXR file")
    check_apart({"--output": output}, {"the picture": picture})
    exposure = exposure_of(arguments) | {
        "iso": arguments.iso,
        "shutter_s": arguments.shutter,
        "picture_iso": arguments.picture_iso,
        "lux_seconds": arguments.lux_seconds,
        "nits": arguments.nits,
        "f_number": arguments.f_number,
        "photons": arguments.photons,
        "wavelength_nm": arguments.wavelength,
    }
    _native.check_exposure(arguments.sensor, exposure)
    check_writable(output)
    found = json.loads(_native.expose_sensor_json(arguments.sensor, exposure, str(picture), str(output)))
    print(json.dumps(found) if arguments.json else told(output, found))
    return 0


def _develop(arguments: argparse.Namespace) -> int:
    from . import _native

    raw, output = Path(arguments.raw), Path(arguments.output)
    if output.suffix.lower() != ".png":
        raise CommandError(f"unknown picture format: {output}: end its name in .png")
    if not raw.is_file():
        raise CommandError(f"no such raw file: {raw}: name a .dng")
    check_apart({"--output": output}, {"the raw file": raw})
    check_writable(output)
    try:
        import rawpy
    except ImportError as error:
        raise CommandError(
            f"raw files are developed by rawpy, which cannot be loaded: {error}: pip install rawpy"
        ) from None
    try:
        # LibRaw says on stderr itself what it finds.
        processes.keep_own_voice()
        with rawpy.imread(str(raw)) as opened:
            pixels = opened.postprocess(
                use_camera_wb=True, no_auto_bright=True, adjust_maximum_thr=0.0, bright=2.0**arguments.stops, output_bps=16,
                gamma=(2.4, 12.92), output_color=rawpy.ColorSpace.sRGB,
            )  # fmt: skip
    except rawpy.LibRawError as error:
        reason = error.args[0].decode(errors="replace") if error.args and isinstance(error.args[0], bytes) else error
        raise CommandError(f"{raw}: rawpy cannot read it: {reason}: is it whole, is it a raw file") from None
    _native.write_png(pixels, str(output))
    print(f"{output}: {pixels.shape[1]} x {pixels.shape[0]} pixels")
    return 0
