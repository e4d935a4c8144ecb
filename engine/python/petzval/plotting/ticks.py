# SPDX-License-Identifier: GPL-3.0-or-later
"""Round numbers along an axis."""

from __future__ import annotations

import math

_STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)


def even(low: float, high: float, most: int) -> list[float]:
    """Numbers from `low` to `high`, evenly apart, at most `most`."""
    if not (math.isfinite(low) and math.isfinite(high) and high > low):
        return [low]
    rough = (high - low) / max(most, 1)
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(s * power for s in _STEPS if s * power >= rough * (1.0 - 1e-9))
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [i * step for i in range(first, last + 1)]


def by_power(low: float, high: float, most: int) -> list[float]:
    """Numbers for a logarithmic axis: 1, 2 and 5 times powers of ten, or those alone where there are many."""
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    for digits in ((1.0, 2.0, 5.0), (1.0,)):
        places = [digit * 10.0**power for power in powers for digit in digits]
        places = [place for place in places if low * (1 - 1e-9) <= place <= high * (1 + 1e-9)]
        if len(places) <= most:
            break
    return places


def names(places: list[float]) -> list[str]:
    """The words of ticks: all with as many digits as the finest needs."""
    step = min((b - a for a, b in zip(places, places[1:], strict=False)), default=0.0)
    if step <= 0.0:
        return [plain(place) for place in places]
    digits = max(0, -math.floor(math.log10(step) + 1e-9))
    # Steps of 0.25 need one more.
    digits += any(abs(round(place, digits) - place) > 1e-6 * step for place in places)
    return [f"{place:z.{digits}f}".replace("-", "−") for place in places]


def plain(value: float) -> str:
    """One number by itself."""
    return f"{value:g}".replace("-", "−")
