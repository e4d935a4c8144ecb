# SPDX-License-Identifier: GPL-3.0-or-later
"""Block means of Cycles' pictures that are part of the repository. Imported inside of tests: it needs bpy.

Cycles takes as long as Petzval, and the same Cycles takes the same picture of the same scene. Tests that compare nothing but means of
blocks get them from tests/cycles_blocks, a file for each module of tests. A stored picture counts as long as Blender's version, the
test's sources, the scene and its settings are what they were (`kept_references.digest`); else Cycles renders.

PETZVAL_STORE_BLOCKS=1 stores what Cycles renders; PETZVAL_CYCLES_AGAIN=1 has Cycles render, and holds what is stored against that.
"""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np

from support import kept_references
from support.places import TESTS

FOLDER = TESTS / "cycles_blocks"
#: Pictures of more blocks are not stored: their files would be large.
MOST_BLOCKS = 96
#: Significant digits: far below any limit.
DIGITS = 6

#: What the files hold, by module of tests; and the pictures that this run has asked for.
_known: dict[Path, dict[str, dict]] = {}
_asked: dict[Path, set[str]] = {}

Pictures = np.ndarray | dict[str, np.ndarray]


def find(key: str) -> Pictures | None:
    """A stored picture, each block filled with its mean; or several by their names. `None`: it is not stored."""
    can_be = kept_references.is_reproducible() and not os.environ.get("PETZVAL_STORE_BLOCKS")
    found = _file(_place()).get(key) if can_be else None
    if found is None:
        return None
    pictures = {name: _filled(one) for name, one in found.items()}
    return pictures[""] if list(pictures) == [""] else pictures


def check(key: str, pictures: Pictures, blocks: tuple[int, int]) -> None:
    """Holds the stored blocks against the pictures that Cycles has rendered anew."""
    stored = _file(_place()).get(key)
    if stored is None or not kept_references.is_reproducible():
        return
    for name, picture in _named(pictures).items():
        means = _means(picture, blocks)
        known = np.array(stored[name]["means"]).reshape(means.shape)
        # Processors differ by roundings, and so by a path here and there.
        assert np.allclose(known, means, rtol=0.02, atol=0.01 * np.abs(means).mean()), (name, known, means)


def store(key: str, pictures: Pictures, blocks: tuple[int, int]) -> None:
    """Stores pictures of Cycles, if they can be: those of both signs are compared by more than their means."""
    place = _place()
    known = _file(place)
    named = _named(pictures)
    fits = all((picture >= 0.0).all() and picture.shape[0] % blocks[0] == picture.shape[1] % blocks[1] == 0 for picture in named.values())  # fmt: skip
    if blocks[0] * blocks[1] > MOST_BLOCKS or not fits or not kept_references.is_reproducible():
        return
    known[key] = {
        name: {
            "size": picture.shape[:2],
            "means": [float(f"{mean:.{DIGITS}g}") for mean in _means(picture, blocks).ravel()],
            "blocks": blocks,
        }  # fmt: skip
        for name, picture in named.items()
    }
    _asked.setdefault(place, set()).add(key)
    FOLDER.mkdir(exist_ok=True)
    part = place.with_suffix(f".{os.getpid()}.part")
    # What a run over the module has not asked for is of tests that are gone.
    lines = [f'"{key}": {json.dumps(known[key])}' for key in sorted(_asked[place])]
    part.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
    part.replace(place)


def _place() -> Path:
    test = os.environ["PYTEST_CURRENT_TEST"]
    version = ".".join(map(str, kept_references.bpy.app.version[:2]))
    return FOLDER / f"{Path(test.partition('::')[0]).stem}-{version}.json"


def _file(place: Path) -> dict[str, dict]:
    if place not in _known:
        _known[place] = json.loads(place.read_text(encoding="utf-8")) if place.exists() else {}
    return _known[place]


def _named(pictures: Pictures) -> dict[str, np.ndarray]:
    return pictures if isinstance(pictures, dict) else {"": pictures}


def _means(picture: np.ndarray, blocks: tuple[int, int]) -> np.ndarray:
    """(rows, columns, channels)."""
    (height, width, channels), (rows, columns) = picture.shape, blocks
    parts = picture.astype(np.float64).reshape(rows, height // rows, columns, width // columns, channels)
    return parts.mean((1, 3))


def _filled(stored: dict) -> np.ndarray:
    (height, width), (rows, columns) = stored["size"], stored["blocks"]
    means = np.array(stored["means"]).reshape(rows, columns, -1)
    return means.repeat(height // rows, 0).repeat(width // columns, 1)
