# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval lens calibrate`: a camera model fitted to a lens. Reads arguments, asks the engine, writes and prints its answer. Computes nothing."""

from __future__ import annotations

import argparse
import dataclasses
import json
from pathlib import Path
from typing import Any

from . import argument_types as types
from .calibration_command import form_of
from .errors import CommandError, writing
from .lens_camera import add_pose, camera_of
from .lens_loading import load, say
from .lens_setting import add_focus, add_setting
from .scene_options import check_apart, check_writable

#: Pixels across a picture whose size is not asked for.
_WIDTH_PX = 1920
#: The residual of a model beyond which a note says so, pixels.
_MUCH_PX = 0.5


def add_parser(actions: Any, kinds: str) -> None:
    """Adds `calibrate` to the actions of `petzval lens`."""
    calibrate = actions.add_parser(
        "calibrate", help="fit a camera model of OpenCV, COLMAP and others to the lens", allow_abbrev=False
    )
    calibrate.add_argument("lens", metavar="FILE", help=f"a lens file ({kinds}), or the name of a shipped lens")
    calibrate.add_argument(
        "--model", default="opencv", metavar="NAME",
        help="opencv, fisheye, thin-prism-fisheye, rad-tan-thin-prism-fisheye, fov, division, double-sphere, eucm, omni, f-theta, "
        "f-theta-to-pixels; default: opencv",
    )  # fmt: skip
    calibrate.add_argument(
        "--coefficients", metavar="K1,K2,...|none",
        help="the coefficients that are found, by their names in docs/calibrated-cameras.md; default: those that the lens's symmetry leaves",
    )  # fmt: skip
    calibrate.add_argument(
        "--size", type=types.pixels, metavar="WxH", help=f"pixels; default: {_WIDTH_PX} across, in the film's shape"
    )
    calibrate.add_argument(
        "--film", type=types.film, default="lens", metavar="WxH|NAME|lens",
        help=f"millimetres, or {types.FILM_NAMES}; default: lens, that which the lens is made for",
    )  # fmt: skip
    calibrate.add_argument(
        "--centre", choices=("pupil", "nearest"), default="pupil",
        help="the centre of projection: the entrance pupil on the axis, or the point nearest to all chief rays; default: pupil",
    )  # fmt: skip
    calibrate.add_argument("--wavelength", type=types.positive, metavar="NM", help="nanometres; default: the d line")
    add_setting(calibrate)
    add_focus(calibrate)
    add_pose(calibrate)
    calibrate.add_argument(
        "-o", "--output", metavar="OUT", help="the calibration: a .yml, .yaml, .json or .txt file, as `calibration convert`"
    )  # fmt: skip
    calibrate.add_argument(
        "--to", choices=("opencv", "ros", "colmap"), help="the file's format; default: by its ending"
    )
    calibrate.add_argument("--map", metavar="RAYS.exr", help="the ray of each pixel, origin and direction, 32 bits")
    calibrate.add_argument("--residual", metavar="OFF.exr", help="what the model leaves in each pixel, in pixels")
    calibrate.add_argument("--json", action="store_true", help="print one JSON object")
    calibrate.set_defaults(run=_calibrate)


def _picture(name: str | None, option: str) -> Path | None:
    if name is None:
        return None
    out = Path(name)
    if out.suffix.lower() != ".exr":
        raise CommandError(f"cannot write {out}: its ending is not .exr: change {option}")
    check_writable(out)
    return out


def _camera(arguments: argparse.Namespace) -> Any:
    """The camera, and the picture's pixels."""
    from . import _native

    is_of_lens = arguments.film == "lens"
    if is_of_lens:
        arguments.film = [36.0, 24.0]
    camera = camera_of(arguments, wavelength_nm=arguments.wavelength)
    if is_of_lens:
        width_mm, height_mm = _native.film_of_lens_mm(camera, *(arguments.size or (3, 2)))
        camera = dataclasses.replace(
            camera, film=dataclasses.replace(camera.film, width_mm=width_mm, height_mm=height_mm)
        )
    film = camera.film
    size = arguments.size or [_WIDTH_PX, max(1, round(_WIDTH_PX * film.height_mm / film.width_mm))]
    return camera, tuple(size)


def _coefficients(text: str | None) -> list[str] | None:
    if text is None:
        return None
    return [] if text.strip().lower() == "none" else [name.strip() for name in text.split(",") if name.strip()]


def _calibrate(arguments: argparse.Namespace) -> int:
    from . import _native, atomic_files

    out = Path(arguments.output) if arguments.output else None
    form = None
    if out is not None:
        form = form_of(out, arguments.to)[1]
        check_writable(out)
    elif arguments.to:
        arguments.usage_error("--to is the format of --output: give that, too")
    maps = {"--map": _picture(arguments.map, "--map"), "--residual": _picture(arguments.residual, "--residual")}
    check_apart({"--output": out, **maps}, {"the lens": arguments.lens})
    lens = load(arguments.lens)
    camera, size = _camera(arguments)
    options = {
        "model": arguments.model,
        "coefficients": _coefficients(arguments.coefficients),
        "centre": arguments.centre.upper(),
    }
    comments = {
        "--map": f"{lens.name}: the ray of each pixel. origin: mm, on the first surface; direction: unit; x right, y down, z ahead, from the "
        "centre of projection. A: 1 where the lens lights.",
        "--residual": f"{lens.name}, {arguments.model}: where the model sees what the lens shows in each pixel, from there, pixels to the right "
        "and down. A: 1 where both see.",
    }
    asked = {option: (str(file), comments[option]) if file else None for option, file in maps.items()}
    answer, text = _native.fitted_camera_json(
        camera, size, options, lens.name, form, asked["--map"], asked["--residual"]
    )
    if out is not None and text is not None:
        with writing(out):
            atomic_files.write_text(out, text)
    found = json.loads(answer)
    notes = [*lens.remarks, *lens.range_notes([found["wavelength_nm"]]), *_notes(found, camera)]
    if arguments.json:
        print(json.dumps({**found, "notes": notes}))
    else:
        print("\n".join(_lines(found)))
        say(notes)
    return 0


def _notes(found: dict[str, Any], camera: Any) -> list[str]:
    """The notes on unusual findings."""
    notes = []
    (width, height), film = found["picture_mm"], camera.film
    if min(width / film.width_mm, height / film.height_mm) < 0.999:
        notes.append(
            f"the picture takes {width:.4g} x {height:.4g} mm of the film's {film.width_mm:g} x {film.height_mm:g} mm: it has another shape"
        )
    if found["lit"] < 0.9995:
        notes.append(
            f"the lens lights {100.0 * found['lit']:.1f} % of the picture by its chief rays, up to {found['largest_angle_deg']:.1f} degrees from "
            "the axis: the model is fitted there, and goes on beyond by its formula"
        )
    if found["covered"] < 1.0:
        notes.append(
            f"the model has no direction for {100.0 * (1.0 - found['covered']):.2f} % of the picture: {found['reason']}"
        )
    valid = found["valid_to_deg"]
    if valid is not None and valid < 1.01 * found["largest_angle_deg"]:
        notes.append(
            f"the best formula without a fold in the lit picture folds at its edge, {valid:.1f} degrees from the axis: the model does not suit the "
            "lens, a fisheye's may"
        )
    elif found["worst_px"] > _MUCH_PX:
        notes.append(
            f"the model leaves up to {found['worst_px']:.2g} pixels: give more --coefficients, another --model, or take the exact --map"
        )
    return notes


def _distance(mm: float | None) -> str:
    return "infinity" if mm is None else f"{1e-3 * mm:.4g} m"


def _lines(found: dict[str, Any]) -> list[str]:
    width, height = found["size_px"]
    across, up = found["picture_mm"]
    lines = [
        f"{found['name']}: {found['model']}, {width} x {height} pixels of {1e3 * across / width:.4g} um, counted from the corner of the first, "
        f"focused at {_distance(found['focus_distance_mm'])}"
    ]
    lines += [
        f"  {name} {value:.10g}" + ("" if name in found["free"] or name in ("fy", "cx", "cy") else "  (not fitted)")
        for name, value in found["parameters"].items()
        if value != 0.0 or name in found["free"]
    ]
    x, y = found["worst_at_px"]
    lines.append(
        f"  left over: rms {found['rms_px']:.3g} pixels, at most {found['worst_px']:.3g} at ({x:.0f}, {y:.0f}), "
        f"{found['worst_angle_deg']:.1f} degrees from the axis; {found['rays']} rays"
    )
    fields = [found["horizontal_field_deg"], found["vertical_field_deg"]]
    shown = ("none: an edge shows nothing" if field is None else f"{field:.3f} degrees" for field in fields)
    valid = found["valid_to_deg"]
    lines.append(
        f"  field of view across {', up '.join(shown)}; valid "
        + ("everywhere" if valid is None else f"to {valid:.2f} degrees from the axis, where its distortion folds back")
    )
    low, high = found["wander_mm"]
    lines.append(
        f"  centre of projection {found['centre_z_mm']:.3f} mm behind the first vertex; the chief rays cross the axis {low:.3f} to {high:.3f} mm "
        "from it"
    )
    for other in found["elsewhere"]:
        lines.append(
            f"  a scene at {_distance(other['distance_mm'])}: rms {other['rms_px']:.3g} pixels, at most {other['worst_px']:.3g}"
        )
    return lines
