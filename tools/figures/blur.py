# SPDX-License-Identifier: GPL-3.0-or-later
"""The shape of one blurred lamp in the middle of a picture: light over radius, and its edge over the angle. numpy alone."""

from __future__ import annotations

import numpy as np

from .figure import luminance


def _middle(grey: np.ndarray) -> tuple[float, float]:
    """Column and row of the light's middle, the background subtracted."""
    over = np.clip(grey - np.median(grey), 0.0, None)
    over = np.where(over > 0.15 * np.quantile(over, 0.98), over, 0.0)
    rows, columns = np.indices(grey.shape)
    return float((over * columns).sum() / over.sum()), float((over * rows).sum() / over.sum())


def _polar(grey: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distance from the light's middle, pixels, and the angle."""
    column, row = _middle(grey)
    rows, columns = np.indices(grey.shape)
    return np.hypot(columns - column, rows - row), np.arctan2(row - rows, columns - column)


def profile(light: np.ndarray, mm_per_px: float, limit_mm: float, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Middles of rings, mm, and the mean light of each, the background of the lamp subtracted."""
    grey = luminance(light)
    away, _ = _polar(grey)
    away = away * mm_per_px
    grey = grey - np.median(grey[away > limit_mm])
    bounds = np.linspace(0.0, limit_mm, count + 1)
    place = np.digitize(away, bounds) - 1
    means = [grey[place == i].mean() for i in range(count)]
    return 0.5 * (bounds[1:] + bounds[:-1]), np.array(means)


def edge(light: np.ndarray, parts: int = 72) -> np.ndarray:
    """The radius, pixels, at which light falls to half of the light inside, for so many angles."""
    grey = luminance(light)
    away, angle = _polar(grey)
    grey = grey - np.median(grey)
    inside = grey > 0.3 * np.quantile(grey, 0.98)
    radius = np.sqrt(inside.sum() / np.pi)
    level = 0.5 * grey[away < 0.6 * radius].mean()
    found = []
    steps = np.arange(0.55 * radius, 1.5 * radius, 0.5)
    for k in range(parts):
        turn = (angle - 2.0 * np.pi * k / parts + np.pi) % (2.0 * np.pi) - np.pi
        sector = np.abs(turn) < 1.5 * np.pi / parts
        rings = (grey[sector & (np.abs(away - r) < 1.5)] for r in steps)
        # Beyond the picture nothing is known to be lit.
        means = np.array([ring.mean() if ring.size else 0.0 for ring in rings])
        below = np.flatnonzero(means < level)
        i = below[0] if len(below) else len(steps) - 1
        part = (means[i - 1] - level) / max(means[i - 1] - means[i], 1e-9) if i else 0.0
        found.append(steps[max(i - 1, 0)] + 0.5 * part)
    return np.array(found)


def harmonics(radii: np.ndarray, most: int = 10) -> dict[int, float]:
    """Amplitude of the 3rd to the last harmonic over the angle, beside the mean radius."""
    waves = 2.0 * np.abs(np.fft.rfft(radii)) / len(radii)
    return {k: float(waves[k] / radii.mean()) for k in range(3, most + 1)}


def moments(light: np.ndarray) -> tuple[float, float]:
    """Root mean square width and height of the lamp, pixels."""
    grey = luminance(light)
    grey = grey - np.median(grey)
    inside = np.where(grey > 0.15 * np.quantile(grey, 0.98), grey, 0.0)
    rows, columns = np.indices(grey.shape)
    total = inside.sum()
    column, row = (inside * columns).sum() / total, (inside * rows).sum() / total
    return tuple(
        float(np.sqrt((inside * (at - middle) ** 2).sum() / total)) for at, middle in ((columns, column), (rows, row))
    )
