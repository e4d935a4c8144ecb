# SPDX-License-Identifier: GPL-3.0-or-later
"""The search for Open Image Denoise: Blender ships it beside itself, PyPI has it as `pyoidn`. No bpy."""

from __future__ import annotations

import ctypes.util
import importlib.util
import sys
from collections.abc import Iterator
from pathlib import Path

#: The library's file, by system. Linux's has the major version in its name: another major has another interface.
NAMES = {"linux": "libOpenImageDenoise.so.2", "darwin": "libOpenImageDenoise.dylib", "win32": "OpenImageDenoise.dll"}


def find(homes: Iterator[Path] | list[Path]) -> Path | None:
    """The library's file: of one of these Blenders, each named by the folder of its scripts and libraries, else of `pyoidn` or the
    system; None: there is none."""
    name = NAMES.get(sys.platform)
    if name is None:
        return None
    for folder in _folders(homes):
        if (folder / name).is_file():
            return folder / name
    # Where the system's linker finds it, as Debian's package installs it.
    found = ctypes.util.find_library("OpenImageDenoise")
    return Path(found) if found else None


def _folders(homes: Iterator[Path] | list[Path]) -> Iterator[Path]:
    # In `lib` on Linux and macOS; on Windows in `blender.shared` of the program, and with the module itself.
    for home in homes:
        yield from (home / "lib", home / "blender.shared", home)
    package = importlib.util.find_spec("pyoidn")
    for place in (package.submodule_search_locations or ()) if package else ():
        yield from (Path(place) / "oidn" / "lib", Path(place) / "oidn" / "bin")
