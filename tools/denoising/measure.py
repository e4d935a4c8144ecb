# SPDX-License-Identifier: GPL-3.0-or-later
"""The difference of a picture from a converged one: to the eye (FLIP, Andersson et al. 2020), and by relative mean square."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import flip_evaluator
import numpy as np
from bench.noise import rel_mse


@dataclass(frozen=True)
class Error:
    """The difference of a picture and its reference."""

    #: Mean over the pixels, 0 to 1, of the pictures as the scene's view shows them.
    flip: float
    #: The relative mean square error of radiance, without the worst thousandth of the pixels.
    rel_mse: float


def error(pixels: Mapping[str, np.ndarray], reference: str, picture: str) -> Error:
    """The error of a picture, of two that the step `read` has written."""
    shown = [np.ascontiguousarray(np.clip(pixels[f"{one} shown"], 0.0, 1.0)) for one in (reference, picture)]
    _, flip, _ = flip_evaluator.evaluate(*shown, "LDR")
    return Error(float(flip), rel_mse(pixels[picture].astype(np.float64), pixels[reference]))
