# SPDX-License-Identifier: GPL-3.0-or-later
"""Which file a camera's lens is: its own path, or a lens that comes with Petzval."""

from __future__ import annotations

from pathlib import Path

import bpy


class LensMissing(Exception):
    """The message is one line for the user."""


def resolve(lens_file: str, library: bpy.types.Library | None = None) -> str:
    """The path of a camera's lens file. Raises `LensMissing`."""
    from petzval.errors import CommandError
    from petzval.places import find_lens

    if not lens_file.strip():
        raise LensMissing("no lens file: choose one in the camera's Lens panel")
    path = bpy.path.abspath(lens_file, library=library)
    try:
        return str(find_lens(path))
    except CommandError as error:
        raise LensMissing(str(error)) from None


def shipped() -> list[Path]:
    """The lenses that come with Petzval, by name."""
    from petzval.places import lenses_folder

    return sorted(lenses_folder().glob("*.lens"))


def title(path: Path) -> str:
    """What a lens file calls itself; its file's name where it does not say."""
    try:
        with path.open(encoding="utf-8", errors="replace") as lines:
            for line in lines:
                key, found, value = line.partition(":")
                if found and key.strip(" #").lower() == "name":
                    return value.strip()
                if not line.startswith("#"):
                    break
    except OSError:
        pass
    return path.stem
