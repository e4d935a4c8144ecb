# SPDX-License-Identifier: GPL-3.0-or-later
"""Sizes of parts: the later, the smaller, so that no machine works on long after the others have ended."""

from __future__ import annotations

#: Size of the first part over that of the last.
_TAPER = 3.0
#: Slots for each part, where the picture has as many tiles: sizes are multiples of one.
_SLOTS_A_PART = 8
#: Pixels on a side of the engine's tiles, and of its blocks where pixels get as many samples as they need.
TILE, BLOCK = 32, 8


def slots_of(tiles: int, parts: int) -> int:
    """Slots into which so many tiles are dealt for so many parts."""
    return min(tiles, _SLOTS_A_PART * parts) if parts > 1 else 1


def cut(slots: int, parts: int) -> list[tuple[int, int]]:
    """The slots of each part, begin and end: all of them, one at least, as nearly in even steps from large to small as whole numbers go."""
    weights = [1.0 + (_TAPER - 1.0) * (parts - 1 - i) / max(parts - 1, 1) for i in range(parts)]
    ends: list[int] = []
    done = 0.0
    for i, weight in enumerate(weights):
        done += weight
        # At least one for this part, and one is left for each that follows.
        least, most = (ends[-1] if ends else 0) + 1, slots - (parts - 1 - i)
        ends.append(min(max(round(slots * done / sum(weights)), least), most))
    return list(zip([0, *ends[:-1]], ends, strict=True))
