# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval merge`: renders of one picture with other samples become one, each pixel by its number of samples."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from .errors import CommandError
from .scene_options import check_writable


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `merge`."""
    p = subparsers.add_parser(
        "merge",
        help="join renders of one picture with other samples",
        description="Joins pictures of one scene, rendered with other samples (--sample-offset, or another --seed): each pixel by "
        "how many it has. Rendered with --mergeable, they come to the picture of one render with all the samples, to the bit.",
        allow_abbrev=False,
    )
    p.add_argument("pictures", metavar="A.exr", nargs="+")
    p.add_argument("-o", "--output", metavar="OUT.exr", required=True)
    p.add_argument("--json", action="store_true", help="one JSON object on stdout")


def run(arguments: argparse.Namespace) -> int:
    """Joins; the exit status."""
    from . import _native

    output = Path(arguments.output)
    if output.suffix.lower() != ".exr":
        raise CommandError(f"unknown picture format: {output}: end its name in .exr")
    check_writable(output)
    try:
        merged = json.loads(_native.merge_pictures_json(arguments.pictures, str(output)))
    except _native.PetzvalError as error:
        raise CommandError(str(error)) from None
    if arguments.json:
        print(json.dumps(merged))
    else:
        how = "as one render would have it" if merged["is_exact"] else "to the rounding of its numbers"
        print(f"{output}: {merged['samples']:g} samples a pixel, {how}")
    return 0
