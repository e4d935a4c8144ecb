# SPDX-License-Identifier: GPL-3.0-or-later
"""The verdict on a setting by the pictures of two programs, each with the setting as it was and changed and with two seeds.

The seeds of a program are independent, and before and after have the same: of the changes D1 and D2 of the two, the mean of D1 D2 is the
squared change without a bias by noise, and D1 - D2 says how much noise there is in it.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

#: Blocks of a picture, across and up; each has the means of red, green, blue and alpha.
COLUMNS, ROWS = 12, 8
#: A change of less than this part of the picture's mean (root mean square over blocks) is not looked at.
LEAST = 0.003
#: The standard errors by which the square of a visible change is from 0.
SURE = 3.0
#: The difference of alike changes, as a part of Cycles'.
ALIKE = 0.1


def blocks(picture: np.ndarray) -> np.ndarray:
    """Means of (height, width, 4) over ROWS by COLUMNS blocks of the picture, whatever its size; colours over the mean of all."""
    sums = np.pad(np.cumsum(np.cumsum(np.minimum(picture, 1e3), 0, dtype=float), 1), ((1, 0), (1, 0), (0, 0)))
    for axis, count in ((0, ROWS), (1, COLUMNS)):
        length = sums.shape[axis] - 1
        at = np.linspace(0.0, length, count + 1)
        whole = np.minimum(at.astype(int), length - 1)
        part = (at - whole).reshape([-1 if index == axis else 1 for index in range(3)])
        sums = np.take(sums, whole, axis) * (1.0 - part) + np.take(sums, whole + 1, axis) * part
        sums = np.diff(sums, axis=axis) * (count / length)
    return sums


@dataclass
class Change:
    """Root mean squares over blocks and channels, in parts of the picture's mean."""

    size: float
    #: The smallest that would have been told from none.
    least: float

    @property
    def shows(self) -> bool:
        return self.size > max(self.least, LEAST)

    @classmethod
    def of(cls, first: np.ndarray, second: np.ndarray) -> Change:
        square = float(np.mean(first * second))
        noise = float(np.mean((first - second) ** 2)) / 2.0
        # Channels are noisy together: the blocks alone count.
        return cls(max(square, 0.0) ** 0.5, (SURE * noise / (ROWS * COLUMNS) ** 0.5) ** 0.5)


@dataclass
class Found:
    """The changes by one value of a setting."""

    here: Change
    cycles: Change
    apart: Change
    #: Pictures of different sizes: width and height by Petzval and by Cycles.
    sizes: str = ""
    #: The setting changes the size of Cycles' picture.
    is_resized: bool = False

    @property
    def verdict(self) -> str:
        if self.sizes:
            return "apart"
        if self.is_resized and not self.apart.shows:
            return "alike"
        if not self.cycles.shows:
            return "here alone" if self.here.shows and self.apart.shows else "nothing"
        return "apart" if self.apart.shows and self.apart.size > ALIKE * self.cycles.size else "alike"

    @property
    def is_clear(self) -> bool:
        """True if more samples would not change the verdict."""
        if self.verdict == "nothing":
            return max(self.cycles.least, self.here.least) < 0.02
        return self.verdict == "alike" and self.apart.least < max(0.3 * self.cycles.size, LEAST)

    def told(self) -> dict[str, Any]:
        return {**asdict(self), "verdict": self.verdict, "is_clear": self.is_clear}


Pictures = list[np.ndarray]


def found(here: tuple[Pictures, Pictures], cycles: tuple[Pictures, Pictures]) -> Found:
    """The comparison of each program's pictures before and after, (height, width, 4), by seed."""
    mean = float(np.mean([one[..., :3].mean() for one in cycles[0]]))
    scale = np.array([mean, mean, mean, 1.0])
    changes = [
        [(blocks(after) - blocks(before)) / scale for before, after in zip(*pair, strict=True)]
        for pair in (here, cycles)
    ]
    shapes = [pair[1][0].shape[1::-1] for pair in (here, cycles)]
    sizes = "" if shapes[0] == shapes[1] else " / ".join(f"{width} x {height}" for width, height in shapes)
    ours, theirs = changes
    is_resized = cycles[0][0].shape != cycles[1][0].shape
    apart = Change.of(*(a - b for a, b in zip(ours, theirs, strict=True)))
    return Found(Change.of(*ours), Change.of(*theirs), apart, sizes, is_resized)
