# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval calibration info|convert|stmap`: files of camera calibrations. Reads arguments, asks the engine, prints its answer. Computes nothing."""

from __future__ import annotations

import argparse
import json
import math
import os
from pathlib import Path
from typing import Any

from . import argument_types as types
from .description import IDENTITY, INSTALLED_LENSFUN, CalibrationSettings, CameraDescription, FocusSettings, Perspective
from .errors import CommandError, complain, writing
from .scene_options import check_writable

#: The formats that are read beside lensfun databases.
KINDS = "OpenCV's or ROS's YAML or JSON, COLMAP's cameras.txt, Kalibr's camchain, Basalt's or NVIDIA's JSON, 3DEqualizer's nodes for Nuke"
_LENSFUN = "or a lensfun database, an .xml file, a folder of them, or the word lensfun for the installed one"
#: The engine's formats by the command's words.
_FORMATS = {"opencv": ("opencv-yaml", "opencv-json"), "ros": ("ros", None), "colmap": ("colmap", None)}


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `calibration` with its actions."""
    parser = subparsers.add_parser(
        "calibration", help="describe, convert or map camera calibrations", allow_abbrev=False
    )
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)

    info = actions.add_parser("info", help="cameras, parameters, field of view, bounds of validity", allow_abbrev=False)
    info.add_argument("file", metavar="FILE", help=f"{KINDS}; {_LENSFUN}")
    _add_lens(info)
    info.add_argument("--json", action="store_true", help="print one JSON object")
    info.set_defaults(run=_info)

    convert = actions.add_parser("convert", help="read a calibration of any kind, and write it", allow_abbrev=False)
    convert.add_argument("file", metavar="IN", help=KINDS)
    convert.add_argument("out", metavar="OUT", help="a .yml, .yaml, .json or .txt file")
    convert.add_argument(
        "--camera", metavar="NAME", help="of the file's cameras; default: all, where OUT can hold them"
    )
    convert.add_argument(
        "--to", choices=tuple(_FORMATS), help="default: by the ending: .yml and .json opencv, .yaml ros, .txt colmap"
    )
    convert.set_defaults(run=_convert)

    stmap = actions.add_parser("stmap", help="its distortion map for compositing", allow_abbrev=False)
    stmap.add_argument("file", metavar="FILE", help=f"{KINDS}; {_LENSFUN}")
    stmap.add_argument("-o", "--output", required=True, metavar="MAP.exr", help="the map, 32 bits")
    _add_lens(stmap)
    stmap.add_argument(
        "--direction", choices=("undistort", "distort"), default="undistort",
        help="undistort makes the camera's picture a pinhole's of the same scale in the middle, distort the other way; default: undistort",
    )  # fmt: skip
    stmap.set_defaults(run=_stmap)


def _add_lens(parser: argparse.ArgumentParser) -> None:
    """Adds the options that choose a camera or lens, and the setting of a lens of a lensfun database."""
    parser.add_argument(
        "--camera",
        metavar="NAME",
        help="of the file's cameras, where there are several; or the lens in a lensfun database",
    )
    parser.add_argument(
        "--size", type=types.pixels, metavar="WxH", help="of the picture; default: the calibration's, or 6000x4000"
    )
    group = parser.add_argument_group("a lens of a lensfun database")
    group.add_argument("--body", metavar="NAME", help="the camera body, for its sensor")
    group.add_argument(
        "--film-width", type=types.positive, default=36.0, metavar="MM", help="or the picture's width; default: 36"
    )
    group.add_argument(
        "--focal-length", type=types.positive, default=50.0, metavar="MM", help="that a zoom is set to; default: 50"
    )
    group.add_argument("--f-number", type=types.positive, default=8.0, metavar="N", help="default: 8")
    group.add_argument(
        "--distance", type=types.distance, default=math.inf, metavar="M", help="of focus; default: infinity"
    )


def _described(arguments: argparse.Namespace) -> tuple[CameraDescription, tuple[int, int]]:
    """The camera of a lens in a lensfun database, and the picture's size."""
    path = arguments.file if arguments.file == INSTALLED_LENSFUN else os.path.abspath(arguments.file)
    found = CameraDescription(
        arguments.camera or "camera",
        IDENTITY,
        model="CALIBRATED",
        perspective=Perspective(arguments.focal_length, arguments.film_width),
        focus=FocusSettings(None if math.isinf(arguments.distance) else arguments.distance),
        calibration=CalibrationSettings(path, arguments.camera, arguments.body, arguments.f_number),
    )
    width, height = arguments.size or (6000, 4000)
    return found, (width, height)


def _is_lensfun(file: str) -> bool:
    return file == INSTALLED_LENSFUN or file.lower().endswith(".xml") or os.path.isdir(file)


def run(arguments: argparse.Namespace) -> int:
    """Runs the action; returns the exit status."""
    status: int = arguments.run(arguments)
    return status


def _say(file: str, remarks: list[str]) -> None:
    for remark in remarks:
        complain(f"{file}: {remark}")


def _read(file: str) -> dict[str, Any]:
    from . import _native

    found: dict[str, Any] = json.loads(_native.calibration_json(file))
    return found


def _info(arguments: argparse.Namespace) -> int:
    if _is_lensfun(arguments.file):
        return _lensfun(arguments)
    found = _read(arguments.file)
    if arguments.camera:
        found["cameras"] = [one for one in found["cameras"] if one["name"] == arguments.camera]
        if not found["cameras"]:
            raise CommandError(
                f"{arguments.file}: there is no camera '{arguments.camera}': leave --camera out to see all"
            )
    if arguments.json:
        print(json.dumps(found))
        return 0
    _say(arguments.file, found["remarks"])
    print(
        f"{arguments.file}: {found['format']}, {len(found['cameras'])} camera{'s' if len(found['cameras']) > 1 else ''}"
    )
    for camera in found["cameras"]:
        print("\n".join(_lines(camera)))
    return 0


def _lensfun(arguments: argparse.Namespace) -> int:
    """All lenses of a database, or one at a setting."""
    from . import _native

    if not arguments.camera:
        found = _read(arguments.file)
        if arguments.json:
            print(json.dumps(found))
            return 0
        print(
            f"{arguments.file}: {found['format']}, {len(found['lenses'])} lenses, {len(found['bodies'])} camera bodies"
        )
        for lens in found["lenses"]:
            short, long = lens["focal_range_mm"]
            focal = f"{short:g}" if short == long else f"{short:g} to {long:g}"
            kinds = zip(("distortion", "vignetting", "lateral colour"), lens["measured"], strict=True)
            measured = ", ".join(kind for kind, count in kinds if count) or "nothing"
            crops = ", ".join(f"{crop:g}" for crop in sorted(set(lens["crop_factors"])))
            print(f"{lens['name']}: {focal} mm; {measured} measured{f' at crop factor {crops}' if crops else ''}")
        return 0
    described, size = _described(arguments)
    lens = json.loads(_native.photographic_lens_json(described, *size))
    if arguments.json:
        print(json.dumps(lens))
        return 0
    for remark in lens["remarks"]:
        complain(remark)
    print("\n".join(_lines(lens)))
    print(f"  marked {lens['marked_mm']:.4g} mm, on a picture {lens['film_width_mm']:.4g} mm wide")
    if lens["corner_stops"] is not None:
        print(f"  corner {lens['corner_stops']:+.2f} stops at F/{arguments.f_number:g}")
    if lens["corner_lateral_px"] is not None:
        red, blue = lens["corner_lateral_px"]
        print(f"  red {red:+.2f}, blue {blue:+.2f} pixels outside of green in the corner")
    return 0


def _lines(camera: dict[str, Any]) -> list[str]:
    width, height = camera["size_px"]
    lines = [f"{camera['name']}: {camera['model']}, {width} x {height} pixels, counted from the corner of the first"]
    lines += [f"  {name} {value:.10g}" for name, value in camera["parameters"].items()]
    fields = [camera["horizontal_field_deg"], camera["vertical_field_deg"]]
    across, up = ("none: an edge shows nothing" if field is None else f"{field:.3f} degrees" for field in fields)
    lines.append(
        f"  field of view across {across}, up {up}; at most {camera['largest_angle_deg']:.3f} degrees from the axis"
    )
    valid = camera["valid_to_deg"]
    lines.append(
        f"  valid {'everywhere' if valid is None else f'to {valid:.3f} degrees from the axis, where its distortion folds back'}"
    )
    if camera["covered"] < 1.0:
        lines.append(f"  {100.0 * (1.0 - camera['covered']):.2f} % of the picture is black: {camera['reason']}")
    return lines


def form_of(out: Path, asked: str | None) -> tuple[str, str]:
    """The format of a file, as the command has it and as the engine has it: the one asked for, or by its ending."""
    ending = out.suffix.lower()
    kind = asked or {".yml": "opencv", ".json": "opencv", ".yaml": "ros", ".txt": "colmap"}.get(ending)
    if kind is None:
        raise CommandError(
            f"cannot write {out}: its ending says no format: end it in .yml, .yaml, .json or .txt, or give --to"
        )
    plain, as_json = _FORMATS[kind]
    return kind, as_json if ending == ".json" and as_json else plain


def _convert(arguments: argparse.Namespace) -> int:
    from . import _native, atomic_files

    if _is_lensfun(arguments.file):
        raise CommandError(
            f"{arguments.file}: lensfun's models have odd powers of the radius, which none of these formats has: use stmap, or the database itself"
        )
    out = Path(arguments.out)
    kind, form = form_of(out, arguments.to)
    if out.exists() and os.path.exists(arguments.file) and os.path.samefile(out, arguments.file):
        raise CommandError(f"{out}: it would replace the file that is read: name another")
    check_writable(out)
    found = _read(arguments.file)
    text = _native.calibration_text(arguments.file, arguments.camera, form)
    _say(arguments.file, found["remarks"])
    with writing(out):
        atomic_files.write_text(out, text)
    print(f"{out}: {found['format']} as {kind}")
    return 0


def _stmap(arguments: argparse.Namespace) -> int:
    from . import _native

    out = Path(arguments.output)
    if out.suffix.lower() != ".exr":
        raise CommandError(f"cannot write {out}: its ending is not .exr: change --output")
    check_writable(out)
    what = {"undistort": "the camera's picture to a pinhole's", "distort": "a pinhole's picture to the camera's"}
    comments = (
        f"{Path(arguments.file).name}: {what[arguments.direction]}. R and G: where to take a pixel from, 0 to 1 from the lower left. "
        "B and A: 1 where that is in the picture."
    )
    undistorts = arguments.direction == "undistort"
    if _is_lensfun(arguments.file):
        described, pixels = _described(arguments)
        share = _native.write_photographic_map(described, pixels, undistorts, comments, str(out))
    else:
        size = tuple(arguments.size) if arguments.size else None
        share = _native.write_calibration_map(arguments.file, arguments.camera, size, undistorts, comments, str(out))
    print(f"{out}: {arguments.direction}, {100.0 * share:.1f} % of its pixels have a source")
    return 0
