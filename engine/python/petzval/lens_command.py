# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval lens check|info|trace`: reads arguments, asks the engine, prints its answer. Computes nothing."""

from __future__ import annotations

import argparse
import json
import math
import sys
from pathlib import Path
from typing import Any

from .errors import CommandError, complain
from .places import find_lens


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    """Adds `lens` with its three actions."""
    lens = subparsers.add_parser("lens", help="check, describe or trace a lens", allow_abbrev=False)
    actions = lens.add_subparsers(dest="action", metavar="ACTION", required=True)

    check = actions.add_parser("check", help="read lens files and say what is wrong with them", allow_abbrev=False)
    check.add_argument("lenses", nargs="+", metavar="FILE", help="a lens file, or the name of a shipped lens")
    check.set_defaults(run=_check)

    info = actions.add_parser("info", help="focal length, planes, pupils, aberrations", allow_abbrev=False)
    info.add_argument("lens", metavar="FILE", help="a lens file, or the name of a shipped lens")
    info.add_argument("--wavelength", type=_number, metavar="NM", help="nanometres; default: the d line")
    info.add_argument("--focal-length", type=_number, metavar="MM", help="scale the lens to this focal length")
    info.add_argument("--f-number", type=_number, metavar="N", help="stop the diaphragm down to this f-number")
    info.add_argument(
        "--focus-distance", type=_distance, metavar="MM|inf", help="from the entrance pupil to what is sharp"
    )
    info.add_argument("--json", action="store_true", help="print one JSON object")
    info.set_defaults(run=_info)

    trace = actions.add_parser("trace", help="trace given rays through the lens", allow_abbrev=False)
    trace.add_argument("lens", metavar="FILE", help="a lens file, or the name of a shipped lens")
    trace.add_argument("--rays", required=True, metavar="RAYS.json|-", help="the rays; - reads them from stdin")
    trace.add_argument("--precision", choices=("f64", "f32"), default="f64", help="default: f64")
    trace.add_argument("--json", action="store_true", help="print one JSON object")
    trace.set_defaults(run=_trace)


def run(arguments: argparse.Namespace) -> int:
    """Runs the action; returns the exit status."""
    return arguments.run(arguments)


def _number(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"not a finite number: {text}")
    return value


def _distance(text: str) -> float:
    value = float(text)
    if math.isnan(value):
        raise argparse.ArgumentTypeError(f"not a number: {text}")
    return value


# argparse names the type in its message: "invalid number value: 'x'".
_number.__name__ = "number"
_distance.__name__ = "distance"


def _load(name_or_path: str) -> Any:
    from . import _native

    return _native.Lens(str(find_lens(name_or_path)))


def _check(arguments: argparse.Namespace) -> int:
    from . import _native

    failures = 0
    for name in arguments.lenses:
        try:
            lens = _load(name)
        except (_native.PetzvalError, CommandError) as error:
            failures += 1
            complain(str(error))
        else:
            print(f"ok: {lens.name}, {lens.surface_count} surfaces")
    return 1 if failures else 0


def _info(arguments: argparse.Namespace) -> int:
    given = {
        "wavelength_nm": arguments.wavelength,
        "focal_length_mm": arguments.focal_length,
        "f_number": arguments.f_number,
        "focus_distance_mm": arguments.focus_distance,
    }
    options = {name: value for name, value in given.items() if value is not None}
    answer = _load(arguments.lens).info_json(**options)
    print(answer if arguments.json else _table(json.loads(answer)))
    return 0


def _trace(arguments: argparse.Namespace) -> int:
    text = _read(arguments.rays)
    try:
        rays = json.loads(text)
    except json.JSONDecodeError as error:
        raise CommandError(
            f"not JSON: {arguments.rays}, line {error.lineno}, column {error.colno}: {error.msg}"
        ) from None
    if not isinstance(rays, dict) or not isinstance(rays.get("rays"), list):
        raise CommandError(f'no list of rays: {arguments.rays}: give {{"rays": [{{"origin": ..., ...}}]}}')
    side = rays.get("from", "scene")
    if side not in ("scene", "film"):
        raise CommandError(f'unknown "from": {arguments.rays}: {json.dumps(side)}: give "scene" or "film"')
    answer = _load(arguments.lens).trace_json(text, from_film=side == "film", precision=arguments.precision)
    print(answer if arguments.json else _ray_lines(json.loads(answer)["rays"]))
    return 0


def _read(path: str) -> str:
    try:
        data = sys.stdin.buffer.read() if path == "-" else Path(path).read_bytes()
        return data.decode("utf-8")
    except OSError as error:
        raise CommandError(f"cannot read: {path}: {error.strerror}: name a file of rays, or - for stdin") from None
    except UnicodeDecodeError:
        raise CommandError(f"not text: {path}: give JSON in UTF-8") from None


#: Key of the engine's answer, its words, its unit. Keys of nested objects are joined by a point.
_ROWS = (
    ("name", "lens", ""),
    ("surfaces", "surfaces", ""),
    ("wavelength_nm", "wavelength", "nm"),
    ("efl_mm", "focal length", "mm"),
    ("f_number", "f-number", ""),
    ("stop_diameter_mm", "diaphragm's diameter", "mm"),
    ("bfd_mm", "back focal distance, from the last vertex", "mm"),
    ("ffd_mm", "front focal distance, from the first vertex", "mm"),
    ("object_focal_plane_mm", "object focal plane, z", "mm"),
    ("object_principal_plane_mm", "object principal plane, z", "mm"),
    ("image_principal_plane_mm", "image principal plane, z", "mm"),
    ("image_focal_plane_mm", "image focal plane, z", "mm"),
    ("entrance_pupil.z_mm", "entrance pupil, z", "mm"),
    ("entrance_pupil.diameter_mm", "entrance pupil, diameter", "mm"),
    ("exit_pupil.z_mm", "exit pupil, z", "mm"),
    ("exit_pupil.diameter_mm", "exit pupil, diameter", "mm"),
    ("film_z_mm", "film, z", "mm"),
    ("total_track_mm", "length, first vertex to film", "mm"),
    ("petzval_radius_mm", "Petzval radius", "mm"),
)
_SEIDEL = ("spherical aberration, S I", "coma, S II", "astigmatism, S III", "field curvature, S IV", "distortion, S V")


def _value_text(value: Any) -> str:
    if value is None:
        return "infinite"
    return f"{value:.6f}" if isinstance(value, float) else str(value)


def _table(info: dict[str, Any]) -> str:
    """Words, value and unit of each row, aligned at the decimal point."""
    rows = []
    for key, words, unit in _ROWS:
        value: Any = info
        for part in key.split("."):
            value = value[part]
        rows.append((words, _value_text(value), unit))
    rows += [(words, _value_text(value), "mm") for words, value in zip(_SEIDEL, info["seidel"], strict=True)]
    words_width = max(len(words) for words, _, _ in rows)
    before_point = max(len(text.split(".")[0]) for _, text, unit in rows if unit)
    lines = []
    for words, text, unit in rows:
        whole, point, rest = text.partition(".")
        aligned = f"{whole:>{before_point}}{point}{rest}" if unit or point else text
        lines.append(f"{words:<{words_width}}  {aligned} {unit}".rstrip())
    return "\n".join(lines)


def _vector_text(vector: list[float]) -> str:
    return " ".join(f"{value:.9g}" for value in vector)


def _ray_lines(rays: list[dict[str, Any]]) -> str:
    """One line a ray: what became of it, and where it is then."""
    lines = []
    for number, ray in enumerate(rays):
        if ray["status"] == "ok":
            text = f"ok, from ({_vector_text(ray['origin'])}) mm along ({_vector_text(ray['direction'])})"
        else:
            text = f"{ray['status']} at surface {ray['surface']}"
        lines.append(f"{number}: {text}")
    return "\n".join(lines)
