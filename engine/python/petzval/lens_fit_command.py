# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval lens fit`: a lens adjusted to a measured calibration. Reads arguments, asks the engine, writes and prints its answer. Computes nothing."""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path
from typing import Any

from . import argument_types as types
from .calibration_command import KINDS as CALIBRATIONS
from .errors import CommandError, writing
from .lens_loading import load, say
from .lens_setting import add_focus, add_setting, setting_of
from .scene_options import check_apart, check_writable

_D_LINE_NM = 587.5618


def _pitch(text: str) -> list[float]:
    """One side for square pixels, or width and height."""
    sides = [types.positive(one) for one in text.split(",")]
    if len(sides) > 2:
        raise argparse.ArgumentTypeError(f"give one number, or width and height: {text}")
    return [sides[0], sides[-1]]


def _gaps(text: str) -> tuple[dict[str, float], list[int] | None]:
    """`0.2`, `2%`, `0.2:3,7`: how far gaps may change, and behind which surfaces they are."""
    size, colon, surfaces = text.partition(":")
    part = size.strip().endswith("%")
    value = types.positive(size.strip().removesuffix("%"))
    tolerance = {"PART": value / 100.0} if part else {"MILLIMETRES": value}
    return tolerance, [types.natural(one) for one in surfaces.split(",")] if colon else None


_pitch.__name__, _gaps.__name__ = "pixel size", "tolerance"


def add_parser(actions: Any, kinds: str) -> None:
    """Adds `fit` to the actions of `petzval lens`."""
    fit = actions.add_parser("fit", help="adjust the lens to a measured camera calibration", allow_abbrev=False)
    fit.add_argument("lens", metavar="FILE", help=f"a lens file ({kinds}), or the name of a shipped lens")
    fit.add_argument("--calibration", required=True, metavar="FILE", help=CALIBRATIONS)
    fit.add_argument("--calibration-camera", metavar="NAME", help="of the file's cameras, where there are several")
    fit.add_argument("--pixel-pitch-um", type=_pitch, metavar="UM[,UM]", help="size of a pixel on the sensor")
    fit.add_argument(
        "--film", type=types.film, default="lens", metavar="WxH|NAME|lens",
        help=f"or the size of the sensor: millimetres, or {types.FILM_NAMES}; default: lens, that of the lens file",
    )  # fmt: skip
    fit.add_argument(
        "--adjust", default="focal-length", metavar="NAME,...",
        help="focal-length (the size of the lens), focus, film-distance, or none; default: focal-length",
    )  # fmt: skip
    fit.add_argument(
        "--gaps", type=_gaps, metavar="MM|PERCENT%[:N,N...]",
        help="adjust the gaps in air within this tolerance, too, or those behind surfaces N alone",
    )  # fmt: skip
    fit.add_argument("--wavelength", type=types.positive, default=_D_LINE_NM, metavar="NM", help="nanometres; default: the d line")  # fmt: skip
    add_setting(fit)
    add_focus(fit)
    fit.add_argument("-o", "--output", metavar="FITTED.lens", help="the fitted lens")
    fit.add_argument("--json", action="store_true", help="print one JSON object")
    fit.set_defaults(run=_fit)


def _fit(arguments: argparse.Namespace) -> int:
    from . import _native, atomic_files

    out = Path(arguments.output) if arguments.output else None
    if out is not None:
        if out.suffix.lower() != ".lens":
            raise CommandError(f"cannot write {out}: its ending is not .lens: change --output")
        check_writable(out)
    check_apart({"--output": out}, {"the lens": arguments.lens, "--calibration": arguments.calibration})
    lens = load(arguments.lens)
    distance = arguments.focus_distance
    tolerance, surfaces = arguments.gaps or (None, None)
    options = {
        "calibration": arguments.calibration,
        "camera": arguments.calibration_camera,
        "pixel_pitch_um": arguments.pixel_pitch_um,
        "film_mm": None if arguments.film == "lens" else arguments.film,
        "wavelength_nm": arguments.wavelength,
        "focus_distance_mm": None if distance is None or math.isinf(distance) else distance,
        "adjust": [name.strip() for name in arguments.adjust.split(",") if name.strip() not in ("", "none")],
        "gaps": tolerance,
        "surfaces": surfaces,
    }
    answer, text, lost = _native.fitted_lens_json(lens, setting_of(arguments), options)
    found = json.loads(answer)
    if out is not None:
        with writing(out):
            atomic_files.write_text(out, text)
    notes = [*lens.remarks, *lens.range_notes([arguments.wavelength]), *(f"{out}: {what}" for what in lost if out)]
    notes += _notes(found)
    if arguments.json:
        print(json.dumps({**found, "notes": notes}))
    else:
        print("\n".join(_lines(found)))
        say(notes)
    return 0


def _notes(found: dict[str, Any]) -> list[str]:
    """The notes on unusual findings."""
    notes = []
    if found["compared"] < 0.9995:
        notes.append(
            f"{100.0 * found['compared']:.1f} % of the picture are compared: elsewhere the lens or the calibration sees nothing"
        )
    if pairs := [f"{one} and {other}" for one, other in found["alike"]]:
        notes.append(
            f"the calibration hardly tells apart what does the same to the picture, so leave out one of each: {', '.join(pairs)}"
        )
    ends = [str(gap["surface"]) for gap in found["gaps"] if gap["is_at_end"]]
    if ends:
        notes.append(f"at the end of their tolerance: the gaps behind surfaces {', '.join(ends)}")
    return notes


def _length(mm: float | None) -> str:
    return "none" if mm is None else f"{mm:.4f}"


def _far(mm: float | None) -> str:
    return "infinity" if mm is None else f"{1e-3 * mm:.4g} m"


def _lines(found: dict[str, Any]) -> list[str]:
    width, height = found["size_px"]
    across, up = found["pixel_pitch_um"]
    before, after = found["before"], found["after"]
    lines = [
        f"{found['name']}: to {found['calibration']}, {found['model']}, {width} x {height} pixels of {across:.4g} x {up:.4g} um, {found['points']} "
        "places",
        f"{'':24}{'before':>14}{'after':>14}",
    ]
    rows = (
        ("left over, rms", "rms_px", "pixels"),
        ("left over, at most", "worst_px", "pixels"),
        ("on the sensor, rms", "rms_um", "um"),
        ("on the sensor, at most", "worst_um", "um"),
        ("focal length", "efl_mm", "mm"),
        ("film, from last vertex", "film_distance_mm", "mm"),
    )
    lines += [f"  {words:<22}{_length(before[key]):>14}{_length(after[key]):>14} {unit}" for words, key, unit in rows]
    key = "focus_distance_mm"
    lines.append(f"  {'focused at':<22}{_far(before[key]):>14}{_far(after[key]):>14}")
    for gap in found["gaps"]:
        lines.append(
            f"  {'gap behind ' + str(gap['surface']):<22}{gap['before_mm']:>14.4f}{gap['after_mm']:>14.4f} mm, within {gap['tolerance_mm']:.4g}, "
            f"all of which moves the picture by {gap['effect_px']:.3g} pixels"
        )
    x, y = after["worst_at_px"]
    lines.append(f"  the lens times {found['scale']:.6f}; the largest of what is left at ({x:.0f}, {y:.0f})")
    return lines
