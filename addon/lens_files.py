# SPDX-License-Identifier: GPL-3.0-or-later
"""Which file a camera's lens is: its own path, or a lens that comes with Petzval."""

from __future__ import annotations

from typing import Any

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


def file_name(entry: dict[str, Any]) -> str:
    """What a camera's settings say for a lens of the library."""
    return f"{entry['id']}.lens"


def shipped() -> list[dict[str, Any]]:
    """The lenses that come with Petzval, as `petzval.lens_library` has them. Raises `EngineMissing`."""
    from .native import engine

    engine()
    from petzval import lens_library

    return lens_library.entries()


def groups() -> list[str]:
    """Their groups, in the order of lists. Raises `EngineMissing`."""
    from .native import engine

    return engine().lens_groups()


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
