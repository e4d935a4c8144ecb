# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval lens stmap|osl`: a lens for other programs. Reads arguments, asks the engine, writes its answer. Computes nothing."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from . import argument_types as types
from .distortion_maps import COLOURS_NM, note
from .errors import CommandError, writing
from .lens_camera import add_camera, camera_of
from .lens_loading import load, say
from .scene_options import check_writable

_D_LINE_NM = 587.5618


def add_parsers(actions: Any, kinds: str) -> None:
    """Adds both actions to those of `petzval lens`."""
    stmap = actions.add_parser("stmap", help="a distortion map for compositing", allow_abbrev=False)
    add_camera(stmap, kinds)
    stmap.add_argument("-o", "--output", required=True, metavar="MAP.exr", help="the map, 32 bits")
    stmap.add_argument(
        "--direction", choices=("undistort", "distort"), default="undistort",
        help="undistort makes the lens's picture a pinhole's of the same framing, distort the other way; default: undistort",
    )  # fmt: skip
    stmap.add_argument(
        "--wavelength", type=types.positive, metavar="NM", help="nanometres, of the rays; default: the d line"
    )
    stmap.add_argument(
        "--colours", action="store_true", help="and a layer for red, green and blue each: lateral colour"
    )
    stmap.set_defaults(run=_stmap)

    osl = actions.add_parser("osl", help="the lens as a camera for Cycles, Blender 4.5 or later", allow_abbrev=False)
    add_camera(osl, kinds)
    osl.add_argument("-o", "--output", required=True, metavar="LENS.osl", help="the script")
    osl.add_argument(
        "--spectrum", type=types.wavelengths, default="rgb", metavar="rgb|NM",
        help="three wavelengths, one by one, or one; default: rgb",
    )  # fmt: skip
    osl.set_defaults(run=_osl)


def _output(arguments: argparse.Namespace, ending: str) -> Path:
    out = Path(arguments.output)
    if out.suffix.lower() != ending:
        raise CommandError(f"cannot write {out}: its ending is not {ending}: change --output")
    check_writable(out)
    return out


def _stmap(arguments: argparse.Namespace) -> int:
    from . import _native

    out = _output(arguments, ".exr")
    lens = load(arguments.lens)
    camera = camera_of(arguments)
    main_nm = arguments.wavelength or _D_LINE_NM
    maps = [("", main_nm), *(COLOURS_NM if arguments.colours else ())]
    comments = note(lens.name, arguments.direction, main_nm)
    width, height = arguments.pixels
    shares = _native.write_distortion_map(camera, width, height, maps, arguments.direction.upper(), comments, str(out))
    say([*lens.remarks, *lens.range_notes([nm for _, nm in maps])])
    print(f"{out}: {lens.name}, {arguments.direction}, {100.0 * shares[0]:.1f} % of its pixels have a source")
    return 0


def _osl(arguments: argparse.Namespace) -> int:
    from . import _native, atomic_files

    out = _output(arguments, ".osl")
    lens = load(arguments.lens)
    is_one = not isinstance(arguments.spectrum, str)
    camera = camera_of(arguments, wavelength_nm=arguments.spectrum if is_one else None, spectrum="THREE")
    text = _native.osl_camera(camera, *arguments.pixels)
    with writing(out):
        atomic_files.write_text(out, text)
    say(lens.remarks)
    print(f"{out}: {lens.name}, {lens.surface_count} surfaces")
    return 0
