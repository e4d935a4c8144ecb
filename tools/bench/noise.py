# SPDX-License-Identifier: GPL-3.0-or-later
"""The error of a noisy picture against its limit, and the samples that lower it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

#: Part of the pixels, the worst ones, that is left out: a few sparks would decide it all.
TRIMMED = 1e-3
#: The floor of brightness as a part of the reference's mean: keeps black pixels from deciding.
FLOOR = 0.01


def squared_errors(picture: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """The relative squared error of each pixel, (height, width)."""
    reference = reference.astype(np.float64)
    floor = FLOOR * reference.mean()
    return ((picture - reference) ** 2 / (reference**2 + floor**2)).mean(-1)


def trimmed_mean(errors: np.ndarray) -> float:
    """Mean without the worst pixels."""
    kept = int(errors.size * (1.0 - TRIMMED))
    return float(np.sort(errors, axis=None)[:kept].mean())


def rel_mse(picture: np.ndarray, reference: np.ndarray, samples: int = 0, reference_samples: int = 0) -> float:
    """Trimmed relative mean squared error of a picture against its limit.

    With both counts of samples, the part that is the reference's own noise is taken off: an error of 1/samples in the
    picture is one of 1/reference_samples in the reference.
    """
    measured = trimmed_mean(squared_errors(picture, reference))
    return measured / (1.0 + samples / reference_samples) if reference_samples else measured


def difference(first: Sequence[np.ndarray], second: Sequence[np.ndarray]) -> tuple[float, float]:
    """Trimmed relMSE of two pictures, each given in two halves, and the part of it that is noise.

    The noise is taken over the pixels that the error keeps, and relative to the same reference.
    """
    a, b = (0.5 * (halves[0].astype(np.float64) + halves[1]) for halves in (first, second))
    errors = squared_errors(a, b)
    # Halves differ by four times the variance of their mean.
    variance = sum((halves[0].astype(np.float64) - halves[1]) ** 2 for halves in (first, second)) / 4.0
    noise = (variance / (b**2 + (FLOOR * b.mean()) ** 2)).mean(-1)
    kept = np.argsort(errors, axis=None)[: int(errors.size * (1.0 - TRIMMED))]
    return float(errors.ravel()[kept].mean()), float(noise.ravel()[kept].mean())


@dataclass(frozen=True)
class Convergence:
    """Error times samples, and CPU seconds a sample (of the whole picture)."""

    error_samples: float
    seconds_per_sample: float

    def error(self, samples: float) -> float:
        """The error that is left after so many samples a pixel."""
        return self.error_samples / samples

    def seconds_to(self, error: float) -> float:
        """CPU seconds until the error is down to `error`."""
        return self.error_samples / error * self.seconds_per_sample


def fit(samples: Sequence[int], errors: Sequence[float], seconds: Sequence[float]) -> Convergence:
    """Errors as c / samples (each point counts alike), seconds as a line over samples, whose start-up is left out."""
    n = np.asarray(samples, float)
    product = float(np.exp(np.mean(np.log(np.asarray(errors, float) * n))))
    return Convergence(product, slope(samples, seconds))


def slope(samples: Sequence[int], seconds: Sequence[float]) -> float:
    """Seconds a sample: the line through the points by least squares, or the quotient of a single one."""
    n, s = np.asarray(samples, float), np.asarray(seconds, float)
    if len(set(samples)) < 2:
        return float(np.mean(s / n))
    return float(((n - n.mean()) * (s - s.mean())).sum() / ((n - n.mean()) ** 2).sum())
