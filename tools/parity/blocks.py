# SPDX-License-Identifier: GPL-3.0-or-later
"""Two pictures compared by the means of blocks. Needs no Blender."""

from __future__ import annotations

import numpy as np

#: The floors of blocks, relative to the mean: of pictures, lest the noise of black be a difference; and of passes, which are bright in
#: some places and 0 in most, or negative.
PICTURE, PASS = 0.01, 1.0


def floor_of(look: str) -> float:
    """The floor of a look, `PICTURE` or `PASS`, by its name in `photograph.looks`."""
    return PICTURE if look.startswith(("picture", "frame")) else PASS


def block_ratios(
    ours: np.ndarray, theirs: np.ndarray, floor: float = PICTURE, columns: int = 4, rows: int = 3
) -> np.ndarray:
    """Means over blocks of the picture, ours over theirs: (rows, columns, channels). Blocks that are darker than `floor` of
    the picture's mean are compared with that."""
    means = _means(theirs, columns, rows)
    least = max(np.abs(theirs.astype(np.float64)).mean() * floor, 1e-12)
    return 1.0 + (_means(ours, columns, rows) - means) / np.maximum(np.abs(means), least)


def block_noise(
    ours: list[np.ndarray], theirs: list[np.ndarray], floor: float = PICTURE, columns: int = 4, rows: int = 3
) -> float:
    """The distance from 1 to which noise alone brings the worst of `block_ratios` of the means of two halves each, about: by the difference
    of the halves."""
    whole = 0.5 * (theirs[0] + theirs[1])
    apart = [0.5 * (block_ratios(whole + a - b, whole, floor, columns, rows) - 1.0) for a, b in (ours, theirs)]
    return float(np.hypot(*apart).max())


def _means(picture: np.ndarray, columns: int, rows: int) -> np.ndarray:
    height, width, channels = picture.shape
    cut = picture[: height // rows * rows, : width // columns * columns].astype(np.float64)
    return cut.reshape(rows, height // rows, columns, width // columns, channels).mean((1, 3))
