# SPDX-License-Identifier: GPL-3.0-or-later
"""The confidence interval of a median: by order statistics, which assume no distribution of the values. Plain Python."""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import median

#: The least chance that an interval holds the true median.
CONFIDENCE = 0.9
#: The least number of values with an interval: of five, the least and the largest hold the median with 94 %.
LEAST = 5

#: The relative width of a median's interval at which it has settled.
SETTLED = 0.03


def median_interval(values: Sequence[float]) -> tuple[float, float, float]:
    """The median and its interval; infinitely wide where there are too few values."""
    middle = median(values)
    rank = _rank(len(values))
    if rank is None:
        return middle, -math.inf, math.inf
    ordered = sorted(values)
    return middle, ordered[rank], ordered[len(values) - 1 - rank]


def is_settled(values: Sequence[float]) -> bool:
    """True if the interval of the median is narrower than `SETTLED`."""
    middle, low, high = median_interval(values)
    return high - low < SETTLED * abs(middle)


def _rank(count: int) -> int | None:
    """The largest r such that the values numbered r and count - 1 - r (from 0) hold the median between them surely enough."""
    outside, found = 0.0, None
    for rank in range(count // 2):
        # The median lies below the value of this rank where at most `rank` of all fall below it.
        outside += 2.0 * math.comb(count, rank) / 2.0**count
        if outside > 1.0 - CONFIDENCE:
            break
        found = rank
    return found
