# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines and marks as polygons, all of which go round the same way, so that where they overlap they are one shape."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from .raster import Polygon

#: Corners of a joint and of a round mark.
_JOINT, _ROUND = 8, 20


def stroke(points: Polygon, width: float, *, closed: bool = False) -> list[Polygon]:
    """A line of that width through points; a quadrilateral a segment, its joints round where they can be seen."""
    points = np.concatenate([points, points[:1]]) if closed else points
    along = np.diff(points, axis=0)
    length = np.hypot(along[:, 0], along[:, 1])
    is_long = length > 1e-9
    start, end = points[:-1][is_long], points[1:][is_long]
    if not len(start):
        return []
    aside = along[is_long] / length[is_long, None] * (0.5 * width)
    aside = np.stack([-aside[:, 1], aside[:, 0]], axis=1)
    quads = np.stack([start + aside, start - aside, end - aside, end + aside], axis=1)
    shapes = list(quads)
    # Slight bends of thin lines have no joints to be seen.
    bend = np.hypot(*np.diff(aside, axis=0).T) if len(aside) > 1 else np.zeros(0)
    shapes += [_disc(place, 0.5 * width, _JOINT) for place in start[1:][bend > 0.25]]
    return shapes


def dashed(points: Polygon, pattern: Sequence[float]) -> list[Polygon]:
    """The pieces of a line that a pattern (on, off, ...; pixels) leaves."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    pieces, here, i = [], 0.0, 0
    while here < along[-1] and sum(pattern) > 0.5:
        end = min(here + pattern[i % len(pattern)], along[-1])
        if i % 2 == 0 and end > here:
            inside = along[(along > here) & (along < end)]
            places = np.concatenate([[here], inside, [end]])
            pieces.append(np.stack([np.interp(places, along, points[:, axis]) for axis in (0, 1)], axis=1))
        here, i = end, i + 1
    return pieces


def marks(points: Polygon, kind: str, size: float) -> list[Polygon]:
    """A mark at each point, so large across."""
    if not len(points):
        return []
    if kind == "_":
        half = np.array([0.5 * size, 0.0])
        return [shape for p in points for shape in stroke(np.array([p - half, p + half]), 1.6)]
    return list(points[:, None, :] + _mark(kind, 0.5 * size)[None])


def _mark(kind: str, radius: float) -> Polygon:
    corners = {"o": _ROUND if radius > 2.0 else 10, "^": 3, "s": 4, "D": 4, "v": 3, "<": 3}.get(kind, _ROUND)
    turn = {"^": 90.0, "s": 45.0, "D": 0.0, "v": -90.0, "<": 180.0}.get(kind, 0.0)
    return _disc(np.zeros(2), radius * (1.0 if corners > 4 else 1.2), corners, math.radians(turn))


def _disc(middle: Polygon, radius: float, corners: int, turn: float = 0.0) -> Polygon:
    angles = turn + 2.0 * np.pi * np.arange(corners) / corners
    rim: Polygon = middle + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return rim


def clipped(points: Polygon, low: Sequence[float], high: Sequence[float]) -> list[Polygon]:
    """The pieces of a line within a box."""
    pieces: list[list[Polygon]] = []
    for a, b in zip(points, points[1:], strict=False):
        inside = _within(a, b, low, high)
        if inside is None:
            continue
        start, end = inside
        if pieces and np.allclose(pieces[-1][-1], start, atol=1e-9):
            pieces[-1].append(end)
        else:
            pieces.append([start, end])
    return [np.array(piece) for piece in pieces]


def _within(a: Polygon, b: Polygon, low: Sequence[float], high: Sequence[float]) -> tuple[Polygon, Polygon] | None:
    """The part of a segment within a box (Liang and Barsky 1984)."""
    first, last, along = 0.0, 1.0, b - a
    for axis in (0, 1):
        for step, room in ((-along[axis], a[axis] - low[axis]), (along[axis], high[axis] - a[axis])):
            if step == 0.0:
                if room < 0.0:
                    return None
            elif step < 0.0:
                first = max(first, room / step)
            else:
                last = min(last, room / step)
    return (a + along * first, a + along * last) if first <= last else None
