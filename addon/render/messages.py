# SPDX-License-Identifier: GPL-3.0-or-later
"""What could not be shown as the scene has it, for the Messages panel: of the last render and of the viewport, once each. No bpy."""

from __future__ import annotations

import re
from typing import NamedTuple

from . import statistics

# "Object 'Cube': ...", as the export and the engine begin them.
_BEGINS = re.compile(r"(\w+) '(.+?)'(?=[:,\s]|$)")

#: By the scene's name.
_viewport: dict[str, list[str]] = {}


class Message(NamedTuple):
    """`kind` and `name` of what it is about, in small letters as it is written: "object", "material"; empty: of nothing."""

    text: str
    kind: str
    name: str


def of_text(text: str) -> Message:
    """A message taken apart."""
    found = _BEGINS.match(text)
    return Message(text, found[1].lower(), found[2]) if found else Message(text, "", "")


def keep_viewport(scene_name: str, warnings: list[str]) -> bool:
    """What the viewport has to say, instead of what it said before; whether that is something else."""
    is_new = _viewport.get(scene_name, []) != warnings
    _viewport[scene_name] = list(warnings)
    return is_new


def all_of(scene_name: str) -> list[Message]:
    """Of a scene, the last render's first."""
    render = statistics.last(scene_name)
    texts = [*(render.warnings if render is not None else ()), *_viewport.get(scene_name, ())]
    return [of_text(text) for text in dict.fromkeys(texts)]


def forget() -> None:
    """Drops those of the viewport."""
    _viewport.clear()
