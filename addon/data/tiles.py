# SPDX-License-Identifier: GPL-3.0-or-later
"""The places of the engine's tiles in Blender's result. No bpy.

Both count pixels from the lower left corner, rows upward. Blender's result holds the rendered region alone.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Window(NamedTuple):
    """A rectangle of pixels."""

    x: int
    y: int
    width: int
    height: int


class Tile(NamedTuple):
    """Pixels (height, width, 4) and the place of their lower left corner."""

    x: int
    y: int
    pixels: np.ndarray


def region(width: int, height: int, border: tuple[float, float, float, float] | None) -> Window:
    """The part of a picture that Blender wants: `border` is left, right, bottom and top as parts of the whole.

    Rounded as Blender does it: in single precision, downward.
    """
    if border is None:
        return Window(0, 0, width, height)
    left, right, bottom, top = (
        int(np.float32(part) * np.float32(side))
        for part, side in zip(border, (width, width, height, height), strict=True)
    )
    return Window(left, bottom, max(right - left, 1), max(top - bottom, 1))


def clipped(tile: Tile, window: Window) -> Tile | None:
    """The part of a tile inside of the window, placed from the window's corner; None where there is none."""
    height, width = tile.pixels.shape[:2]
    left, bottom = max(tile.x, window.x), max(tile.y, window.y)
    right, top = min(tile.x + width, window.x + window.width), min(tile.y + height, window.y + window.height)
    if right <= left or top <= bottom:
        return None
    pixels = tile.pixels[bottom - tile.y : top - tile.y, left - tile.x : right - tile.x]
    return Tile(left - window.x, bottom - window.y, pixels)


def flat(tile: Tile) -> np.ndarray:
    """The pixels as Blender's `foreach_set` takes them."""
    return np.ascontiguousarray(tile.pixels, dtype=np.float32).reshape(-1)
