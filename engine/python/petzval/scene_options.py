# SPDX-License-Identifier: GPL-3.0-or-later
"""The options that every command has which opens a .blend: the lens, its setting, the simulated effects; and where it runs:
in this Python's bpy, or in a Blender that is named."""

from __future__ import annotations

import argparse
import json
import math
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TextIO

from . import argument_types as types
from . import interrupts, processes
from .description import INSTALLED_LENSFUN, MOST_BLADES
from .errors import AGAIN, CommandError
from .interrupts import INTERRUPTED
from .places import find_lens
from .sensor_options import SENSORS

#: The exit statuses of the half in Blender, which has said why, and their meaning here. No program ends so by chance.
_OWN_STATUS = {70: 0, 71: 1, 72: 2, 73: AGAIN, INTERRUPTED: INTERRUPTED}


#: Attributes of parsed arguments that are no option of the half in Blender.
_NO_OPTIONS = {"action", "blender", "command", "effect", "run", "usage_error"}


def add(p: argparse.ArgumentParser) -> None:
    """Adds the scene and its options."""
    p.add_argument("scene", metavar="SCENE.blend")
    p.add_argument("--lens", metavar="FILE", help="a lens file, or the name of a shipped lens")
    p.add_argument(
        "--camera",
        choices=("pinhole", "thin", "thick", "paraxial", "image-based", "calibrated"),
        help="a simpler camera instead; thick, paraxial and image-based are made from the lens, calibrated from --calibration",
    )
    p.add_argument(
        "--calibration",
        metavar="FILE",
        help="of a real camera, by OpenCV, ROS, COLMAP, Kalibr, Basalt, NVIDIA or 3DEqualizer, an ST map (.exr), a lensfun database (.xml, or a "
        "folder), or the word lensfun for the installed one: --camera calibrated",
    )
    p.add_argument(
        "--calibration-camera",
        metavar="NAME",
        help="the camera in that file, where there are several, or the lens in a lensfun database",
    )
    p.add_argument(
        "--calibration-body",
        metavar="NAME",
        help="camera body in a lensfun database, for its sensor; default: the scene's sensor",
    )
    p.set_defaults(usage_error=p.error)
    p.add_argument("--focal-length", type=types.positive, metavar="MM", help="scale the lens to this focal length")
    group = p.add_mutually_exclusive_group()
    opening = [
        group.add_argument("--f-number", type=types.positive, metavar="N", help="default: as the file has it"),
        group.add_argument(
            "--pupil-diameter", type=types.positive, metavar="MM", help="of the entrance pupil, as of an eye's"
        ),
    ]
    # Options that are properties of Blender's camera, under the names of these: they need no further line.
    own = [
        *opening,
        p.add_argument(
            "--blades", type=int, metavar="N", help=f"blades of the diaphragm, 3 to {MOST_BLADES}; 0 is round"
        ),
        p.add_argument(
            "--blade-curvature", type=types.part, metavar="C", help="of the blades' edges: 0 straight, 1 round"
        ),
        p.add_argument(
            "--blade-rotation", type=types.degrees, metavar="DEG", help="turn of the diaphragm about the axis"
        ),
        p.add_argument("--tilt", type=types.degrees, metavar="DEG", help="turn of the film about its horizontal axis"),
        p.add_argument("--swing", type=types.degrees, metavar="DEG", help="turn of the film about its vertical axis"),
    ]
    p.set_defaults(opening=[one.dest for one in opening], properties=[one.dest for one in own])
    p.add_argument("--shutter", type=types.positive, metavar="S", help="expose physically, so many seconds")
    p.add_argument("--iso", type=types.positive, metavar="N", help="expose physically, with a film of that speed")
    p.add_argument(
        "--sensor", metavar="SENSOR", help=f"a sensor sees the picture: a sensor's file, or one of {', '.join(SENSORS)}"
    )
    p.add_argument("--aperture-mask", metavar="FILE", help="a square picture of the opening, instead of blades")
    p.add_argument(
        "--coating", choices=("as-file", "none", "mgf2", "double", "triple"), help="wherever the lens's glass meets air"
    )
    p.add_argument(
        "--white-balance",
        choices=("on", "off"),
        help="off: the colour of glass and coatings is seen in the middle, too",
    )
    p.add_argument(
        "--expose-by", choices=("t-number", "f-number"), help="f-number: what the lens takes makes the picture darker"
    )
    p.add_argument(
        "--film",
        type=types.film,
        metavar="NAME|WxH|lens",
        help=f"mm; lens: the film for which the lens is made; or one of {types.FILM_NAMES}",
    )
    p.add_argument("--film-diagonal", type=types.positive, metavar="MM", help="the film scaled to it, its shape kept")
    p.add_argument("--focus-distance", type=types.distance, metavar="MM|inf", help="from the anchor")
    p.add_argument("--focus-object", metavar="NAME", help="an object of the scene whose origin is to be sharp")
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
        type=types.place,
        metavar="X,Y",
        help="on what the picture shows there; 0,0 is lower left, 1,1 upper right",
    )
    p.add_argument(
        "--sharp",
        type=types.point,
        nargs=3,
        metavar="X,Y,Z",
        help="turn the film so that three points of the world are sharp",
    )
    p.add_argument("--shift", type=types.pair, metavar="X,Y", help="the lens right and up against the film, mm")
    p.add_argument(
        "--scale", type=types.triple, metavar="X,Y,Z", help="millimetres for one Blender unit along each axis"
    )
    p.add_argument(
        "--spectrum", type=types.wavelengths, metavar="visible|rgb|NM", help="all wavelengths, three, or one"
    )
    p.add_argument(
        "--precision",
        choices=("auto", "f32", "f64"),
        help="of rays on their way out of the lens; auto: f32 where it moves none by more than 0.01 pixel",
    )
    p.add_argument("--pipeline", choices=("film", "scene", "hero"), help="default: hero where the glass disperses")
    p.add_argument(
        "--integrator", choices=("path", "bdpt"), help="bdpt: from the lights, too; default: as the scene has it"
    )
    p.add_argument(
        "--light-tracing",
        choices=("on", "off"),
        help="trace small lights far out of focus from the light to the lens, where that is worth it; default: as the scene has it",
    )
    p.add_argument("--effect", action="append", default=[], type=types.effect, metavar="NAME=auto|on|off")
    p.add_argument(
        "--quality", type=types.quality, metavar="Q", help="1 leaves out what is below half a pixel; 2, a quarter"
    )
    p.add_argument(
        "--ghost-reflections", type=int, choices=(2, 4), help="of a ghost's path, at most; default: as the scene has it"
    )
    p.add_argument("--resolution", type=types.pixels, metavar="WxH")
    p.add_argument("--frame", type=types.frame, metavar="N")
    p.add_argument("--threads", type=types.natural, metavar="N", help="0: one for each core")
    p.add_argument("--blender", metavar="PATH", help="run in this Blender rather than in bpy")


def checked(a: argparse.Namespace) -> dict[str, Any]:
    """All options of the command by their names, as JSON can have them, checked as far as they can be without Blender. Angles are in radians."""
    is_lensfun = a.calibration == INSTALLED_LENSFUN
    for file in filter(None, (a.scene, a.lens, a.aperture_mask, None if is_lensfun else a.calibration)):
        check_name(file)
    scene = Path(a.scene)
    if not scene.is_file():
        raise CommandError(f"no such scene: {scene}: name a .blend file")
    if a.calibration and (a.lens or a.camera not in {None, "calibrated"}):
        a.usage_error("--calibration is a camera of its own: leave out --lens and other models of --camera")
    if a.calibration and not is_lensfun and not Path(a.calibration).exists():
        raise CommandError(f"no such calibration: {a.calibration}: change --calibration")
    if a.lens and a.camera in {"pinhole", "thin", "calibrated"}:
        a.usage_error(f"--camera {a.camera} has no lens: leave out the one or the other")
    if a.pupil_diameter is not None and (a.calibration or a.camera in {"pinhole", "thin", "calibrated"}):
        kind = a.camera or "calibrated"
        a.usage_error(f"--pupil-diameter is a lens's, and --camera {kind} has none: leave out the one or the other")
    if a.blades is not None and a.blades != 0 and not 3 <= a.blades <= MOST_BLADES:
        raise CommandError(
            f"{a.blades} blades: a diaphragm has 3 to {MOST_BLADES}, or 0 for a round one: change --blades"
        )
    if a.aperture_mask and a.blades:
        a.usage_error("--aperture-mask stands instead of --blades: leave out the one or the other")
    if a.aperture_mask and not Path(a.aperture_mask).is_file():
        raise CommandError(f"no such picture: {a.aperture_mask}: change --aperture-mask")
    ways = {
        "--focus-distance": a.focus_distance,
        "--focus-object": a.focus_object,
        "--autofocus": a.autofocus,
        "--sharp": a.sharp,
    }
    if len(asked := [name for name, value in ways.items() if value is not None]) > 1:
        a.usage_error(
            f"{', '.join(asked[:-1])} and {asked[-1]} say different things of the focus: leave out all but one"
        )
    if a.sharp and (a.tilt is not None or a.swing is not None):
        a.usage_error("--sharp finds tilt and swing: leave out --tilt and --swing")
    given = {name: value for name, value in vars(a).items() if name not in _NO_OPTIONS}
    return given | {
        "scene": str(scene.absolute()),
        "lens": str(find_lens(a.lens).absolute()) if a.lens else None,
        "aperture_mask": str(Path(a.aperture_mask).absolute()) if a.aperture_mask else None,
        "calibration": str(Path(a.calibration).absolute()) if a.calibration and not is_lensfun else a.calibration,
        "sensor": _checked_sensor(a.sensor) if a.sensor else None,
        # JSON has no infinity.
        "focus_distance": "inf" if a.focus_distance == math.inf else a.focus_distance,
        "effects": dict(a.effect),
    }


def _checked_sensor(name: str) -> str:
    """A sensor as Blender's half takes it. Raises the engine's error where there is none."""
    from . import _native

    check_name(name)
    _native.check_exposure(name, {})
    return str(Path(name).absolute()) if Path(name).is_file() and name not in SENSORS else name


def check_name(file: str | Path) -> None:
    """Raises `CommandError` where Blender cannot be told the name of a file."""
    try:
        str(file).encode("utf-8")
    except UnicodeEncodeError:
        raise CommandError(
            f"{ascii(str(file))}: its name is no UTF-8, which Blender needs: name another file"
        ) from None


def check_writable(file: Path) -> None:
    """Raises `CommandError` where a file cannot be written: before the work, not after it."""
    from . import _native

    if not file.absolute().parent.is_dir():
        raise CommandError(f"no such folder: {file.parent}: make it first")
    try:
        _native.check_replaceable(file)
    except OSError as error:
        raise CommandError(f"cannot write {file}: {error.strerror or error}: name another file") from None


def check_apart(written: Mapping[str, Path | None], read: Mapping[str, str | Path | None]) -> None:
    """Raises `CommandError` where a file that is written is one of those that are read, or is written twice. Keys are the files'
    names in the message."""
    files = [(name, os.path.realpath(file)) for name, file in [*read.items(), *written.items()] if file]
    for i, (name, file) in enumerate(files):
        for other, same in files[:i]:
            if file == same and name in written:
                raise CommandError(f"{name} {file}: it is the file of {other}, too: name another file")


def study(blender: str | None, options: dict[str, Any], tell: Callable[[dict[str, Any], TextIO, TextIO], None]) -> int:
    """Runs the study in the options where Blender is, and told by `tell(found, stdout, stderr)`, if something was found;
    the exit status. Without a Blender that is named, the process ends here."""
    # Blender says what it likes on stdout: that is kept for the answer.
    own_stdout, voice = os.dup(1), os.dup(2)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    with tempfile.TemporaryDirectory() as folder:
        answer = Path(folder) / "answer.json"
        options = options | {"answer": str(answer)}
        if blender:
            status = in_blender(blender, options)
        else:
            interrupts.listen()
            from .render_in_blender import render

            status = render(options)
        # What goes wrong from here on is to be seen.
        os.dup2(voice, 2)
        with os.fdopen(own_stdout, "w", encoding="utf-8") as out, os.fdopen(voice, "w", errors="replace") as says:
            if answer.exists():
                tell(json.loads(answer.read_text(encoding="utf-8")), out, says)
    if not blender:
        from .render_in_blender import finish

        # bpy with a render engine hangs or crashes when Python ends by itself.
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115
        finish(status)
    return status


def in_blender(program: str, options: dict[str, Any]) -> int:
    """Runs the same inside of a Blender program; Ctrl-C is handed on, and its picture waited for."""
    runner = Path(__file__).with_name("render_in_blender.py")
    # Blender may complain on its stderr as it likes: that goes to stdout, and Petzval's own words come through a pipe
    # of their own.
    voice = os.dup(2)
    ready, tell_ready = os.pipe()
    handed_down, (its_voice, its_ready) = processes.handed_down(voice, tell_ready)
    handed_over = {**options, "package_parent": str(Path(__file__).resolve().parent.parent), "stderr_fd": its_voice,
                   "ready_fd": its_ready}  # fmt: skip
    command = [program, "-b", "--factory-startup", "--disable-autoexec", "--python-exit-code", "3"]
    command += ["--python", str(runner), "--", json.dumps(handed_over)]
    child: subprocess.Popen[bytes] | None = None
    asked: list[int] = []
    is_ended = False

    def hand_on(number: int, _frame: object) -> None:
        nonlocal is_ended
        asked.append(number)
        if child is None:
            return
        # Until it is ready Blender itself hears the signal, and may ignore it.
        if processes.has_byte(ready):
            processes.signal_group(child, number)
        else:
            is_ended = True
            processes.end_group(child)

    for number in interrupts.SIGNALS:
        signal.signal(number, hand_on)
    try:
        # A group of its own: the terminal's Ctrl-C comes here alone, and goes on to all that the program started.
        child = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stderr=subprocess.STDOUT, **handed_down, **processes.own_group()
        )
    except OSError as error:
        raise CommandError(f"cannot start {program}: {error.strerror}: give --blender a Blender program") from None
    if asked:
        hand_on(asked[-1], None)
    status = processes.wait(child)
    if status in _OWN_STATUS:
        return _OWN_STATUS[status]
    if is_ended:
        raise CommandError("broken off before the first sample: nothing was written", INTERRUPTED)
    raise CommandError(f"{program} ended with status {status}: it does not run, or crashed: see what it said above")
