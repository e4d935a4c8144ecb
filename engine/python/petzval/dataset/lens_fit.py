# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera models of OpenCV, fitted to the places where a lens shows directions."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

#: By model: the names of the parameters behind fx, fy, cx, cy. Models and their equations: docs.opencv.org, "Camera Calibration and 3D
#: Reconstruction", and "Fisheye camera model".
DISTORTION = {"PINHOLE": (), "OPENCV": ("k1", "k2", "p1", "p2", "k3"), "OPENCV_FISHEYE": ("k1", "k2", "k3", "k4")}


def project(model: str, parameters: Array, points: Array) -> Array:
    """Places in pixels (n, 2), right and down, of points (n, 3) in camera space: x right, y down, z forward."""
    fx, fy, cx, cy, *k = parameters
    x, y, z = points.T
    if model == "OPENCV_FISHEYE":
        r = np.hypot(x, y)
        angle = np.arctan2(r, z)
        square = angle * angle
        bent = angle * (1.0 + square * (k[0] + square * (k[1] + square * (k[2] + square * k[3]))))
        factor = np.where(r > 1e-12, bent / np.maximum(r, 1e-12), 1.0 / np.maximum(np.abs(z), 1e-12))
        return np.stack([fx * factor * x + cx, fy * factor * y + cy], axis=1)
    x, y = x / z, y / z
    if model == "OPENCV":
        k1, k2, p1, p2, k3 = k
        r2 = x * x + y * y
        radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
        x, y = (
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        )
    return np.stack([fx * x + cx, fy * y + cy], axis=1)


def fit(model: str, pixels: Array, directions: Array, start: Array) -> tuple[Array, Array]:
    """The parameters with the least squares of the distances between the model's places of directions (n, 3) and their pixels (n, 2), from
    fx, fy, cx, cy to begin with; and these distances, (n,)."""
    first = np.concatenate([start, np.zeros(len(DISTORTION[model]))])

    def off(parameters: Array) -> Array:
        return (project(model, parameters, directions) - pixels).ravel()

    # Pixels and coefficients differ in size by thousands.
    best = _levenberg_marquardt(off, first, np.concatenate([np.full(4, start[0]), np.ones(len(first) - 4)]))
    return best, np.linalg.norm(off(best).reshape(-1, 2), axis=1)


def _levenberg_marquardt(off: Callable[[Array], Array], first: Array, scale: Array, steps: int = 60) -> Array:
    """Least squares of `off` by Levenberg-Marquardt with forward differences (Nocedal and Wright 2006, section 10.3)."""
    at, damping = first.copy(), 1e-3
    here = off(at)
    for _ in range(steps):
        slopes = np.stack([(off(at + step) - here) / 1e-6 for step in np.diag(1e-6 * scale)], axis=1)
        normal, right = slopes.T @ slopes, slopes.T @ here
        better = False
        for _ in range(12):
            change = np.linalg.lstsq(normal + damping * np.diag(np.diag(normal) + 1e-30), right, rcond=None)[0]
            there = off(at - scale * change)
            if np.isfinite(there).all() and there @ there < here @ here:
                better = True
                break
            damping *= 10.0
        if not better:
            break
        gain = here @ here - there @ there
        at, here, damping = at - scale * change, there, max(damping / 10.0, 1e-12)
        if gain < 1e-12 * (here @ here) + 1e-20:
            break
    return at
