# SPDX-License-Identifier: GPL-3.0-or-later
"""The sharpness of a picture, relative to one of the same things that is sharp everywhere. numpy alone."""

from __future__ import annotations

import numpy as np

from .figure import luminance


def box(values: np.ndarray, radius: int) -> np.ndarray:
    """Means over squares of 2 radius + 1 pixels, smaller at the edges."""
    for axis in (0, 1):
        count = values.shape[axis]
        sums = np.concatenate([np.zeros_like(values.take([0], axis)), np.cumsum(values, axis)], axis)
        low = np.clip(np.arange(count) - radius, 0, count)
        high = np.clip(np.arange(count) + radius + 1, 0, count)
        shape = [1, 1]
        shape[axis] = count
        values = (sums.take(high, axis) - sums.take(low, axis)) / (high - low).reshape(shape)
    return values


def detail(light: np.ndarray, radius: int) -> np.ndarray:
    """Relative differences of pixels from the mean around them."""
    grey = luminance(light)
    around = box(grey, radius)
    return (grey - around) / np.maximum(around, 1e-6)


def contrast(light: np.ndarray, sharp: np.ndarray, mask: np.ndarray | slice | tuple, radius: int) -> float:
    """The contrast of fine detail relative to that of the sharp picture: 1 if as sharp, 0 if none. Noise of the two has nothing in common,
    so it adds nothing."""
    mine, full = detail(light, radius)[mask], detail(sharp, radius)[mask]
    return float((mine * full).sum() / (full * full).sum())


def contrast_by_column(light: np.ndarray, sharp: np.ndarray, rows: slice, radius: int, around: int) -> np.ndarray:
    """The contrast of each column, relative to the sharp picture, with so many columns to both sides of it."""
    mine, full = detail(light, radius)[rows], detail(sharp, radius)[rows]
    above, below = ((mine * full).sum(0), (full * full).sum(0))
    window = np.hanning(2 * around + 3)[1:-1]
    return np.convolve(above, window, "same") / np.maximum(np.convolve(below, window, "same"), 1e-9)
