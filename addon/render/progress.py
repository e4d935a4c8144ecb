# SPDX-License-Identifier: GPL-3.0-or-later
"""The status of a running render: the time that is left, and the rays a second. No bpy."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from typing import Any

# Counting rays looks at the whole film.
_COUNT_EVERY_S = 1.0
# Before that a guess of the time is worth nothing.
_LEAST_PART = 0.003


class Progress:
    """The progress of one job, from its making; `limit_s` is the time that it has, 0 for no limit."""

    def __init__(self, job: Any, limit_s: float = 0.0, clock: Callable[[], float] = time.monotonic) -> None:
        self._job, self._limit_s, self._clock = job, limit_s, clock
        self._began = clock()
        # Work taken up from a checkpoint was not done now.
        self._part, self._rays = job.progress(), self._count()
        self._counted = self._began
        self._per_second = 0.0

    def left_s(self, part: float) -> float | None:
        """Seconds until the end, as it looks when a part of the work is done; None: nobody knows yet."""
        gone = self._clock() - self._began
        done = part - self._part
        left = gone * (1.0 - part) / done if done > _LEAST_PART else None
        if self._limit_s > 0.0:
            limit = max(self._limit_s - gone, 0.0)
            left = limit if left is None else min(left, limit)
        return left

    def rays_per_second(self) -> float:
        """Since the job began, counted now and then."""
        now = self._clock()
        if now - self._counted >= _COUNT_EVERY_S:
            self._counted = now
            self._per_second = (self._count() - self._rays) / (now - self._began)
        return self._per_second

    def remaining(self, part: float) -> str:
        """The remaining time in Cycles' words, with the bar that separates it from the rest; empty where it is not known."""
        left = self.left_s(part)
        return "" if left is None or part >= 1.0 else f"Remaining:{clock_time(left)} | "

    def speed(self) -> str:
        """The rays a second in words; empty until they were counted."""
        rays = self.rays_per_second()
        return f" | {in_short(rays)} rays/s" if rays > 0.0 else ""

    def _count(self) -> int:
        return json.loads(self._job.stats_json())["rays"]


def clock_time(seconds: float) -> str:
    """A time as Blender writes it: minutes and seconds with hundredths, hours where there are any."""
    minutes, rest = divmod(max(seconds, 0.0), 60.0)
    hours, minutes = divmod(int(minutes), 60)
    return f"{hours}:{minutes:02d}:{int(rest):02d}" if hours else f"{minutes:02d}:{rest:05.2f}"


def in_short(count: float) -> str:
    """Three digits, with k, M or G."""
    for unit, size in (("G", 1e9), ("M", 1e6), ("k", 1e3)):
        if count >= size:
            return f"{count / size:.3g} {unit}"
    return f"{count:.0f}"
