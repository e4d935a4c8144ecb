# SPDX-License-Identifier: GPL-3.0-or-later
"""The lenses that come with Petzval, by their purpose."""

from __future__ import annotations

import functools
import json
from pathlib import Path
from typing import Any

from .places import lenses_folder


def groups() -> list[str]:
    """The groups, in the order of lists."""
    from . import _native

    return _native.lens_groups()


@functools.cache
def _entries(folder: Path) -> tuple[dict[str, Any], ...]:
    from . import _native

    order = {group: place for place, group in enumerate(groups())}
    found = [{"id": path.stem, **json.loads(_native.Lens(str(path)).summary_json())} for path in folder.glob("*.lens")]

    def place(entry: dict[str, Any]) -> tuple[Any, ...]:
        focal_mm = entry["focal_length_mm"]
        return (
            order.get(entry["group"], len(order)),
            not entry["is_first_choice"],
            abs(focal_mm) if focal_mm is not None else float("inf"),
            entry["id"],
        )

    return tuple(sorted(found, key=place))


def entries() -> list[dict[str, Any]]:
    """Every lens: its file's name without ending as `id`, and the engine's summary; by groups, the first choice first, then by
    rising focal length."""
    return list(_entries(lenses_folder()))


def number(value: float | None, digits: int = 5) -> str:
    """A number in so many digits, without an exponent."""
    if value is None:
        return "none"
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e" in text and abs(value) > 1.0 else text


def focal_text(entry: dict[str, Any]) -> str:
    """Focal length in mm, or its range."""
    if entry["zoom_range_mm"]:
        return " to ".join(number(end, 4) for end in entry["zoom_range_mm"])
    return "infinite" if entry["focal_length_mm"] is None else number(entry["focal_length_mm"], 4)


def f_number_text(entry: dict[str, Any]) -> str:
    """F-number wide open."""
    return number(entry["f_number"], 3)


def field_text(entry: dict[str, Any]) -> str:
    """The whole field in degrees."""
    return "unknown" if entry["half_field_deg"] is None else number(2.0 * entry["half_field_deg"], 4)


def film_text(entry: dict[str, Any]) -> str:
    """Width and height in mm of the film that a lens covers."""
    return "" if entry["film_mm"] is None else " x ".join(f"{side:g}" for side in entry["film_mm"])
