# SPDX-License-Identifier: GPL-3.0-or-later
"""The path of a camera's lens file: its own path, or a lens that comes with Petzval."""

from __future__ import annotations

from typing import Any

import bpy


class LensMissing(Exception):
    """The error of a lens file that is not there; one line for the user."""


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


def file_name(entry: dict[str, Any]) -> str:
    """The name of the file of a lens of the library, as a camera's settings keep it."""
    return f"{entry['id']}.lens"


def shipped() -> list[dict[str, Any]]:
    """The lenses that come with Petzval, as `petzval.lens_library` has them. Raises `EngineMissing`."""
    from ..native import engine

    engine()
    from petzval import lens_library

    return lens_library.entries()


def entry_of(lens_key: str) -> dict[str, Any] | None:
    """The library's entry of a lens by its file's name; None of another file. Raises `EngineMissing`."""
    return next((entry for entry in shipped() if file_name(entry) == lens_key), None)


def groups() -> list[str]:
    """The groups of the library's lenses, in the order of lists. Raises `EngineMissing`."""
    from ..native import engine

    return engine().lens_groups()


def in_short(entry: dict[str, Any]) -> str:
    """Group, focal length and f-number of a lens, for the search."""
    from petzval import lens_library

    focal, f_number = lens_library.focal_text(entry), lens_library.f_number_text(entry)
    return f"{entry['group'] or 'lens'}, {focal} mm, f/{f_number}"


def is_meant(entry: dict[str, Any], words: str) -> bool:
    """True if each of the words is found in the lens's name, group, design, focal length or f-number."""
    text = f"{entry['name']} {entry['id']} {entry['design'] or ''} {in_short(entry)}".casefold()
    # "50mm" as "50 mm".
    return all(word in text or word in text.replace(" ", "") for word in words.casefold().split())


def description(entry: dict[str, Any]) -> str:
    """One line on a lens for a tooltip."""
    from petzval import lens_library

    facts = [entry["group"] or "lens", f"{lens_library.focal_text(entry)} mm", f"F/{lens_library.f_number_text(entry)}"]
    facts.append(f"sees {lens_library.field_text(entry)}°")
    film = lens_library.film_text(entry)
    if film:
        facts.append(f"covers {film} mm")
    if entry["focuses_inside"]:
        facts.append("focuses inside")
    text = ", ".join(facts)
    return text[0].upper() + text[1:]
