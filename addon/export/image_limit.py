# SPDX-License-Identifier: GPL-3.0-or-later
"""Simplify's limit of images, as Cycles has it: an image is halved until it is small enough."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np


@dataclass(frozen=True)
class ImageLimit:
    """The most that images may have of their size."""

    #: Pixels on the longer side; 0: as many as there are.
    most_pixels: int = 0
    #: Part of each side.
    scale: float = 1.0

    @classmethod
    def of(cls, scene: bpy.types.Scene, *, is_render: bool) -> ImageLimit:
        """The limit of final renders, or of 3D views. Cycles keeps both; the scale came with 5.2."""
        cycles, end = getattr(scene, "cycles", None), "_render" if is_render else ""
        if cycles is None or not scene.render.use_simplify:
            return cls()
        most = getattr(cycles, f"texture_limit{end}")
        return cls(0 if most == "OFF" else int(most), getattr(cycles, f"texture_resolution{end}", 1.0))

    def smaller(self, pixels: np.ndarray) -> np.ndarray:
        """The image (height, width, channels), halved as often as it must be. Values are averaged as they are kept, bytes rounded."""
        side, halvings = max(pixels.shape[:2]), 0
        while self.most_pixels and side / 2**halvings > self.most_pixels:
            halvings += 1
        while 2.0**-halvings > self.scale:
            halvings += 1
        for _ in range(halvings):
            if max(pixels.shape[:2]) == 1:
                break
            pixels = _halved(pixels)
        return pixels


def _halved(pixels: np.ndarray) -> np.ndarray:
    """Each pixel the mean of two by two; the last column and row of an odd number are left out, but for those of one pixel."""
    height, width = (max(side // 2, 1) for side in pixels.shape[:2])
    rows, columns = (min(2, side) for side in pixels.shape[:2])
    is_bytes = pixels.dtype == np.uint8
    kind = np.uint16 if is_bytes else pixels.dtype
    total = np.zeros((height, width, pixels.shape[2]), kind)
    for y in range(rows):
        for x in range(columns):
            total += pixels[y : y + rows * height : rows, x : x + columns * width : columns]
    count = rows * columns
    return ((total + count // 2) // count).astype(np.uint8) if is_bytes else total / kind.type(count)
