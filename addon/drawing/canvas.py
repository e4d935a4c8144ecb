# SPDX-License-Identifier: GPL-3.0-or-later
"""A small picture drawn by numpy: polygons, lines and a few letters with soft edges. No bpy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

Colour = tuple[float, float, float, float]
Places = Sequence[Sequence[float]]

#: Samples along a line, in fine pixels.
_STEP = 0.5
#: Letters of five by seven, rows from the top, the left pixel the highest bit.
_LETTERS = {
    "E": (31, 16, 16, 30, 16, 16, 31),
    "F": (31, 16, 16, 30, 16, 16, 16),
    "H": (17, 17, 17, 31, 17, 17, 17),
    "P": (30, 17, 17, 30, 16, 16, 16),
    "X": (17, 17, 10, 4, 10, 17, 17),
    "'": (4, 4, 8, 0, 0, 0, 0),
}


class Canvas:
    """A clear picture that shows `view` (left, right, low, high) of a plane; each layer is painted on those before.

    Shapes are found on a grid `fine` times as fine and averaged.
    """

    def __init__(self, width: int, height: int, view: tuple[float, float, float, float], fine: int = 2) -> None:
        self.width, self.height, self._fine = width, height, fine
        left, right, low, high = view
        self._origin = np.array([left, low])
        self._scale = fine * np.array([width / (right - left), height / (high - low)])
        self._pixels = np.zeros((height, width, 4), np.float32)

    @property
    def pixels(self) -> np.ndarray:
        """(height, width, 4), rows from below, colours times their coverage: as Blender's icons want them."""
        return self._pixels

    def fill(self, polygons: Sequence[Places], colour: Colour) -> None:
        """Polygons by the rule of even and odd; where they overlap they are one."""
        mask = self._empty()
        for polygon in polygons:
            self._fill(mask, self._fine_places(polygon))
        self._paint(mask, colour)

    def draw(
        self, lines: Sequence[Places], colour: Colour, width_px: float, dash_px: tuple[float, float] | None = None
    ) -> None:
        """Open lines; `dash_px`: lengths that are drawn and left out, in turn."""
        mask = self._empty()
        dash = None if dash_px is None else (dash_px[0] * self._fine, dash_px[1] * self._fine)
        dots = [dots for line in lines for dots in _dots(self._fine_places(line), dash)]
        if dots:
            self._stamp(mask, np.concatenate(dots), 0.5 * width_px * self._fine)
        self._paint(mask, colour)

    def write(self, text: str, place: Sequence[float], colour: Colour, height_px: float) -> None:
        """Letters of `_LETTERS`, their lower edge's middle at `place`."""
        mask = self._empty()
        # Of whole pixels: they stay sharp.
        pixel = max(round(height_px / 7.0), 1) * self._fine
        wide = (6 * len(text) - 1) * pixel
        x, y = self._fine_places([place])[0].astype(int) // self._fine * self._fine
        # As far inside as there is room.
        x = int(np.clip(x - wide // 2 // self._fine * self._fine, 0, max(mask.shape[1] - wide, 0)))
        y = int(np.clip(y, 0, max(mask.shape[0] - 7 * pixel, 0)))
        for number, letter in enumerate(text):
            for row, bits in enumerate(reversed(_LETTERS[letter])):
                for column in range(5):
                    if bits >> (4 - column) & 1:
                        left, low = x + (6 * number + column) * pixel, y + row * pixel
                        mask[low : low + pixel, left : left + pixel] = True
        self._paint(mask, colour)

    def _empty(self) -> np.ndarray:
        return np.zeros((self.height * self._fine, self.width * self._fine), bool)

    def _fine_places(self, places: Places) -> np.ndarray:
        return (np.asarray(places, float).reshape(-1, 2) - self._origin) * self._scale

    def _paint(self, mask: np.ndarray, colour: Colour) -> None:
        if not mask.any():
            return
        rows = np.flatnonzero(mask.any(axis=1)) // self._fine
        low, high = rows[0], rows[-1] + 1
        some = mask[low * self._fine : high * self._fine]
        coverage = some.reshape(high - low, self._fine, self.width, self._fine).mean(axis=(1, 3), dtype=np.float32)
        alpha = (coverage * colour[3])[..., None]
        over = alpha * np.array([*colour[:3], 1.0], np.float32)
        self._pixels[low:high] = over + self._pixels[low:high] * (1.0 - alpha)

    @staticmethod
    def _fill(mask: np.ndarray, places: np.ndarray) -> None:
        """Each edge turns the pixels right of it; rows and columns count by their middles."""
        height, width = mask.shape
        begin, end = places, np.roll(places, -1, axis=0)
        is_up = begin[:, 1] <= end[:, 1]
        low, high = np.where(is_up[:, None], begin, end), np.where(is_up[:, None], end, begin)
        first = np.clip(np.ceil(low[:, 1] - 0.5), 0, height).astype(int)
        count = np.clip(np.ceil(high[:, 1] - 0.5), 0, height).astype(int) - first
        if count.sum() == 0:
            return
        edge = np.repeat(np.arange(len(places)), count)
        row = first[edge] + np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
        part = (row + 0.5 - low[edge, 1]) / (high[edge, 1] - low[edge, 1])
        x = low[edge, 0] + part * (high[edge, 0] - low[edge, 0])
        column = np.clip(np.ceil(x - 0.5), 0, width).astype(int)
        top, bottom = row.max() + 1, row.min()
        turns = np.bincount((row - bottom) * (width + 1) + column, minlength=(top - bottom) * (width + 1))
        inside = np.cumsum(turns.reshape(top - bottom, width + 1), axis=1) & 1
        mask[bottom:top] |= inside[:, :width].astype(bool)

    @staticmethod
    def _stamp(mask: np.ndarray, dots: np.ndarray, radius: float) -> None:
        reach = int(np.ceil(radius))
        offsets = np.arange(-reach, reach + 1)
        for dy in offsets:
            for dx in offsets:
                if dx * dx + dy * dy > max(radius, 0.5) ** 2:
                    continue
                column, row = np.floor(dots[:, 0] + dx).astype(int), np.floor(dots[:, 1] + dy).astype(int)
                inside = (column >= 0) & (column < mask.shape[1]) & (row >= 0) & (row < mask.shape[0])
                mask[row[inside], column[inside]] = True


def _dots(line: np.ndarray, dash: tuple[float, float] | None) -> list[np.ndarray]:
    """Places along a line, close to one another; where it is not finite it is left out."""
    found, passed = [], 0.0
    for begin, end in zip(line, line[1:], strict=False):
        length = float(np.hypot(*(end - begin)))
        # Far outside of any picture: a ray that misses.
        if not length < 1e5:
            continue
        part = np.linspace(0.0, 1.0, max(int(length / _STEP), 1) + 1)
        if dash is not None:
            along = (passed + part * length) % sum(dash)
            part = part[along < dash[0]]
        found.append(begin + part[:, None] * (end - begin))
        passed += length
    return found
