# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours of numbers, by matplotlib's names."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

#: By name: red, green and blue at equal steps from 0 to 1, sRGB, for linear interpolation. Sampled from matplotlib's maps (inferno: Nathaniel
#: Smith and Stefan van der Walt 2015, CC0).
_STOPS = {
    "inferno": (
        (0.001, 0, 0.014), (0.014, 0.011, 0.072), (0.042, 0.028, 0.141), (0.081, 0.043, 0.214),
        (0.128, 0.047, 0.29), (0.182, 0.04, 0.354), (0.237, 0.037, 0.396), (0.289, 0.045, 0.418),
        (0.34, 0.062, 0.429), (0.39, 0.08, 0.433), (0.439, 0.099, 0.432), (0.489, 0.116, 0.426),
        (0.539, 0.134, 0.416), (0.588, 0.152, 0.401), (0.637, 0.17, 0.382), (0.686, 0.191, 0.359),
        (0.733, 0.214, 0.332), (0.778, 0.241, 0.302), (0.82, 0.273, 0.269), (0.858, 0.309, 0.233),
        (0.892, 0.35, 0.197), (0.921, 0.395, 0.158), (0.945, 0.445, 0.119), (0.964, 0.497, 0.078),
        (0.977, 0.553, 0.038), (0.985, 0.61, 0.025), (0.988, 0.669, 0.06), (0.985, 0.73, 0.122),
        (0.976, 0.791, 0.197), (0.962, 0.852, 0.287), (0.949, 0.911, 0.396), (0.952, 0.961, 0.525),
        (0.988, 0.998, 0.645),
    )
}  # fmt: skip


def coloured(values: npt.NDArray[np.float64], name: str) -> npt.NDArray[np.float64]:
    """The colours of numbers from 0 to 1, (..., 3), sRGB."""
    stops = np.array(_STOPS[name])
    places = np.linspace(0.0, 1.0, len(stops))
    return np.stack([np.interp(values, places, channel) for channel in stops.T], axis=-1)
