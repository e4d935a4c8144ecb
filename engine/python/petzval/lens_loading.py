# SPDX-License-Identifier: GPL-3.0-or-later
"""Lenses that a command asks for, and what there is to say of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .errors import complain
from .places import find_lens


def load(name_or_path: str) -> Any:
    from . import _native

    return _native.Lens(str(find_lens(name_or_path)))


#: What the eye sees, nm: for this the index of a lens's glasses should be known.
VISIBLE_NM = (380.0, 780.0)


def beyond(lens: Any, wavelengths_nm: Sequence[float]) -> list[str]:
    """The glasses that are asked for an index beyond what is known of them."""
    known = lens.media_beyond(min(wavelengths_nm), max(wavelengths_nm)) if wavelengths_nm else []
    return [
        f"glass {name}: its index is known from {start:.0f} to {end:.0f} nm, beyond it is kept as at the end"
        for name, start, end in known
    ]


def say(notes: list[str]) -> None:
    for note in notes:
        complain(f"note: {note}")
