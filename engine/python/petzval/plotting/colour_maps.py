# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours of numbers, by matplotlib's names."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

#: By name: coefficients of the powers 0 to 6 for red, green and blue, sRGB. Fitted to matplotlib's maps by Matt Zucker (2019,
#: shadertoy.com/view/WlfXRN, public domain).
_POWERS = {
    "inferno": (
        (0.0002189403691192265, 0.001651004631001012, -0.01948089843709184),
        (0.1065134194856116, 0.5639564367884091, 3.932712388889277),
        (11.60249308247187, -3.972853965665698, -15.9423941062914),
        (-41.70399613139459, 17.43639888205313, 44.35414519872813),
        (77.162935699427, -33.40235894210092, -81.80730925738993),
        (-71.31942824499214, 32.62606426397723, 73.20951985803202),
        (25.13112622477341, -12.24266895238567, -23.07032500287172),
    )
}


def coloured(values: npt.NDArray[np.float64], name: str) -> npt.NDArray[np.float64]:
    """The colours of numbers from 0 to 1, (..., 3), sRGB."""
    parts = np.clip(values, 0.0, 1.0)[..., None]
    total = np.zeros((*values.shape, 3))
    for power in reversed(_POWERS[name]):
        total = total * parts + np.array(power)
    return np.clip(total, 0.0, 1.0)
