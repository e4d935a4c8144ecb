# SPDX-License-Identifier: GPL-3.0-or-later
"""The differences between scene and picture, for the Messages panel: of the last render and of the viewport, once each. No bpy."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import NamedTuple

from . import statistics

# "Object 'Cube': ...", as the export and the engine begin them.
_BEGINS = re.compile(r"(\w+) '(.+?)'(?=[:,\s]|$)")

# More would fill a line.
_MOST_NAMES = 3

#: The viewport's warnings by the scene's name.
_viewport: dict[str, list[str]] = {}


class Message(NamedTuple):
    """A message. `kind` and `name` of its subject, the kind in small letters: "object", "material"; empty: none."""

    text: str
    kind: str
    name: str


def of_text(text: str) -> Message:
    """A message taken apart."""
    found = _BEGINS.match(text)
    return Message(text, found[1].lower(), found[2]) if found else Message(text, "", "")


def grouped(texts: Iterable[str]) -> list[str]:
    """Messages that differ only by the name of their subject, as one: a scene may have hundreds of a kind."""
    names: dict[tuple[str, str], list[str]] = {}
    for text in dict.fromkeys(texts):
        found = _BEGINS.match(text)
        key = (found[1], text[found.end() :]) if found else ("", text)
        names.setdefault(key, []).append(found[2] if found else "")
    return [_of_all(kind, rest, about) if kind else rest for (kind, rest), about in names.items()]


def _of_all(kind: str, rest: str, names: list[str]) -> str:
    shown = ", ".join(f"'{name}'" for name in names[:_MOST_NAMES])
    left = len(names) - _MOST_NAMES
    return f"{kind} {shown}{f' and {left} more' if left > 0 else ''}{rest}"


def keep_viewport(scene_name: str, warnings: list[str]) -> bool:
    """Keeps the viewport's warnings, instead of those before; True if they have changed."""
    is_new = _viewport.get(scene_name, []) != warnings
    _viewport[scene_name] = list(warnings)
    return is_new


def all_of(scene_name: str) -> list[Message]:
    """The messages of a scene, the last render's first, grouped."""
    render = statistics.last(scene_name)
    texts = [*(render.warnings if render is not None else ()), *_viewport.get(scene_name, ())]
    return [of_text(text) for text in grouped(texts)]


def forget() -> None:
    """Drops the messages of the viewport."""
    _viewport.clear()
