# SPDX-License-Identifier: GPL-3.0-or-later
"""The user's favourite lenses: kept beside Blender's own preferences, the same in every file."""

from __future__ import annotations

import json
import os
from pathlib import Path

import bpy

_FILE = "favourite-lenses.json"
_lenses: list[str] = []


def key(lens_file: str, library: bpy.types.Library | None = None) -> str:
    """The key of a lens: the file's name if it comes with Petzval, else its path. Looks at no disk."""
    text = lens_file.strip()
    if not text:
        return ""
    if os.path.basename(text) == text and not text.startswith("//"):
        return f"{text.removesuffix('.lens')}.lens"
    return os.path.normpath(bpy.path.abspath(text, library=library))


def all_of_them() -> list[str]:
    """The keys, the oldest first."""
    return list(_lenses)


def has(lens_key: str) -> bool:
    """True if the lens is a favourite."""
    return lens_key in _lenses


def toggle(lens_key: str) -> bool:
    """Adds a lens to the favourites, or removes it; returns True if it is one now. Raises `OSError` where they cannot be kept."""
    is_one = lens_key not in _lenses
    if is_one:
        _lenses.append(lens_key)
    else:
        _lenses.remove(lens_key)
    folder = bpy.utils.user_resource("CONFIG", path="petzval", create=True)
    if not folder:
        raise OSError("Blender has no folder for its settings")
    place = Path(folder) / _FILE
    from petzval import atomic_files

    atomic_files.write_text(place, json.dumps({"lenses": _lenses}, indent=1, ensure_ascii=False) + "\n")
    return is_one


def load() -> None:
    """Reads the favourites anew; none where the file is not there or is none of ours."""
    _lenses.clear()
    folder = bpy.utils.user_resource("CONFIG", path="petzval")
    try:
        found = json.loads((Path(folder) / _FILE).read_text(encoding="utf-8"))["lenses"]
        _lenses.extend(dict.fromkeys(one for one in found if isinstance(one, str)))
    except (OSError, ValueError, KeyError, TypeError):
        return


def register() -> None:
    load()


def unregister() -> None:
    _lenses.clear()
