# SPDX-License-Identifier: GPL-3.0-or-later
"""The lenses that a command asks for, and the remarks on them."""

from __future__ import annotations

from typing import Any

from .errors import complain
from .places import find_lens


def load(name_or_path: str) -> Any:
    from . import _native

    return _native.Lens(str(find_lens(name_or_path)))


def say(notes: list[str]) -> None:
    for note in notes:
        complain(f"note: {note}")
