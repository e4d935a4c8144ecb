# SPDX-License-Identifier: GPL-3.0-or-later
"""A fingerprint of all that the engine is told, by which it is known that it was told the same before."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np


class Watched:
    """The engine's `SceneBuilder`, whose calls leave their mark in a digest of hashlib; all of them but those of `unmarked`."""

    def __init__(self, builder: Any, digest: Any, unmarked: frozenset[str] = frozenset()) -> None:
        self._builder, self._digest, self._unmarked = builder, digest, unmarked

    def __getattr__(self, name: str) -> Any:
        target = getattr(self._builder, name)
        if name in self._unmarked:
            return target

        def call(*arguments: Any, **named: Any) -> Any:
            feed(self._digest, (name, arguments, named))
            return target(*arguments, **named)

        return call


def feed(digest: Any, value: Any) -> None:
    """Adds a value as the engine takes them; each is marked by its kind and length, so that none runs into the next."""
    if isinstance(value, np.ndarray):
        digest.update(f"array {value.dtype.str} {value.shape};".encode())
        digest.update(np.ascontiguousarray(value).data)
    elif isinstance(value, bytes):
        digest.update(f"bytes {len(value)};".encode())
        digest.update(value)
    elif dataclasses.is_dataclass(value):
        digest.update(f"{type(value).__name__};".encode())
        for one in dataclasses.fields(value):
            feed(digest, (one.name, getattr(value, one.name)))
    elif isinstance(value, dict):
        feed(digest, list(value.items()))
    elif isinstance(value, (list, tuple)):
        digest.update(f"list {len(value)};".encode())
        for one in value:
            feed(digest, one)
    else:
        text = repr(value)
        digest.update(f"{len(text)} {text};".encode())
