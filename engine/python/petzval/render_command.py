# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval render`: its arguments, and where it runs: in this Python's bpy, or in a Blender that is named."""

from __future__ import annotations

import argparse
import json
import math
import os
import re
import signal
import subprocess
from pathlib import Path

from . import film_formats
from .errors import CommandError
from .places import find_lens

_SUFFIXES = {".exr", ".png"}
#: What the engine always simulates, and what it cannot yet; colour can be chosen.
_ALWAYS = {"defocus", "aberration", "distortion", "vignetting", "diaphragm"}
_COLOUR = {"lateral_colour", "axial_colour"}
_NOT_YET = {"transmission", "ghosts", "glare", "diffraction", "motion_blur"}
#: Exit status of a command that was broken off.
_INTERRUPTED = 130
_FILM_NAMES = ", ".join(film.name for film in film_formats.FILM_FORMATS)
#: What the half in Blender ends with, having said why, and what that means here. No program ends so by chance.
_OWN_STATUS = {70: 0, 71: 1, _INTERRUPTED: _INTERRUPTED}


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    """Adds `render`."""
    p = subparsers.add_parser("render", help="render a .blend through a lens", allow_abbrev=False)
    p.add_argument("scene", metavar="SCENE.blend")
    p.add_argument("--lens", metavar="FILE", help="a lens file, or the name of a shipped lens")
    p.add_argument(
        "--camera",
        choices=("pinhole", "thin", "thick", "paraxial", "image-based"),
        help="a simpler camera instead; thick, paraxial and image-based are made from the lens",
    )
    p.set_defaults(usage_error=p.error)
    p.add_argument("--focal-length", type=_positive, metavar="MM", help="scale the lens to this focal length")
    p.add_argument("--f-number", type=_positive, metavar="N", help="default: as the file has it")
    p.add_argument("--blades", type=int, metavar="N", help="blades of the diaphragm, 3 to 24; 0 is round")
    p.add_argument("--shutter", type=_positive, metavar="S", help="expose physically, so many seconds")
    p.add_argument("--iso", type=_positive, metavar="N", help="expose physically, with a film of that speed")
    p.add_argument("--blade-curvature", type=_part, metavar="C", help="of the blades' edges: 0 straight, 1 round")
    p.add_argument("--blade-rotation", type=_number, metavar="DEG", help="turn of the diaphragm about the axis")
    p.add_argument("--aperture-mask", metavar="FILE", help="a square picture of the opening, instead of blades")
    p.add_argument("--film", type=_film, metavar="NAME|WxH", help=f"mm, or one of {_FILM_NAMES}")
    p.add_argument("--film-diagonal", type=_positive, metavar="MM", help="the film scaled to it, its shape kept")
    p.add_argument("--focus-distance", type=_distance, metavar="MM|inf", help="from the anchor")
    p.add_argument(
        "--anchor",
        choices=("entrance-pupil", "front-vertex", "film"),
        help="what distances count from, at the camera's place",
    )
    p.add_argument(
        "--focus-relation", choices=("exact", "thin"), help="thin: 1/U + 1/V = 1/f, from the principal planes"
    )
    p.add_argument(
        "--autofocus",
        type=_place,
        metavar="X,Y",
        help="on what the picture shows there; 0,0 is lower left, 1,1 upper right",
    )
    p.add_argument(
        "--sharp",
        type=_point,
        nargs=3,
        metavar="X,Y,Z",
        help="turn the film so that three points of the world are sharp",
    )
    # Coordinates may begin with a minus: what looks so is no option here.
    p._negative_number_matcher = re.compile(r"-[\d.]")
    p.add_argument("--tilt", type=_number, metavar="DEG", help="turn of the film about its horizontal axis")
    p.add_argument("--swing", type=_number, metavar="DEG", help="turn of the film about its vertical axis")
    p.add_argument("--shift", type=_pair, metavar="X,Y", help="the lens right and up against the film, mm")
    p.add_argument("--scale", type=_triple, metavar="X,Y,Z", help="millimetres for one Blender unit along each axis")
    p.add_argument("--spectrum", type=_wavelengths, metavar="visible|rgb|NM", help="all wavelengths, three, or one")
    p.add_argument(
        "--precision",
        choices=("auto", "f32", "f64"),
        help="of rays on their way out of the lens; auto: f32 where it moves none by more than 0.01 pixel",
    )
    p.add_argument("--pipeline", choices=("film", "scene", "hero"), help="default: hero where the glass disperses")
    p.add_argument(
        "--integrator", choices=("path", "bdpt"), help="bdpt: from the lights, too; default: as the scene has it"
    )
    p.add_argument("--effect", action="append", default=[], type=_effect, metavar="NAME=auto|on|off")
    p.add_argument("--quality", type=_positive, metavar="Q", help="1 is the default")
    p.add_argument("--samples", type=_count, metavar="N", help="paths for each pixel; with --noise-threshold, at most")
    p.add_argument(
        "--noise-threshold",
        type=_threshold,
        metavar="E",
        help="stop where a pixel's error, relative to the root of its brightness, is below it: 0.01; 0: never",
    )
    p.add_argument("--min-samples", type=_natural, metavar="N", help="before the error is first looked at; 0: 16")
    p.add_argument("--seed", type=_natural, metavar="N")
    p.add_argument(
        "--blue-noise",
        choices=("on", "off"),
        help="errors of neighbouring pixels cancel; off to join ranges of samples, and with --noise-threshold",
    )
    p.add_argument("--sample-offset", type=_natural, metavar="N", help="number of the first sample")
    p.add_argument("--resolution", type=_pixels, metavar="WxH")
    p.add_argument("--frame", type=int, metavar="N")
    p.add_argument("--threads", type=_natural, metavar="N", help="0: one for each core")
    p.add_argument("-o", "--output", metavar="OUT.exr|png", help="default: SCENE.png where you are")
    p.add_argument("--stats", metavar="STATS.json", help="write what was done, and what it took")
    p.add_argument("--blender", metavar="PATH", help="run in this Blender rather than in bpy")


def run(arguments: argparse.Namespace) -> int:
    """Renders; the exit status."""
    options = _checked(arguments)
    if arguments.blender:
        return _in_blender(arguments.blender, options)
    from .render_in_blender import finish, render

    # bpy with a render engine hangs or crashes when Python ends by itself.
    finish(render(options))
    return _INTERRUPTED


def _checked(a: argparse.Namespace) -> dict:
    """The options as plain data, checked as far as they can be without Blender."""
    scene = Path(a.scene)
    if not scene.is_file():
        raise CommandError(f"no such scene: {scene}: name a .blend file")
    if a.lens and a.camera in {"pinhole", "thin"}:
        a.usage_error(f"--camera {a.camera} has no lens: leave out the one or the other")
    if a.quality not in (None, 1.0):
        raise CommandError(f"quality {a.quality:g}: effects are not planned yet: leave --quality out")
    if a.blades is not None and a.blades != 0 and not 3 <= a.blades <= 24:
        raise CommandError(f"{a.blades} blades: a diaphragm has 3 to 24, or 0 for a round one: change --blades")
    if a.aperture_mask and a.blades:
        a.usage_error("--aperture-mask stands instead of --blades: leave out the one or the other")
    if a.aperture_mask and not Path(a.aperture_mask).is_file():
        raise CommandError(f"no such picture: {a.aperture_mask}: change --aperture-mask")
    ways = {"--focus-distance": a.focus_distance, "--autofocus": a.autofocus, "--sharp": a.sharp}
    if len(asked := [name for name, value in ways.items() if value is not None]) > 1:
        a.usage_error(f"{' and '.join(asked)} say different things of the focus: leave out all but one")
    if a.sharp and (a.tilt is not None or a.swing is not None):
        a.usage_error("--sharp finds tilt and swing: leave out --tilt and --swing")
    output = Path(a.output) if a.output else Path(f"{scene.stem}.png")
    if output.suffix.lower() not in _SUFFIXES:
        raise CommandError(f"unknown picture format: {output}: end its name in .exr or .png")
    for file in (output, Path(a.stats) if a.stats else None):
        if file is not None and not file.absolute().parent.is_dir():
            raise CommandError(f"no such folder: {file.parent}: make it first")
        if file is not None:
            _check_writable(file)
    return {
        "scene": str(scene.absolute()),
        "output": str(output.absolute()),
        "stats": str(Path(a.stats).absolute()) if a.stats else None,
        "lens": str(find_lens(a.lens).absolute()) if a.lens else None,
        "camera": a.camera,
        "focal_length_mm": a.focal_length,
        "f_number": a.f_number,
        "blades": a.blades,
        "shutter_s": a.shutter,
        "iso": a.iso,
        "blade_curvature": a.blade_curvature,
        "aperture_mask": str(Path(a.aperture_mask).absolute()) if a.aperture_mask else None,
        "blade_rotation_rad": None if a.blade_rotation is None else math.radians(a.blade_rotation),
        "focus_distance_mm": "inf" if a.focus_distance == math.inf else a.focus_distance,
        "anchor": a.anchor,
        "focus_relation": a.focus_relation,
        "autofocus": a.autofocus,
        "sharp": a.sharp,
        "film_mm": a.film,
        "film_diagonal_mm": a.film_diagonal,
        "tilt_rad": None if a.tilt is None else math.radians(a.tilt),
        "swing_rad": None if a.swing is None else math.radians(a.swing),
        "shift_mm": a.shift,
        "scale_mm": a.scale,
        "spectrum": _spectrum(dict(a.effect), a.spectrum),
        "precision": a.precision,
        "pipeline": a.pipeline,
        "integrator": {"path": "PATH", "bdpt": "BIDIRECTIONAL", None: None}[a.integrator],
        "samples": a.samples,
        "noise_threshold": a.noise_threshold,
        "min_samples": a.min_samples,
        "seed": a.seed,
        "blue_noise": a.blue_noise,
        "sample_offset": a.sample_offset,
        "resolution": a.resolution,
        "frame": a.frame,
        "threads": a.threads,
    }


def _check_writable(file: Path) -> None:
    """Before the work, not after it."""
    is_new = not file.exists()
    try:
        file.open("ab").close()
        if is_new:
            file.unlink()
    except OSError as error:
        raise CommandError(f"cannot write {file}: {error.strerror}: name another file") from None


def _spectrum(effects: dict[str, str], asked: str | float | None) -> str | float | None:
    """The wavelengths: VISIBLE, THREE, SINGLE or nm; None leaves them as the file has them. What cannot be had is refused."""
    for name, word in effects.items():
        if name in _ALWAYS and word == "off":
            raise CommandError(f"effect {name}=off: exact tracing always has it: use --camera pinhole or thin")
        if name in _NOT_YET and word == "on":
            raise CommandError(f"effect {name}=on: not available yet: leave it out")
    colours = {effects.get(name, "auto") for name in _COLOUR} - {"auto"}
    if len(colours) > 1:
        raise CommandError("lateral_colour and axial_colour: one cannot be had without the other yet: set both alike")
    if not colours:
        return asked
    if asked is not None and (asked in {"VISIBLE", "THREE"}) != (colours == {"on"}):
        raise CommandError("--spectrum and --effect say different things of colour: leave out the one or the other")
    return asked or ("VISIBLE" if colours == {"on"} else "SINGLE")


def _in_blender(program: str, options: dict) -> int:
    """Runs the same inside of a Blender program; Ctrl-C is handed on, and its picture waited for."""
    runner = Path(__file__).with_name("render_in_blender.py")
    # Blender may complain on its stderr as it likes: that goes to stdout, and Petzval's own words come through a pipe
    # of their own.
    voice = os.dup(2)
    handed_over = {**options, "package_parent": str(Path(__file__).resolve().parent.parent), "stderr_fd": voice}
    command = [program, "-b", "--factory-startup", "--disable-autoexec", "--python-exit-code", "3"]
    command += ["--python", str(runner), "--", json.dumps(handed_over)]
    try:
        # A group of its own: the terminal's Ctrl-C comes here alone, and goes on to all that the program started.
        child = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stderr=subprocess.STDOUT, pass_fds=(voice,), start_new_session=True
        )
    except OSError as error:
        raise CommandError(f"cannot start {program}: {error.strerror}: give --blender a Blender program") from None
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda asked, _frame: os.killpg(child.pid, asked))
    status = child.wait()
    if status in _OWN_STATUS:
        return _OWN_STATUS[status]
    raise CommandError(f"{program} ended with status {status}: it does not run, or crashed: see what it said above")


def _number(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"not a finite number: {text}")
    return value


def _positive(text: str) -> float:
    value = _number(text)
    if value <= 0.0:
        raise argparse.ArgumentTypeError(f"must be above zero: {text}")
    return value


def _part(text: str) -> float:
    value = float(text)
    if not 0.0 <= value <= 1.0:
        raise argparse.ArgumentTypeError(f"must be from 0 to 1: {text}")
    return value


def _threshold(text: str) -> float:
    value = float(text)
    if not 0.0 <= value <= 10.0:
        raise argparse.ArgumentTypeError(f"must be from 0 to 10: {text}")
    return value


def _distance(text: str) -> float:
    value = float(text)
    if math.isnan(value) or value <= 0.0:
        raise argparse.ArgumentTypeError(f"not a distance: {text}")
    return value


def _natural(text: str) -> int:
    value = int(text)
    if not 0 <= value < 2**31:
        raise argparse.ArgumentTypeError(f"must be from 0 to 2^31 - 1: {text}")
    return value


def _count(text: str) -> int:
    value = _natural(text)
    if value == 0:
        raise argparse.ArgumentTypeError("must be at least 1")
    return value


def _split(text: str, separator: str, count: int) -> list[str]:
    parts = text.lower().split(separator)
    if len(parts) != count:
        raise argparse.ArgumentTypeError(f"must be {count} values with '{separator}' between them: {text}")
    return parts


def _size_mm(text: str) -> list[float]:
    return [_positive(part) for part in _split(text, "x", 2)]


def _film(text: str) -> list[float]:
    film = film_formats.by_name(text)
    if film is not None:
        return [film.width_mm, film.height_mm]
    if "x" not in text.lower():
        raise argparse.ArgumentTypeError(f"no such film: {text}: give WIDTHxHEIGHT in mm, or one of {_FILM_NAMES}")
    return _size_mm(text)


def _pixels(text: str) -> list[int]:
    return [_count(part) for part in _split(text, "x", 2)]


def _pair(text: str) -> list[float]:
    return [_number(part) for part in _split(text, ",", 2)]


def _place(text: str) -> list[float]:
    place = _pair(text)
    if not all(0.0 <= part <= 1.0 for part in place):
        raise argparse.ArgumentTypeError(f"must be from 0 to 1: {text}")
    return place


def _point(text: str) -> list[float]:
    return [_number(part) for part in _split(text, ",", 3)]


def _triple(text: str) -> list[float]:
    return [_positive(part) for part in _split(text, ",", 3)]


def _wavelengths(text: str) -> str | float:
    words = {"visible": "VISIBLE", "rgb": "THREE"}
    return words.get(text) or _positive(text)


def _effect(text: str) -> tuple[str, str]:
    name, _, word = text.partition("=")
    names = sorted(_ALWAYS | _COLOUR | _NOT_YET)
    if name not in names or word not in {"auto", "on", "off"}:
        raise argparse.ArgumentTypeError(f"{text}: give NAME=auto|on|off, NAME one of {', '.join(names)}")
    return name, word


for _type, _name in ((_number, "number"), (_positive, "number"), (_part, "number"), (_distance, "distance"),
                     (_natural, "number"), (_count, "number"), (_size_mm, "size"), (_film, "film"), (_pixels, "size"),
                     (_pair, "pair"), (_triple, "triple"), (_effect, "effect"), (_wavelengths, "spectrum"),
                     (_place, "place"), (_point, "point")):  # fmt: skip
    # argparse names the type in its message: "invalid number value: 'x'".
    _type.__name__ = _name
