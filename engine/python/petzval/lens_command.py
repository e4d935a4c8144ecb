# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval lens check|convert|draw|info|list|trace` and the way to the others: reads arguments, asks the engine, prints its answer. Computes nothing."""

from __future__ import annotations

import argparse
import json
import math
import os
from pathlib import Path
from typing import Any

from . import (
    lens_calibrate_command,
    lens_export_command,
    lens_fit_command,
    lens_ghosts_command,
    lens_list,
    lens_prove_command,
    lens_reality_command,
    lens_report_command,
)
from .argument_types import natural, number
from .errors import CommandError, complain, writing
from .lens_loading import load, say
from .lens_setting import add_focus, add_setting, setting_of
from .places import find_lens
from .questions import read_list, vector_text

_D_LINE_NM = 587.5618

#: The endings of lens files that are read; tables of the Optical Bench are known by their sections.
KINDS = ".lens, .zmx, .seq, .len, .dat or .txt (a table of the Optical Bench)"


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
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
        "--fields", nargs="+", type=number, default=[], metavar="DEG",
        help="angles to the axis; default: 0, and 0.7 and all of the design's half field",
    )  # fmt: skip
    draw.add_argument("--rays", type=natural, default=7, metavar="N", help="of each field; default: 7")
    draw.add_argument("--wavelength", type=number, metavar="NM", help="nanometres; default: the d line")
    add_setting(draw)
    add_focus(draw)
    draw.set_defaults(run=_draw)

    lens_report_command.add_parsers(actions, KINDS)
    lens_export_command.add_parsers(actions, KINDS)
    lens_ghosts_command.add_parser(actions, KINDS)
    lens_reality_command.add_parser(actions, KINDS)
    lens_calibrate_command.add_parser(actions, KINDS)
    lens_fit_command.add_parser(actions, KINDS)
    lens_prove_command.add_parser(actions, KINDS)

    info = actions.add_parser("info", help="focal length, planes, pupils, aberrations", allow_abbrev=False)
    info.add_argument("lens", metavar="FILE", help=f"a lens file ({KINDS}), or the name of a shipped lens")
    info.add_argument("--wavelength", type=number, metavar="NM", help="nanometres; default: the d line")
    add_setting(info)
    add_focus(info)
    info.add_argument("--json", action="store_true", help="print one JSON object")
    info.set_defaults(run=_info)

    lens_list.add_parser(actions)

    trace = actions.add_parser("trace", help="trace given rays through the lens", allow_abbrev=False)
    trace.add_argument("lens", metavar="FILE", help=f"a lens file ({KINDS}), or the name of a shipped lens")
    trace.add_argument("--rays", required=True, metavar="RAYS.json|-", help="the rays; - reads them from stdin")
    trace.add_argument("--precision", choices=("f64", "f32"), default="f64", help="default: f64")
    add_setting(trace)
    add_focus(trace)
    trace.add_argument("--json", action="store_true", help="print one JSON object")
    trace.set_defaults(run=_trace)


def _given(**options: Any) -> dict[str, Any]:
    return {name: value for name, value in options.items() if value is not None}


def run(arguments: argparse.Namespace) -> int:
    """Runs the action; returns the exit status."""
    status: int = arguments.run(arguments)
    return status


def _with_notes(answer: str, notes: list[str]) -> str:
    """The JSON object, with its remarks inside: nothing else stands on stdout, and stderr is for errors."""
    return json.dumps({**json.loads(answer), "notes": notes}) if notes else answer


def _check(arguments: argparse.Namespace) -> int:
    from . import _native

    failures = 0
    for name in arguments.lenses:
        try:
            lens = load(name)
        except (_native.PetzvalError, CommandError) as error:
            failures += 1
            complain(str(error))
        else:
            say(lens.remarks)
            say([f"{name}: {note}" for note in lens.range_notes()])
            print(f"ok: {lens.name}, {lens.surface_count} surfaces")
    return 1 if failures else 0


def _convert(arguments: argparse.Namespace) -> int:
    from . import atomic_files

    out = Path(arguments.out)
    lens = load(arguments.lens)
    if out.exists() and os.path.samefile(out, find_lens(arguments.lens)):
        raise CommandError(
            f"{out}: it would replace the file that is read, of which not all may be written: name another"
        )
    text, lost = lens.written(out.suffix.lower().removeprefix("."))
    say([*lens.remarks, *(f"{out}: {what}" for what in lost)])
    with writing(out):
        atomic_files.write_text(out, text)
    print(f"{out}: {lens.name}, {lens.surface_count} surfaces")
    return 0


def _draw(arguments: argparse.Namespace) -> int:
    from . import _native, lens_drawing
    from .lens_reports import page

    out = Path(arguments.output)
    page.check(out)
    options = _given(wavelength_nm=arguments.wavelength, focus_distance_mm=arguments.focus_distance)
    lens = load(arguments.lens)
    answer = _native.lens_drawing_json(lens, setting_of(arguments), arguments.fields, arguments.rays, **options)
    found = json.loads(answer)
    lens_drawing.write(found, out)
    dark = [
        f"nothing comes through from {field['angle_deg']:g} degrees" for field in found["fields"] if not field["rays"]
    ]
    say([*lens.remarks, *lens.range_notes([found["wavelength_nm"]]), *dark])
    print(f"{out}: {found['name']}")
    return 0


def _info(arguments: argparse.Namespace) -> int:
    options = _given(wavelength_nm=arguments.wavelength, focus_distance_mm=arguments.focus_distance)
    lens = load(arguments.lens)
    notes = [*lens.remarks, *lens.range_notes([] if arguments.wavelength is None else [arguments.wavelength])]
    answer = lens.info_json(setting_of(arguments), **options)
    if arguments.json:
        print(_with_notes(answer, notes))
    else:
        print(_table(json.loads(answer)))
        say(notes)
    return 0


def _trace(arguments: argparse.Namespace) -> int:
    text, question = read_list(arguments.rays, "rays", '{"origin": ..., ...}')
    side = question.get("from", "scene")
    if side not in ("scene", "film"):
        raise CommandError(f'unknown "from": {arguments.rays}: {json.dumps(side)}: give "scene" or "film"')
    setting = setting_of(arguments)
    lens = load(arguments.lens)
    # Lenses are focused at the d line, as by `petzval lens info`.
    focus = None if arguments.focus_distance is None else (arguments.focus_distance, _D_LINE_NM)
    options = _given(precision=arguments.precision, focus=focus)
    answer = lens.trace_json(text, setting, from_film=side == "film", **options)
    asked = [ray["wavelength_nm"] for ray in question["rays"] if ray.get("wavelength_nm") is not None]
    notes = [*lens.remarks, *lens.range_notes(asked)]
    if arguments.json:
        print(_with_notes(answer, notes))
    else:
        print(_ray_lines(json.loads(answer)["rays"]))
        say(notes)
    return 0


#: Key of the engine's answer, its words, its unit, the word for null. Keys of nested objects are joined by a point.
_ROWS = (
    ("name", "lens", "", ""),
    ("surfaces", "surfaces", "", ""),
    ("wavelength_nm", "wavelength", "nm", ""),
    ("efl_mm", "focal length", "mm", "infinite"),
    ("f_number", "f-number, at infinity", "", "none"),
    ("t_number", "T-number, at infinity, white light", "", "none"),
    ("f_number_by_area", "f-number, at infinity, round and as large", "", "none"),
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
    ("working_f_number", "working f-number, as focused", "", "none"),
    ("petzval_radius_mm", "Petzval radius", "mm", "infinite"),
    ("vignetting_free_field_deg", "half field without vignetting", "deg", "none"),
    ("half_vignetted_field_deg", "half field of half the light", "deg", "none"),
    ("largest_field_deg", "half field of the last ray", "deg", "none"),
)
_SUMS = ("spherical", "coma", "astigmatism", "field", "distortion", "axial", "lateral")
_SYMBOLS = ("S I", "S II", "S III", "S IV", "S V", "C L", "C T")
#: Digits of the largest sum.
_SUM_DIGITS = 6


def _value_text(value: Any, null: str) -> str:
    if value is None:
        return null
    return f"{value:.6f}" if isinstance(value, float) else str(value)


#: The rows of the x-z plane, which differ for an anamorphic lens: key in `section_x`, words, unit, words for null.
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
    if moved := info["misaligned_surfaces"]:
        lines.append(
            f"decentred or tilted: {_runs(moved)}; what is of first order here is that of the lens with all its surfaces on the axis"
        )
    lines.append(_coating_line(info))
    if clear := info["unknown_absorption"]:
        lines.append(f"counted as clear, for their absorption is not known: {', '.join(clear)}")
    return "\n".join([*lines, "", *_sum_lines(info)])


def _runs(numbers: list[int]) -> str:
    """Surfaces by their numbers, neighbours together: "surfaces 2-4, 7"."""
    runs: list[list[int]] = []
    for surface in numbers:
        if runs and surface == runs[-1][-1] + 1:
            runs[-1].append(surface)
        else:
            runs.append([surface])
    said = ", ".join(f"{run[0]}-{run[-1]}" if len(run) > 1 else f"{run[0]}" for run in runs)
    return f"surface{'s' if len(numbers) > 1 else ''} {said}"


def _coating_line(info: dict[str, Any]) -> str:
    """The coatings of the lens's surfaces in air, in a line."""
    names = ", ".join(info["coatings"]) or "no surface in air"
    return f"coatings: {names}" + (" (assumed: the file names none)" if info["coating_is_assumed"] else "")


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
    """One line a ray: its status, and its place and direction then."""
    lines = []
    for i, ray in enumerate(rays):
        if ray["status"] == "ok":
            text = f"ok, from ({vector_text(ray['origin'])}) mm along ({vector_text(ray['direction'])})"
        else:
            text = f"{ray['status']} at surface {ray['surface']}"
        lines.append(f"{i}: {text}")
    return "\n".join(lines)
