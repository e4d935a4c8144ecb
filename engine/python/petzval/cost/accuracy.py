# SPDX-License-Identifier: GPL-3.0-or-later
"""The error of pictures against the truth, parted into noise, which more samples mend, and bias, which they do not.

The error is the relative squared one, its worst pixels left out. Its bias is estimated without noise: were every picture
its limit plus noise with mean 0, then of independent pictures a and b, and independent truths r and s, (a - r)(b - s)
has the square of the limits' distance as mean. All pairs of pictures are used; sums of them and of their squares are enough.
"""

from __future__ import annotations

from typing import Any, NamedTuple

#: Part of the pixels, the worst ones, that is left out: a few sparks would decide it all.
TRIMMED = 1e-3
#: The floor of brightness as a part of the truth's mean: keeps black pixels from deciding. Larger than where one camera's noise is
#: measured: a simple camera is bright where the lens leaves corners black, and there any relative error would be one of the floor.
FLOOR = 0.1
#: The pixel filter makes neighbours alike: the mean over pixels is less sure than if each stood alone. A filter of 1.5
#: pixels (Blackman-Harris) spreads a sample's light as over 1 / sum of squared weights, about 2, pixels.
_PIXELS_ALIKE = 2.0
#: The standard errors below which a bias is not told from none.
SURE = 3.0


class Sums:
    """The sums of pictures with independent noise: their count, their sum, the sum of their squares."""

    def __init__(self) -> None:
        self.count = 0
        self.sum: Any = 0.0
        self.squares: Any = 0.0
        self.last: Any = None

    def add(self, picture: Any) -> None:
        """Takes one more."""
        import numpy as np

        picture = picture.astype(np.float64)
        self.count += 1
        self.sum = self.sum + picture
        self.squares = self.squares + picture**2
        self.last = picture

    def mean(self) -> Any:
        return self.sum / self.count

    def variance(self) -> Any:
        """The variance of one picture, for each pixel and colour."""
        import numpy as np

        return np.maximum(self.squares - self.sum**2 / self.count, 0.0) / (self.count - 1)


class Error(NamedTuple):
    """Trimmed relative mean squared errors. `noise` is that of one of the pictures; their limit has `bias` alone."""

    bias: float
    bias_uncertainty: float
    noise: float

    @property
    def sure_bias(self) -> float:
        """The bias, or nothing where it is not told from none."""
        return self.bias if self.bias > SURE * self.bias_uncertainty else 0.0


def error(pictures: Sums, truth: tuple[Sums, Sums]) -> Error:
    """The error of pictures against two independent halves of the truth. Needs two pictures."""
    import numpy as np

    first, second = (half.mean() for half in truth)
    reference = 0.5 * (first + second)
    scale = _scale(reference)
    mean, variance = pictures.mean(), pictures.variance()
    pairs = _pairs(pictures)
    bias = ((pairs - mean * (first + second) + first * second) * scale).mean(-1)
    noise = (variance * scale).mean(-1)
    kept = np.argsort((((mean - reference) ** 2 * scale).mean(-1) + noise), axis=None)
    kept = kept[: int(kept.size * (1.0 - TRIMMED))]
    # What pixels differ by, which is their noise and more: on the safe side.
    uncertainty = np.sqrt(_PIXELS_ALIKE * bias.ravel()[kept].var() / kept.size)
    return Error(float(bias.ravel()[kept].mean()), float(uncertainty), float(noise.ravel()[kept].mean()))


def change(parts: Sums, truth: Any) -> Error:
    """The error of a picture without a part of its light, against the truth with it: the size of the part. It is known by itself, so
    the noise of the rest does not hide it. Needs it from two pictures."""
    import numpy as np

    scale, n, variance = _scale(truth), parts.count, parts.variance()
    kept = np.argsort((parts.mean() ** 2 * scale).mean(-1), axis=None)
    kept = kept[: int(kept.size * (1.0 - TRIMMED))]

    def mean(values: Any) -> float:
        return float(values.mean(-1).ravel()[kept].mean())

    square = _pairs(parts)
    # Of a product of two pictures' values. Stray light is spread over the picture, and its noise with it: nothing cancels over pixels.
    uncertainty = np.sqrt(4.0 * np.maximum(square, 0.0) * variance / n + 2.0 * variance**2 / (n * (n - 1)))
    return Error(mean(square * scale), mean(uncertainty * scale), mean(variance * scale))


def size(part: Any, truth: Any) -> float:
    """The relative mean square of a part of the light, its noise included."""
    import numpy as np

    squares = np.sort(((part**2) * _scale(truth)).mean(-1), axis=None)
    return float(squares[: int(squares.size * (1.0 - TRIMMED))].mean())


def _pairs(pictures: Sums) -> Any:
    """The square of the pictures' limit, from products of different pictures: their noise cancels."""
    n = pictures.count
    return (pictures.sum**2 - pictures.squares) / (n * (n - 1))


def _scale(reference: Any) -> Any:
    """The factor that makes a squared error relative."""
    return 1.0 / (reference**2 + (FLOOR * reference.mean()) ** 2)
