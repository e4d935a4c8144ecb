# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval lens check|convert|draw|info|list|trace`: reads arguments, asks the engine, prints its answer. Computes nothing."""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from . import lens_list, lens_report_command
from .errors import CommandError, complain
from .places import find_lens
from .questions import read_list, vector_text

#: What is read, by ending; tables of the Optical Bench are known by their sections.
KINDS = ".lens, .zmx, .seq, .len, .dat or .txt (a table of the Optical Bench)"


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    """Adds `lens` with its actions."""
    lens = subparsers.add_parser("lens", help="check, convert, describe or trace a lens", allow_abbrev=False)
    actions = lens.add_subparsers(dest="action", metavar="ACTION", required=True)

    check = actions.add_parser("check", help="read lens files and say what is wrong with them", allow_abbrev=False)
    check.add_argument(
        "lenses", nargs="+", metavar="FILE", help=f"a lens file ({KINDS}), or the name of a shipped lens"
    )
    check.set_defaults(run=_check)

    convert = actions.add_parser(
        "convert", help="read a lens file of any kind, and write it as .lens or .zmx", allow_abbrev=False
    )
    convert.add_argument("lens", metavar="IN", help=f"{KINDS}, or the name of a shipped lens")
    convert.add_argument("out", metavar="OUT", help="a .lens or .zmx file")
    convert.set_defaults(run=_convert)

    draw = actions.add_parser("draw", help="the lens and the light through it, as a picture", allow_abbrev=False)
    draw.add_argument("lens", metavar="FILE", help=f"a lens file ({KINDS}), or the name of a shipped lens")
    draw.add_argument("-o", "--output", required=True, metavar="OUT", help="the picture: .svg, .png or .pdf; or .json")
    draw.add_argument(
        "--fields", nargs="+", type=_number, default=[], metavar="DEG",
        help="angles to the axis; default: 0, and 0.7 and all of the design's half field",
    )  # fmt: skip
    draw.add_argument("--rays", type=int, default=7, metavar="N", help="of each field; default: 7")
    draw.add_argument("--wavelength", type=_number, metavar="NM", help="nanometres; default: the d line")
    _add_setting(draw)
    draw.add_argument(
        "--focus-distance", type=_distance, metavar="MM|inf", help="from the entrance pupil to what is sharp"
    )
    draw.set_defaults(run=_draw)

    lens_report_command.add_parsers(actions, _add_setting, KINDS)

    info = actions.add_parser("info", help="focal length, planes, pupils, aberrations", allow_abbrev=False)
    info.add_argument("lens", metavar="FILE", help=f"a lens file ({KINDS}), or the name of a shipped lens")
    info.add_argument("--wavelength", type=_number, metavar="NM", help="nanometres; default: the d line")
    _add_setting(info)
    info.add_argument(
        "--focus-distance", type=_distance, metavar="MM|inf", help="from the entrance pupil to what is sharp"
    )
    info.add_argument("--json", action="store_true", help="print one JSON object")
    info.set_defaults(run=_info)

    lens_list.add_parser(actions)

    trace = actions.add_parser("trace", help="trace given rays through the lens", allow_abbrev=False)
    trace.add_argument("lens", metavar="FILE", help=f"a lens file ({KINDS}), or the name of a shipped lens")
    trace.add_argument("--rays", required=True, metavar="RAYS.json|-", help="the rays; - reads them from stdin")
    trace.add_argument("--precision", choices=("f64", "f32"), default="f64", help="default: f64")
    _add_setting(trace)
    trace.add_argument("--json", action="store_true", help="print one JSON object")
    trace.set_defaults(run=_trace)


def _add_setting(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--focal-length", type=_number, metavar="MM", help="scale the lens to this focal length")
    opening = parser.add_mutually_exclusive_group()
    opening.add_argument("--f-number", type=_number, metavar="N", help="stop the diaphragm down to this f-number")
    opening.add_argument(
        "--pupil-diameter", type=_number, metavar="MM", help="or to this diameter of the entrance pupil, as of an eye's"
    )
    parser.add_argument("--blades", type=_count, metavar="N", help="blades of the diaphragm, 3 to 24; 0 is round")
    parser.add_argument(
        "--blade-curvature", type=_number, metavar="C", help="of the blades' edges: 0 straight, 1 round"
    )
    parser.add_argument("--blade-rotation", type=_number, metavar="DEG", help="turn of the diaphragm about the axis")
    parser.add_argument("--aperture-mask", metavar="FILE", help="a square picture of the opening, instead of blades")
    parser.set_defaults(usage_error=parser.error)


def _setting(arguments: argparse.Namespace) -> dict[str, Any]:
    """What `_add_setting` asked for, as the engine takes it."""
    if arguments.aperture_mask and arguments.blades:
        arguments.usage_error("--aperture-mask stands instead of --blades: leave out the one or the other")
    rotation = arguments.blade_rotation
    return _given(
        focal_length_mm=arguments.focal_length,
        f_number=arguments.f_number,
        pupil_diameter_mm=arguments.pupil_diameter,
        blades=arguments.blades,
        blade_curvature=arguments.blade_curvature,
        blade_rotation_rad=None if rotation is None else math.radians(rotation),
        aperture_mask=_mask(arguments.aperture_mask) if arguments.aperture_mask else None,
    )


def _mask(path: str) -> Any:
    """The picture of an opening, read by Blender as `petzval render` reads it."""
    if not Path(path).is_file():
        raise CommandError(f"no such picture: {path}: change --aperture-mask")
    _keep_own_voice()
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


def _keep_own_voice() -> None:
    """From here on stdout and stderr are Python's alone: what Blender's own code says must not stand in the answer."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for name, number in (("stdout", 1), ("stderr", 2)):
        getattr(sys, name).flush()
        setattr(sys, name, os.fdopen(os.dup(number), "w", encoding="utf-8", errors="replace"))
        os.dup2(nowhere, number)
    os.close(nowhere)


def _given(**options: Any) -> dict[str, Any]:
    return {name: value for name, value in options.items() if value is not None}


def run(arguments: argparse.Namespace) -> int:
    """Runs the action; returns the exit status."""
    return arguments.run(arguments)


def _number(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"not a finite number: {text}")
    return value


def _count(text: str) -> int:
    value = int(text)
    if value != 0 and not 3 <= value <= 24:
        raise argparse.ArgumentTypeError(f"a diaphragm has 3 to 24 blades, or 0 for a round one: {text}")
    return value


def _distance(text: str) -> float:
    value = float(text)
    if math.isnan(value):
        raise argparse.ArgumentTypeError(f"not a number: {text}")
    return value


# argparse names the type in its message: "invalid number value: 'x'".
_number.__name__ = "number"
_distance.__name__ = "distance"
_count.__name__ = "number"


def _load(name_or_path: str) -> Any:
    from . import _native

    return _native.Lens(str(find_lens(name_or_path)))


#: What the eye sees, nm: for this the index of a lens's glasses should be known.
_VISIBLE_NM = (380.0, 780.0)


def _beyond(lens: Any, wavelengths_nm: Sequence[float]) -> list[str]:
    """The glasses that are asked for an index beyond what is known of them."""
    known = lens.media_beyond(min(wavelengths_nm), max(wavelengths_nm)) if wavelengths_nm else []
    return [
        f"glass {name}: its index is known from {start:.0f} to {end:.0f} nm, beyond it is kept as at the end"
        for name, start, end in known
    ]


def _say(notes: list[str]) -> None:
    for note in notes:
        complain(f"note: {note}")


def _with_notes(answer: str, notes: list[str]) -> str:
    """The JSON object, with what there is to say about it: nothing else than it stands on stdout, and stderr is for errors."""
    return json.dumps({**json.loads(answer), "notes": notes}) if notes else answer


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
            _say(lens.remarks)
            _say([f"{name}: {note}" for note in _beyond(lens, _VISIBLE_NM)])
            print(f"ok: {lens.name}, {lens.surface_count} surfaces")
    return 1 if failures else 0


def _convert(arguments: argparse.Namespace) -> int:
    out = Path(arguments.out)
    lens = _load(arguments.lens)
    text, lost = lens.written(out.suffix.lower().removeprefix("."))
    _say([*lens.remarks, *(f"{out}: {what}" for what in lost)])
    try:
        out.write_text(text, encoding="utf-8")
    except OSError as error:
        raise CommandError(f"cannot write {out}: {error.strerror or error}: choose another place") from None
    print(f"{out}: {lens.name}, {lens.surface_count} surfaces")
    return 0


def _draw(arguments: argparse.Namespace) -> int:
    from . import _native, lens_drawing

    out = Path(arguments.output)
    lens_drawing.check(out)
    options = _given(wavelength_nm=arguments.wavelength, focus_distance_mm=arguments.focus_distance)
    lens = _load(arguments.lens)
    answer = _native.lens_drawing_json(lens, arguments.fields, arguments.rays, **options, **_setting(arguments))
    found = json.loads(answer)
    try:
        lens_drawing.write(found, out)
    except OSError as error:
        raise CommandError(f"cannot write {out}: {error.strerror or error}: choose another place") from None
    dark = [
        f"nothing comes through from {field['angle_deg']:g} degrees" for field in found["fields"] if not field["rays"]
    ]
    _say([*lens.remarks, *_beyond(lens, [found["wavelength_nm"]]), *dark])
    print(f"{out}: {found['name']}")
    return 0


def _info(arguments: argparse.Namespace) -> int:
    options = _given(wavelength_nm=arguments.wavelength, focus_distance_mm=arguments.focus_distance)
    lens = _load(arguments.lens)
    notes = [*lens.remarks, *_beyond(lens, [] if arguments.wavelength is None else [arguments.wavelength])]
    answer = lens.info_json(**options, **_setting(arguments))
    if arguments.json:
        print(_with_notes(answer, notes))
    else:
        print(_table(json.loads(answer)))
        _say(notes)
    return 0


def _trace(arguments: argparse.Namespace) -> int:
    text, question = read_list(arguments.rays, "rays", '{"origin": ..., ...}')
    side = question.get("from", "scene")
    if side not in ("scene", "film"):
        raise CommandError(f'unknown "from": {arguments.rays}: {json.dumps(side)}: give "scene" or "film"')
    options = _setting(arguments)
    lens = _load(arguments.lens)
    answer = lens.trace_json(text, from_film=side == "film", precision=arguments.precision, **options)
    asked = [ray["wavelength_nm"] for ray in question["rays"] if ray.get("wavelength_nm") is not None]
    notes = [*lens.remarks, *_beyond(lens, asked)]
    if arguments.json:
        print(_with_notes(answer, notes))
    else:
        print(_ray_lines(json.loads(answer)["rays"]))
        _say(notes)
    return 0


#: Key of the engine's answer, its words, its unit, the word for null. Keys of nested objects are joined by a point.
_ROWS = (
    ("name", "lens", "", ""),
    ("surfaces", "surfaces", "", ""),
    ("wavelength_nm", "wavelength", "nm", ""),
    ("efl_mm", "focal length", "mm", "infinite"),
    ("f_number", "f-number", "", "none"),
    ("f_number_by_area", "f-number, round and as large", "", "none"),
    ("stop_diameter_mm", "diaphragm's diameter", "mm", ""),
    ("stop_area_mm2", "diaphragm's area", "mm2", ""),
    ("bfd_mm", "back focal distance, from the last vertex", "mm", "infinite"),
    ("ffd_mm", "front focal distance, from the first vertex", "mm", "infinite"),
    ("object_focal_plane_mm", "object focal plane, z", "mm", "infinite"),
    ("object_principal_plane_mm", "object principal plane, z", "mm", "infinite"),
    ("image_principal_plane_mm", "image principal plane, z", "mm", "infinite"),
    ("image_focal_plane_mm", "image focal plane, z", "mm", "infinite"),
    ("entrance_pupil.z_mm", "entrance pupil, z", "mm", "infinite"),
    ("entrance_pupil.diameter_mm", "entrance pupil, diameter", "mm", "infinite"),
    ("exit_pupil.z_mm", "exit pupil, z", "mm", "infinite"),
    ("exit_pupil.diameter_mm", "exit pupil, diameter", "mm", "infinite"),
    ("focus_distance_mm", "focused at, from the entrance pupil", "mm", "infinite"),
    ("object_plane_mm", "object plane, z", "mm", "infinite"),
    ("film_z_mm", "film, z", "mm", ""),
    ("total_track_mm", "length, first vertex to film", "mm", ""),
    ("magnification", "magnification", "", "none"),
    ("working_f_number", "working f-number", "", "none"),
    ("petzval_radius_mm", "Petzval radius", "mm", "infinite"),
    ("vignetting_free_field_deg", "field without vignetting", "deg", "none"),
    ("half_vignetted_field_deg", "field of half the light", "deg", "none"),
    ("largest_field_deg", "field of the last ray", "deg", "none"),
)
_SUMS = ("spherical", "coma", "astigmatism", "field", "distortion", "axial", "lateral")
_SYMBOLS = ("S I", "S II", "S III", "S IV", "S V", "C L", "C T")
#: Digits of the largest sum.
_SUM_DIGITS = 6


def _value_text(value: Any, null: str) -> str:
    if value is None:
        return null
    return f"{value:.6f}" if isinstance(value, float) else str(value)


#: The same of the x-z plane, where an anamorphic lens has another: key in `section_x`, words, unit, words for null.
_ROWS_ACROSS = (
    ("efl_mm", "across (x): focal length", "mm", "infinite"),
    ("f_number", "across (x): f-number", "", "none"),
    ("image_focal_plane_mm", "across (x): image focal plane, z", "mm", "infinite"),
    ("entrance_pupil.z_mm", "across (x): entrance pupil, z", "mm", "infinite"),
    ("entrance_pupil.diameter_mm", "across (x): entrance pupil, diameter", "mm", "infinite"),
)


def _table(info: dict[str, Any]) -> str:
    """Words, value and unit of each row, aligned at the decimal point; then the aberrations by surface."""
    rows = []
    across = [("section_x." + key, *rest) for key, *rest in _ROWS_ACROSS] if info["section_x"] else []
    for key, words, unit, null in (*_ROWS, *across):
        value: Any = info
        for part in key.split("."):
            value = value[part]
        rows.append((words, _value_text(value, null), unit if value is not None else ""))
    words_width = max(len(words) for words, _, _ in rows)
    before_point = max(len(text.split(".")[0]) for _, text, unit in rows if unit)
    lines = []
    for words, text, unit in rows:
        whole, point, rest = text.partition(".")
        aligned = f"{whole:>{before_point}}{point}{rest}" if unit or point else text
        lines.append(f"{words:<{words_width}}  {aligned} {unit}".rstrip())
    if info["axial_beam_cut_by_surface"] is not None:
        lines.append(f"surface {info['axial_beam_cut_by_surface']} cuts the beam on the axis: the stop is not filled")
    return "\n".join([*lines, "", *_sum_lines(info)])


def _sum_lines(info: dict[str, Any]) -> list[str]:
    """The Seidel and chromatic sums: a line a surface, and one of all."""
    if info["seidel"] is None:
        return [f"no Seidel sums: {info['seidel_missing'] or 'they are no numbers'}"]
    rows = [
        [*seidel, *chromatic]
        for seidel, chromatic in zip(info["seidel_by_surface"], info["chromatic_by_surface"], strict=True)
    ]
    rows.append([*info["seidel"], *info["chromatic"]])
    names = [*map(str, range(len(rows) - 1)), "sum"]
    largest = max((abs(value) for row in rows for value in row), default=0.0)
    digits = _SUM_DIGITS - 1 - math.floor(math.log10(largest)) if largest > 0.0 else _SUM_DIGITS
    texts = [[f"{value:z.{max(digits, 0)}f}" for value in row] for row in rows]
    width = max(len(text) for row in [_SUMS, *texts] for text in row) + 2
    lines = [f"Seidel sums and colour from F to C, mm; chief ray at {info['seidel_field_deg']:g} degrees"]
    for name, cells in zip(["", "surface", *names], [_SUMS, _SYMBOLS, *texts], strict=True):
        lines.append(f"{name:<7}" + "".join(f"{cell:>{width}}" for cell in cells))
    return lines


def _ray_lines(rays: list[dict[str, Any]]) -> str:
    """One line a ray: what became of it, and where it is then."""
    lines = []
    for number, ray in enumerate(rays):
        if ray["status"] == "ok":
            text = f"ok, from ({vector_text(ray['origin'])}) mm along ({vector_text(ray['direction'])})"
        else:
            text = f"{ray['status']} at surface {ray['surface']}"
        lines.append(f"{number}: {text}")
    return "\n".join(lines)
