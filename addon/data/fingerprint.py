# SPDX-License-Identifier: GPL-3.0-or-later
"""A fingerprint of all that the engine is told, by which it is known that it was told the same before."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import marshal
from typing import Any

import numpy as np

#: Calls of the builder by which it gets images, materials and meshes, and forgets them, and the kind of piece.
_ADDS = {
    "add_image": "image",
    "add_tiles": "image",
    "add_material": "material",
    "add_mesh": "mesh",
    "add_curves": "mesh",
    "add_points": "mesh",
}
_FORGETS = {"forget_image": "image", "forget_material": "material", "forget_mesh": "mesh"}
#: All calls of the builder that add or forget a piece.
PIECES = frozenset({*_ADDS, *_FORGETS})

#: Fingerprints of the images, materials and meshes that a builder holds, by kind and index.
Pieces = dict[tuple[str, int], bytes]


class Watched:
    """The engine's `SceneBuilder`, whose calls leave their mark in a digest of hashlib; those of images, materials and meshes in `pieces`
    instead, or nowhere without these."""

    def __init__(self, builder: Any, digest: Any, pieces: Pieces | None) -> None:
        self._builder, self._digest, self._pieces = builder, digest, pieces
        #: The names of the pieces that were sent, for people.
        self.names: dict[tuple[str, int], str] = {}

    def __getattr__(self, name: str) -> Any:
        target = getattr(self._builder, name)
        pieces = self._pieces
        if name in PIECES and pieces is None:
            return target

        def call(*arguments: Any, **named: Any) -> Any:
            if name in _FORGETS:
                pieces.pop((_FORGETS[name], *arguments), None)
                return target(*arguments, **named)
            digest = hashlib.blake2b(digest_size=32) if name in _ADDS else self._digest
            feed(digest, (name, arguments, named))
            given = target(*arguments, **named)
            if name in _ADDS:
                pieces[_ADDS[name], given] = digest.digest()
                self.names[_ADDS[name], given] = next((one for one in arguments if type(one) is str), "")
            return given

        return call


#: Kinds whose values marshal writes by themselves, each marked by its kind and length.
_PLAIN = frozenset({str, int, float, bool, type(None)})


def feed(digest: Any, value: Any) -> None:
    """Adds a value as the engine takes them; each is marked by its kind and length, so that none runs into the next."""
    kind = type(value)
    if kind in _PLAIN:
        digest.update(_written(value))
    elif kind is tuple or kind is list:
        _feed_all(digest, value)
    elif kind is bytes:
        digest.update(b"bytes %d;" % len(value))
        digest.update(value)
    elif isinstance(value, np.ndarray):
        digest.update(f"array {value.dtype.str} {value.shape};".encode())
        digest.update(np.ascontiguousarray(value).data)
    elif dataclasses.is_dataclass(value):
        digest.update(f"{kind.__name__};".encode())
        _feed_all(digest, [getattr(value, name) for name in _names(kind)])
    elif isinstance(value, dict):
        digest.update(b"dict;")
        _feed_all(digest, list(value))
        _feed_all(digest, list(value.values()))
    elif isinstance(value, (tuple, list)):
        _feed_all(digest, list(value))
    else:
        text = repr(value)
        digest.update(f"{len(text)} {text};".encode())


def _feed_all(digest: Any, values: tuple | list) -> None:
    """Adds values: the plain ones at once, which is ten times as fast as one by one, then the others in their order."""
    others = [one for one in values if type(one) not in _PLAIN]
    digest.update(_written(tuple(one if type(one) in _PLAIN else ... for one in values) if others else tuple(values)))
    for one in others:
        feed(digest, one)


def _written(value: Any) -> bytes:
    """A plain value, or a tuple of such. Version 2 writes equal values alike: later ones refer to the same object."""
    return b"=" + marshal.dumps(value, 2)


@functools.cache
def _names(kind: type) -> tuple[str, ...]:
    """The fields of a dataclass."""
    return tuple(one.name for one in dataclasses.fields(kind))
