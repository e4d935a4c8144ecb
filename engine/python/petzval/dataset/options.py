# SPDX-License-Identifier: GPL-3.0-or-later
"""Options of `petzval render` as keys of a TOML table, read by the command line's own parser."""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import Any, NoReturn

from .. import render_command, scene_options
from ..errors import CommandError
from .tables import Table

#: The options that decide how a picture is rendered, for all cameras.
OF_RENDER = (
    "resolution", "samples", "noise-threshold", "min-samples", "time-limit", "seed", "denoise", "blue-noise", "threads",
    "pipeline", "integrator", "light-tracing", "effect", "quality", "ghost-reflections",
)  # fmt: skip
#: The options of one camera. Its focus must not depend on the picture, so that the intrinsic parameters do not.
OF_CAMERA = (
    "lens", "camera", "focal-length", "f-number", "pupil-diameter", "blades", "blade-curvature", "blade-rotation", "tilt", "swing",
    "shutter", "iso", "aperture-mask", "coating", "white-balance", "expose-by", "film", "film-diagonal", "focus-distance",
    "focus-object", "anchor", "focus-relation", "shift", "scale", "spectrum", "precision",
)  # fmt: skip
#: The options whose lists are written with another separator than a comma.
_SEPARATORS = {"resolution": "x", "film": "x"}
_FILES = ("lens", "aperture-mask")


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise _Refused(message)


class _Refused(Exception):
    pass


def words_of(table: Table, names: tuple[str, ...], folder: Path) -> dict[str, list[str]]:
    """The options that a table has among its keys, as words of a command line. Files are looked for beside the specification first."""
    found: dict[str, list[str]] = {}
    for name in names:
        value = table.take(name)
        if value is None:
            continue
        if isinstance(value, bool):
            value = "on" if value else "off"
        if isinstance(value, list) and name != "effect":
            value = _SEPARATORS.get(name, ",").join(map(str, value))
        values = value if isinstance(value, list) else [value]
        if not all(isinstance(one, str | int | float) for one in values):
            raise table.wrong("must be a text, a number or a list of them, as the option of petzval render", name)
        if name in _FILES and (folder / str(value)).is_file():
            values = [str(folder / str(value))]
        # A value of its own word could be taken for an option.
        found[name] = [f"--{name}={one}" for one in values]
    return found


def checked(scene: Path, words: dict[str, list[str]], table: Table) -> dict[str, Any]:
    """The options as plain data, as `scene_options.checked` gives them. Raises `CommandError` that names the key."""
    parser = _Parser(prog="petzval dataset", allow_abbrev=False)
    scene_options.add(parser)
    render_command.add_options(parser)
    try:
        arguments = parser.parse_args([str(scene), *(word for several in words.values() for word in several)])
        return scene_options.checked(arguments)
    except _Refused as refused:
        found = re.match(r"argument (?:--[\w-]+/)?--([\w-]+)(?:/--[\w-]+)*: (.*)", str(refused))
        raise table.wrong(found[2] if found else str(refused), found[1] if found else None) from None
    except CommandError as error:
        raise table.wrong(str(error)) from None
