# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval cost`: the cost of each step from the pinhole to the full lens in this picture, and the error that it removes.

All cameras render in one process, in rounds; it ends when the interval of every camera's median time over the pinhole's is
narrower than 3 %, when the time given is over, or after the rounds asked for (`cost/runs.py`). Ctrl-C ends it too, and
the results so far are written, if there were two rounds at least.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any, TextIO

from . import argument_types as types
from . import scene_options
from .errors import CommandError

_PICTURES = ("costs.png", "costs.svg")


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `cost`."""
    p = subparsers.add_parser("cost", help="measure what accuracy costs", allow_abbrev=False)
    scene_options.add(p)
    p.add_argument("-o", "--output", metavar="DIR", required=True, help="a folder for costs.json, .md, .png and .svg")
    p.add_argument(
        "--samples", type=types.count, metavar="N", help="paths for each pixel of the picture whose price is told"
    )
    p.add_argument("--rounds", type=_rounds, default=0, metavar="N|auto", help="default: until the times have settled")
    p.add_argument("--seconds", type=types.positive, default=120.0, metavar="T", help="at most, about; default: 120")
    p.add_argument("--json", action="store_true", help="costs.json on stdout, too, and nothing else")


def _rounds(text: str) -> int:
    if text == "auto":
        return 0
    value = types.count(text)
    if value < 4:
        raise argparse.ArgumentTypeError(f"must be auto, or at least 4: {text}")
    return value


_rounds.__name__ = "number"


def run(arguments: argparse.Namespace) -> int:
    """Measures; the exit status."""
    options = scene_options.checked(arguments)
    if arguments.camera:
        arguments.usage_error("--camera: all of them are measured; leave it out, and name a lens with --lens")
    folder = Path(arguments.output)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CommandError(f"cannot make {folder}: {error.strerror}: name another folder") from None
    for name in ("costs.json", "costs.md", *_PICTURES):
        scene_options.check_writable(folder / name)
    cost = {"what": "cost", "rounds": arguments.rounds, "seconds": arguments.seconds}
    options |= {"samples": arguments.samples, "study": cost}

    def tell(found: dict[str, Any], out: TextIO, voice: TextIO) -> None:
        found = {"scene": Path(arguments.scene).stem} | found
        text = _write(found, folder, voice)
        print(json.dumps(found, indent=1) if arguments.json else text, file=out)

    return scene_options.study(arguments.blender, options, tell)


def _write(found: dict[str, Any], folder: Path, says: TextIO) -> str:
    """Writes all files; returns the text for a terminal."""
    from . import atomic_files
    from .cost import advice, tables

    found["advice"] = advice.advice(found)
    atomic_files.write_json(folder / "costs.json", found, indent=1)
    has_pictures = _draw(found, folder, says)
    page = tables.markdown(found, picture="costs.png" if has_pictures else None)
    atomic_files.write_text(folder / "costs.md", page)
    return page


def _draw(found: dict[str, Any], folder: Path, says: TextIO) -> bool:
    try:
        import matplotlib  # noqa: F401
    except ImportError as error:
        said = f"petzval: no {' and '.join(_PICTURES)}: matplotlib cannot be had ({error}): pip install matplotlib"
        print(said, file=says)
        return False
    from .cost import plot

    plot.draw(found, [folder / name for name in _PICTURES])
    return True
