# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparison of two pictures of each program, of other seeds: the distance of the programs beyond noise, and the noise of each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

#: Blocks of a picture, across and up.
COLUMNS, ROWS = 16, 9
#: The part of blocks that counts: a caustic's few bright samples would be all that is seen.
BLOCKS_KEPT = 0.95
#: The part of pixels that counts for noise, likewise.
PIXELS_KEPT = 0.999
#: Blocks are compared with themselves and that part of the picture's mean, lest black ones count.
FLOOR = 0.05


@dataclass
class Difference:
    """Root mean squares over blocks and channels, relative."""

    beyond_noise: float
    of_noise: float
    #: The picture's mean, Petzval's over Cycles'.
    mean: float


def blocks(picture: np.ndarray) -> np.ndarray:
    height, width = picture.shape[:2]
    rows, columns = height // ROWS, width // COLUMNS
    return (
        np.minimum(picture, 1e4)[: rows * ROWS, : columns * COLUMNS]
        .reshape(ROWS, rows, COLUMNS, columns, 3)
        .mean((1, 3))
    )


def difference(ours: list[np.ndarray], theirs: list[np.ndarray]) -> Difference:
    """The difference of two programs, by two pictures of each or more: the more there are, the less of their noise is left in it."""
    a, b = (np.array([blocks(one) for one in own]) for own in (ours, theirs))
    first, second = a.mean(0), b.mean(0)
    scale = 0.5 * (first + second) + FLOOR * second.mean() + 1e-12
    apart = np.sort(np.abs((first - second) / scale).ravel())
    # The standard error of both means together.
    of_means = a.var(0, ddof=1) / len(a) + b.var(0, ddof=1) / len(b)
    own = np.sort((np.sqrt(of_means) / scale).ravel())
    kept = int(len(apart) * BLOCKS_KEPT)
    squares = [float(np.mean(one[:kept] ** 2)) for one in (apart, own)]
    return Difference(
        max(0.0, squares[0] - squares[1]) ** 0.5, squares[1] ** 0.5, float(first.mean() / max(second.mean(), 1e-12))
    )


@dataclass
class Noise:
    """The relative variance of a pixel, and the standard error of that, relative."""

    variance: float
    error: float


def noise(pictures: list[np.ndarray], mean: np.ndarray) -> Noise:
    """The noise from pictures of different seeds; `mean` of all that there are. Where few pixels have all the noise, two pictures say
    little."""
    count = len(pictures)
    scale = mean**2 + (0.01 * mean.mean()) ** 2 + 1e-20
    variances = np.sort((np.var(pictures, axis=0, ddof=1) / scale).mean(-1).ravel())
    kept = variances[: int(len(variances) * PIXELS_KEPT)]
    # The variance of a variance from so many normal values is 2 / (count - 1) of its square, whose expectation is (count + 1) / (count - 1)
    # times that.
    error = (2 / (count + 1) * (kept**2).sum()) ** 0.5 / max(kept.sum(), 1e-30)
    return Noise(float(kept.mean()), float(error))
