# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts of a figure. Plain Python and numpy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np


class Contradiction(AssertionError):
    """A picture that contradicts the numbers."""


@dataclass(frozen=True)
class Shot:
    """One photograph. `options` are those of `petzval render`."""

    name: str
    #: The name of a scene in tests/scenes/gallery, and its view.
    scene: str
    lens: str | None
    options: tuple[str, ...] = ()
    view: str = ""
    #: The line under the picture.
    label: str = ""
    #: Width over height, and the width and the samples beside those of the figures' size.
    aspect: float = 1.5
    width: float = 1.0
    samples: float = 1.0
    #: The factor of width by which the picture is shown, for an anamorphic lens that squeezed it.
    widened: float = 1.0
    #: Taken for a check, and not shown.
    is_hidden: bool = False
    #: Shown, and of no use to a check.
    is_only_shown: bool = False


@dataclass
class Taken:
    """A photograph that was taken."""

    shot: Shot
    #: (height, width, 3), scene-linear, the first row at the top.
    light: np.ndarray
    exr: Path
    blend: Path
    stats: dict[str, Any]

    @property
    def size(self) -> tuple[int, int]:
        """Columns and rows."""
        return self.light.shape[1], self.light.shape[0]


@dataclass
class Caption:
    """The measurements in readable form: sentences, and rows of a table below a head."""

    sentences: list[str] = field(default_factory=list)
    head: tuple[str, ...] = ()
    rows: list[tuple[str, ...]] = field(default_factory=list)


@dataclass(frozen=True)
class Figure:
    """`read` makes the caption of the photographs by name, and raises `Contradiction`."""

    #: The key of the file and the anchor: fig-09.
    key: str
    title: str
    shots: tuple[Shot, ...]
    read: Callable[[dict[str, Taken]], Caption]
    #: Pictures side by side.
    columns: int = 2


def luminance(light: np.ndarray) -> np.ndarray:
    """The luminance of scene-linear Rec. 709 colours."""
    return light[..., :3] @ np.array([0.2126, 0.7152, 0.0722])


def claim(is_so: bool, what: str) -> None:
    """Raises `Contradiction` if not."""
    if not is_so:
        raise Contradiction(what)
