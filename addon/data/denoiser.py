# SPDX-License-Identifier: GPL-3.0-or-later
"""Where Open Image Denoise lies: Blender ships it beside itself, PyPI has it as `pyoidn`."""

from __future__ import annotations

import ctypes.util
import functools
import importlib.util
import sys
from collections.abc import Iterator
from pathlib import Path

import bpy

#: The library's file, by system. Linux's has the major version in its name: another major has another interface.
NAMES = {"linux": "libOpenImageDenoise.so.2", "darwin": "libOpenImageDenoise.dylib", "win32": "OpenImageDenoise.dll"}
#: A line for who has none.
INSTALL = "Open Image Denoise was not found beside Blender: install it for Petzval by `pip install pyoidn`, or denoise in the compositor"


@functools.cache
def library() -> Path | None:
    """The library's file, as it was found first; None: there is none."""
    name = NAMES.get(sys.platform)
    if name is None:
        return None
    found = (folder / name for folder in _folders() if (folder / name).is_file())
    return next(found, None) or _of_the_system()


def _folders() -> Iterator[Path]:
    """Folders in which it may lie, the likeliest first."""
    # Beside the folder of Blender's own scripts, of the program and of the module alike: in `lib` on Linux and macOS; on Windows in
    # `blender.shared` of the program, and with the module itself.
    local = _local()
    if local:
        home = Path(local).parent
        yield from (home / "lib", home / "blender.shared", home)
    package = importlib.util.find_spec("pyoidn")
    for place in (package.submodule_search_locations or ()) if package else ():
        yield from (Path(place) / "oidn" / "lib", Path(place) / "oidn" / "bin")


def _local() -> str:
    """The folder of the scripts that this Blender has of its own; empty: it has none."""
    return bpy.utils.resource_path("LOCAL")


def _of_the_system() -> Path | None:
    """The library that the system's linker finds, as Debian's package installs it."""
    name = ctypes.util.find_library("OpenImageDenoise")
    return Path(name) if name else None
