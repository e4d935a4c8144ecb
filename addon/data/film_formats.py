# SPDX-License-Identifier: GPL-3.0-or-later
"""The film formats that the package knows, as Blender's menus want them. No bpy."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from petzval.film_formats import FilmFormat


def items() -> list[tuple[str, str, str]]:
    """Name, title and tooltip of each format, small to large."""
    from petzval.film_formats import FILM_FORMATS

    return [
        (film.name, film.title, f"{film.width_mm:g} x {film.height_mm:g} mm ({film.source})") for film in FILM_FORMATS
    ]


def size_mm(name: str) -> tuple[float, float]:
    """Width and height of the format of that name."""
    from petzval.film_formats import by_name

    film = by_name(name)
    return film.width_mm, film.height_mm


def of_size(width_mm: float, height_mm: float) -> FilmFormat | None:
    """The format with these sides; `None` without the package, too."""
    try:
        from petzval.film_formats import of_size as found
    except ImportError:
        return None
    return found(width_mm, height_mm)
