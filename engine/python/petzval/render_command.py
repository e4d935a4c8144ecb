# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval render`: a .blend through a lens into a picture."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from . import argument_types as types
from . import interrupts, scene_options
from .errors import CommandError
from .frame_names import numbered
from .sensor_options import RAW_ENDINGS, check_raw

_SUFFIXES = {".exr", ".png"}


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `render`."""
    p = subparsers.add_parser("render", help="render a .blend through a lens", allow_abbrev=False)
    scene_options.add(p)
    add_options(p)
    p.add_argument(
        "--checkpoint",
        metavar="FILE|off",
        help="where the render is kept while it goes on, to be taken up by the same command; default: OUT.checkpoint",
    )
    p.add_argument(
        "--checkpoint-every",
        type=types.positive,
        default=None,
        metavar="S",
        help="seconds; default: 8, and the writing",
    )
    add_frames(p)
    p.add_argument("-o", "--output", metavar="OUT.exr|png", help="default: SCENE.png where you are")
    p.add_argument(
        "--raw",
        metavar=f"RAW{'|'.join(RAW_ENDINGS)}",
        help="what the --sensor says of the picture, at --iso and --shutter if they are given",
    )
    p.add_argument("--stats", metavar="STATS.json", help="write what was done, and what it took")


def add_options(p: argparse.ArgumentParser) -> None:
    """Adds the options that decide the picture beside the scene's: samples, noise, passes."""
    p.add_argument(
        "--samples",
        type=types.count,
        metavar="N",
        help="paths for each pixel, exactly; with --noise-threshold, at most",
    )
    p.add_argument(
        "--noise-threshold",
        type=types.threshold,
        metavar="E",
        help="stop where a pixel's error, relative to the root of its brightness, is below it: 0.01; 0: never",
    )
    p.add_argument("--min-samples", type=types.natural, metavar="N", help="before the error is first looked at; 0: 16")
    p.add_argument(
        "--time-limit",
        type=types.positive,
        metavar="S",
        help="end after so many seconds of rendering with what is there",
    )
    p.add_argument("--seed", type=types.natural, metavar="N")
    p.add_argument(
        "--denoise",
        choices=("off", "fast", "balanced", "high"),
        help="by Open Image Denoise, once the samples are there",
    )
    p.add_argument(
        "--blue-noise",
        choices=("on", "off"),
        help="errors of neighbouring pixels cancel; off with --sample-offset, --mergeable and --noise-threshold",
    )
    p.add_argument("--sample-offset", type=types.natural, metavar="N", help="number of the first sample")
    p.add_argument(
        "--mergeable",
        action="store_true",
        help="an EXR with all that `petzval merge` needs to join it with others exactly",
    )
    p.add_argument(
        "--passes",
        action="store_true",
        help="an EXR of many layers: all passes that the scene's view layers ask for, as Blender names them",
    )


def add_frames(p: argparse.ArgumentParser) -> None:
    """Adds the frames of an animation."""
    p.add_argument(
        "--frames",
        type=types.frames,
        metavar="FIRST-LAST[,STEP]",
        help="an animation, a picture a frame; their numbers stand in the names of --output and --stats for ####, else at the end",
    )


def run(arguments: argparse.Namespace) -> int:
    """Renders; the exit status."""
    options = options_of(arguments)
    if arguments.blender:
        return scene_options.in_blender(arguments.blender, options)
    interrupts.listen()
    from .render_in_blender import finish, render

    # bpy with a render engine hangs or crashes when Python ends by itself.
    finish(render(options))
    return interrupts.INTERRUPTED


def options_of(a: argparse.Namespace) -> dict[str, Any]:
    """The options as plain data, checked, as `render_in_blender.render` takes them."""
    options = scene_options.checked(a)
    output = Path(a.output) if a.output else Path(f"{Path(a.scene).stem}.png")
    check_picture(a, output)
    if a.raw:
        if not a.sensor:
            a.usage_error("--raw is what a sensor says: name one with --sensor")
        check_raw(Path(a.raw))
    takes = [_take(a, options, output, frame) for frame in a.frames or [None]]
    return options | {"takes": takes}


def check_picture(a: argparse.Namespace, output: Path) -> None:
    """Raises `CommandError` where a picture of that name cannot hold the passes that are asked for."""
    if output.suffix.lower() not in _SUFFIXES:
        raise CommandError(f"unknown picture format: {output}: end its name in .exr or .png")
    for name in ("mergeable", "passes"):
        if getattr(a, name) and output.suffix.lower() != ".exr":
            raise CommandError(f"--{name} needs an EXR: {output}: end its name in .exr")
    scene_options.check_name(output)
    if a.frames and a.frame is not None:
        a.usage_error("--frame is one of --frames: leave out the one or the other")


def _take(a: argparse.Namespace, options: dict[str, Any], output: Path, frame: int | None) -> dict[str, Any]:
    """One picture: its frame, if it is one of several, and the files that are written, checked."""
    if frame is not None:
        output = numbered(output, frame)
    checkpoint: Path | None = None
    if a.checkpoint != "off":
        checkpoint = Path(a.checkpoint) if a.checkpoint else Path(f"{output}.checkpoint")
        if frame is not None and a.checkpoint:
            checkpoint = numbered(checkpoint, frame)
    stats = Path(a.stats) if a.stats else None
    if stats is not None and frame is not None:
        stats = numbered(stats, frame)
    raw = Path(a.raw) if a.raw else None
    if raw is not None and frame is not None:
        raw = numbered(raw, frame)
    written = {"--output": output, "--stats": stats, "--checkpoint": checkpoint, "--raw": raw}
    scene_options.check_apart(
        written,
        {
            "the scene": a.scene,
            "--lens": options["lens"],
            "--aperture-mask": a.aperture_mask,
            "--calibration": a.calibration,
            "--sensor": a.sensor if a.sensor and Path(a.sensor).is_file() else None,
        },
    )
    if checkpoint is not None and (problem := _checkpoint_problem(checkpoint)):
        raise CommandError(f"--checkpoint {checkpoint}: {problem}")
    for file in filter(None, written.values()):
        scene_options.check_writable(file)
    return {
        "frame": a.frame if frame is None else frame,
        "output": str(output.absolute()),
        "stats": str(stats.absolute()) if stats else None,
        "raw": str(raw.absolute()) if raw else None,
        "checkpoint": str(checkpoint.absolute()) if checkpoint else "",
    }


def _checkpoint_problem(file: Path) -> str | None:
    from . import _native

    return _native.checkpoint_problem(file)
