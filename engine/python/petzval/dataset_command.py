# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval dataset SPEC.toml`: pictures with ground truth. Reads arguments; the package `dataset` does the work."""

from __future__ import annotations

import argparse
from pathlib import Path

from . import interrupts, scene_options
from .errors import CommandError


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `dataset`."""
    p = subparsers.add_parser(
        "dataset",
        help="pictures with depth, normals, masks, flow and camera parameters, for training and measuring other programs",
        allow_abbrev=False,
    )
    p.add_argument("spec", metavar="SPEC.toml", help="what is rendered and written")
    p.add_argument("--dry-run", action="store_true", help="list the pictures, render none")
    p.add_argument("--again", action="store_true", help="also those that are there")
    p.add_argument("--blender", metavar="PATH", help="run in this Blender rather than in bpy")


def run(a: argparse.Namespace) -> int:
    """Renders the missing pictures; returns the exit status."""
    from .dataset import spec

    scene_options.check_name(a.spec)
    read = spec.read(Path(a.spec).absolute())
    if read.output.exists() and not read.output.is_dir():
        raise CommandError(f"{read.output} is no folder: change output")
    if not a.dry_run:
        try:
            read.output.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise CommandError(f"cannot make {read.output}: {error.strerror or error}: change output") from None
        scene_options.check_writable(read.output / "cameras.json")
    options = {
        "scene": str(read.scene.absolute()),
        "dataset": {"spec": str(Path(a.spec).absolute()), "again": a.again, "dry_run": a.dry_run},
    }
    if a.blender:
        return scene_options.in_blender(a.blender, options)
    interrupts.listen()
    from .render_in_blender import finish, render

    # bpy with a render engine hangs or crashes when Python ends by itself.
    finish(render(options))
    return interrupts.INTERRUPTED
