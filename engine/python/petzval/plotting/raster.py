# SPDX-License-Identifier: GPL-3.0-or-later
"""Filled shapes on a picture with smooth edges: exact coverage along a line of pixels, sampled across it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

#: A closed line; (corners, 2), pixels from the lower left corner.
Polygon = npt.NDArray[np.float64]

#: Lines across a row of pixels on which coverage is counted.
_LINES = 8


class Canvas:
    """A white picture, (height, width, 3), first row at the bottom, as a screen shows it (sRGB, 0 to 1)."""

    def __init__(self, width: int, height: int) -> None:
        self.pixels = np.ones((height, width, 3))

    def fill(self, polygons: Sequence[Polygon], colour: Sequence[float], alpha: float = 1.0) -> None:
        """Lays the union of polygons over the picture; holes are those that go round the other way."""
        height, width = self.pixels.shape[:2]
        found = coverage(polygons, width, height)
        if found is not None:
            (x, y), covered = found
            part = self.pixels[y : y + covered.shape[0], x : x + covered.shape[1]]
            part += (np.asarray(colour, dtype=float) - part) * (alpha * covered)[:, :, None]


def coverage(
    polygons: Sequence[Polygon], width: int, height: int
) -> tuple[tuple[int, int], npt.NDArray[np.float64]] | None:
    """The lower left corner of the returned pixels, and the part of each, 0 to 1, that polygons cover, (rows, columns); None: they cover
    none."""
    shapes = [shape for shape in polygons if len(shape) > 2]
    if not shapes:
        return None
    starts = np.concatenate(shapes)
    ends = np.concatenate([np.roll(shape, -1, axis=0) for shape in shapes])
    low = np.floor(np.clip(starts.min(axis=0), 0.0, (width, height))).astype(int)
    high = np.ceil(np.clip(starts.max(axis=0), 0.0, (width, height))).astype(int)
    (columns, rows) = high - low
    if columns < 1 or rows < 1:
        return None
    starts, ends = starts - low, ends - low
    # Each edge counts on the lines between its ends: there all that is to its right is in, or out, by one more.
    lower, upper = np.minimum(starts[:, 1], ends[:, 1]) * _LINES, np.maximum(starts[:, 1], ends[:, 1]) * _LINES
    first = np.clip(np.ceil(lower - 0.5), 0, rows * _LINES).astype(int)
    count = np.maximum(np.clip(np.ceil(upper - 0.5), 0, rows * _LINES).astype(int) - first, 0)
    edge = np.repeat(np.arange(len(starts)), count)
    line = np.arange(len(edge)) - np.repeat(np.cumsum(count) - count, count) + first[edge]
    rise = ends[edge, 1] - starts[edge, 1]
    part = ((line + 0.5) / _LINES - starts[edge, 1]) / rise
    x = np.clip(starts[edge, 0] + part * (ends[edge, 0] - starts[edge, 0]), 0.0, columns)
    turns = np.sign(rise) / _LINES
    cell = np.floor(x).astype(int)
    place = (line // _LINES) * (columns + 2) + cell
    inside = x - cell
    change = np.bincount(place, turns * (1.0 - inside), rows * (columns + 2))
    change += np.bincount(place + 1, turns * inside, rows * (columns + 2))
    total = np.cumsum(change.reshape(rows, columns + 2), axis=1)[:, :columns]
    return (int(low[0]), int(low[1])), np.minimum(np.abs(total), 1.0)
