# SPDX-License-Identifier: GPL-3.0-or-later
"""FLIP: how different two pictures look when one is shown after the other at the same place, 0 to 1.

Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astrom, Fairchild: "FLIP: A Difference Evaluator for Alternating Images",
2020; for pictures as a screen shows them, from 0.7 m at a screen 0.7 m wide with 3840 pixels. The letters are the paper's.
"""

from __future__ import annotations

import math
from typing import Any

PIXELS_PER_DEGREE = 0.7 * 3840 / 0.7 * math.pi / 180.0

# Contrast sensitivity of achromatic, red-green and blue-yellow vision as sums of Gaussians: (a1, b1, a2, b2).
_SENSITIVITY = ((1.0, 0.0047, 0.0, 1e-5), (1.0, 0.0053, 0.0, 1e-5), (34.1, 0.04, 13.5, 0.025))
_Q_COLOUR, _P_COLOUR, _P_TOP = 0.7, 0.4, 0.95
_FEATURE_WIDTH_DEG, _Q_FEATURE = 0.082, 0.5

_XYZ = ((10135552 / 24577794, 8788810 / 24577794, 4435075 / 24577794),
        (2613072 / 12288897, 8788810 / 12288897, 887015 / 12288897),
        (1425312 / 73733382, 8788810 / 73733382, 70074185 / 73733382))  # fmt: skip


def flip(test: Any, reference: Any) -> float:
    """Mean FLIP of two linear Rec.709 pictures (height, width, 3), clipped to the range of a screen."""
    import numpy as np

    vision = _Vision(np)
    pair = [np.clip(picture, 0.0, 1.0) for picture in (reference, test)]
    opponent = [vision.opponent(picture) for picture in pair]
    colour = vision.colour_difference(*opponent)
    feature = vision.feature_difference(*(one[..., 0] for one in opponent))
    return float((colour ** (1.0 - feature)).mean())


class _Vision:
    """The constants and transforms of FLIP's model of vision, the same for every picture."""

    def __init__(self, np: Any) -> None:
        self.np = np
        self.xyz = np.array(_XYZ)
        self.white = self.xyz.sum(1)

    def opponent(self, linear: Any) -> Any:
        """YCxCz: lightness and two opponent colours, linear in XYZ."""
        x, y, z = self.np.moveaxis(linear @ self.xyz.T / self.white, -1, 0)
        return self.np.stack([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)], -1)

    def linear(self, opponent: Any) -> Any:
        y = (opponent[..., 0] + 16.0) / 116.0
        x, z = y + opponent[..., 1] / 500.0, y - opponent[..., 2] / 200.0
        return (self.np.stack([x, y, z], -1) * self.white) @ self.np.linalg.inv(self.xyz).T

    def hunt_lab(self, linear: Any) -> Any:
        """L*a*b*, its colours weaker where it is dark."""
        np = self.np
        ratio = linear @ self.xyz.T / self.white
        edge = 6.0 / 29.0
        bent = np.where(ratio > edge**3, np.cbrt(ratio), ratio / (3.0 * edge**2) + 4.0 / 29.0)
        lightness = 116.0 * bent[..., 1] - 16.0
        a, b = 500.0 * (bent[..., 0] - bent[..., 1]), 200.0 * (bent[..., 1] - bent[..., 2])
        return np.stack([lightness, 0.01 * lightness * a, 0.01 * lightness * b], -1)

    def distance(self, first: Any, second: Any) -> Any:
        """HyAB: city block in lightness, Euclid in colour."""
        d = first - second
        return abs(d[..., 0]) + self.np.hypot(d[..., 1], d[..., 2])

    def colour_difference(self, reference: Any, test: Any) -> Any:
        """The difference of the features that are left when the eye has blurred both."""
        np = self.np
        seen = [self.hunt_lab(np.clip(self.linear(self.blurred(one)), 0.0, 1.0)) for one in (reference, test)]
        green, blue = (self.hunt_lab(np.array(one)) for one in ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
        largest = self.distance(green, blue) ** _Q_COLOUR
        d = self.distance(*seen) ** _Q_COLOUR
        knee = _P_COLOUR * largest
        above = _P_TOP + (d - knee) / (largest - knee) * (1.0 - _P_TOP)
        return np.where(d < knee, _P_TOP / knee * d, above)

    def blurred(self, opponent: Any) -> Any:
        np = self.np
        widest = max(max(b1, b2) for _, b1, _, b2 in _SENSITIVITY)
        radius = math.ceil(3.0 * math.sqrt(widest / (2.0 * math.pi**2)) * PIXELS_PER_DEGREE)
        squares = (np.arange(-radius, radius + 1) / PIXELS_PER_DEGREE) ** 2
        channels = []
        for channel, (a1, b1, a2, b2) in enumerate(_SENSITIVITY):
            # Each of the two Gaussians falls apart into one along each axis.
            plane, total, weight = opponent[..., channel], 0.0, 0.0
            for a, b in ((a1, b1), (a2, b2)):
                if a == 0.0:
                    continue
                kernel = np.exp(-(math.pi**2) * squares / b)
                height = a * math.sqrt(math.pi / b)
                total = total + height * _along(np, _along(np, plane, kernel, 0), kernel, 1)
                weight += height * kernel.sum() ** 2
            channels.append(total / weight)
        return np.stack(channels, -1)

    def feature_difference(self, reference: Any, test: Any) -> Any:
        """The difference of edges and points in lightness."""
        np = self.np
        deviation = 0.5 * _FEATURE_WIDTH_DEG * PIXELS_PER_DEGREE
        radius = math.ceil(3.0 * deviation)
        x = np.arange(-radius, radius + 1)
        smooth = np.exp(-(x**2) / (2.0 * deviation**2))
        smooth /= smooth.sum()
        edge = _balanced(np, -x * smooth)
        point = _balanced(np, (x**2 / deviation**2 - 1.0) * smooth)
        size = {}
        for which, lightness in (("reference", reference), ("test", test)):
            plane = (lightness + 16.0) / 116.0
            for name, kernel in (("edge", edge), ("point", point)):
                across = _along(np, _along(np, plane, kernel, 1), smooth, 0)
                down = _along(np, _along(np, plane, kernel, 0), smooth, 1)
                size[which, name] = np.hypot(across, down)
        edges, points = (abs(size["reference", one] - size["test", one]) for one in ("edge", "point"))
        return (np.maximum(edges, points) / math.sqrt(2.0)) ** _Q_FEATURE


def _balanced(np: Any, kernel: Any) -> Any:
    """The kernel normalized: its positive weights add up to 1, its negative ones to -1."""
    return np.where(kernel > 0.0, kernel / kernel[kernel > 0.0].sum(), -kernel / kernel[kernel < 0.0].sum())


def _along(np: Any, plane: Any, kernel: Any, axis: int) -> Any:
    """The plane convolved along an axis, its edge repeated."""
    radius = len(kernel) // 2
    pad = [(0, 0), (0, 0)]
    pad[axis] = (radius, radius)
    padded = np.pad(plane, pad, mode="edge")
    length = plane.shape[axis]
    parts = (np.take(padded, range(i, i + length), axis) * weight for i, weight in enumerate(kernel[::-1]))
    return sum(parts)
