# SPDX-License-Identifier: GPL-3.0-or-later
"""The colour of Blender's Blackbody node by temperature, as Blender renders it. Luminance is one."""

from __future__ import annotations

from bisect import bisect_right
from itertools import pairwise

# Kelvin, then linear Rec.709; rendered with Cycles in Blender 4.5.
_TABLE = (
    (800.0, (5.4138, 0.0, 0.0)),
    (1000.0, (4.6013, 0.039, 0.0)),
    (1250.0, (3.8298, 0.268, 0.0)),
    (1500.0, (3.2643, 0.434, 0.0)),
    (1700.0, (2.9177, 0.5343, 0.0)),
    (1900.0, (2.6386, 0.6136, 0.0)),
    (2000.0, (2.5201, 0.6469, 0.0204)),
    (2200.0, (2.3136, 0.7036, 0.0654)),
    (2400.0, (2.1425, 0.7496, 0.1141)),
    (2600.0, (1.9987, 0.7872, 0.1654)),
    (3000.0, (1.7708, 0.8443, 0.2722)),
    (3500.0, (1.5638, 0.8925, 0.4056)),
    (4000.0, (1.4141, 0.9236, 0.5337)),
    (5000.0, (1.2131, 0.9608, 0.7622)),
    (6500.0, (1.0425, 0.9841, 1.0353)),
    (8000.0, (0.9473, 0.9916, 1.2371)),
    (10000.0, (0.8714, 0.9949, 1.4305)),
    (12000.0, (0.8263, 0.9945, 1.5663)),
)
_SPANS = tuple(pairwise(_TABLE))


def blackbody(kelvin: float) -> tuple[float, float, float]:
    """The colour at a temperature; beyond the table, at its end, as in Blender."""
    kelvin = min(max(kelvin, _TABLE[0][0]), _TABLE[-1][0])
    span = min(bisect_right(_TABLE, kelvin, key=lambda row: row[0]), len(_SPANS)) - 1
    (low, first), (high, second) = _SPANS[max(span, 0)]
    # Colours change about evenly with the inverse temperature.
    share = (1.0 / low - 1.0 / kelvin) / (1.0 / low - 1.0 / high)
    return tuple(a + share * (b - a) for a, b in zip(first, second, strict=True))
