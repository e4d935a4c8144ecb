#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays through the Liou-Brennan eye, found in another way than the engine's: writes tests/reference/gradient-rays.json.

In the gradients the canonical equations of rays with z as the parameter (Luneburg, Mathematical Theory of Optics, section 2),
dx/dz = p / h, dp/dz = n n_x / h, h = sqrt(n^2 - p^2 - q^2), are solved by the method of Runge and Kutta with 4000 steps; the
hits are found by bisection on the last step. Plain Python, no libraries, no code of the engine.
"""

from __future__ import annotations

import json
import math
from pathlib import Path

STEPS = 4000


def dispersion(um: float) -> float:
    return 0.0512 - 0.1455 * um + 0.0961 * um * um


# Radius, conic constant, thickness, index at 0.555 um, gradient (z, z^2, r^2) of the medium behind.
EYE = [
    (7.77, -0.18, 0.5, 1.376, None),
    (6.4, -0.6, 3.16, 1.336, None),
    (12.4, -0.94, 1.59, 1.368, (0.049057, -0.015427, -0.001978)),
    (0.0, 0.0, 2.43, 1.407, (0.0, -0.006605, -0.001978)),
    (-8.1, 0.96, 16.27, 1.336, None),
]


def sag(radius: float, conic: float, x: float, y: float) -> float:
    if radius == 0.0:
        return 0.0
    square = (x * x + y * y) / (radius * radius)
    return radius * square / (1.0 + math.sqrt(1.0 - (1.0 + conic) * square))


def normal(radius: float, conic: float, x: float, y: float) -> tuple[float, float, float]:
    """The gradient of z - sag, to unit length."""
    if radius == 0.0:
        return (0.0, 0.0, 1.0)
    root = math.sqrt(1.0 - (1.0 + conic) * (x * x + y * y) / (radius * radius))
    nx, ny = -x / (radius * root), -y / (radius * root)
    length = math.sqrt(nx * nx + ny * ny + 1.0)
    return (nx / length, ny / length, 1.0 / length)


def index(base: float, terms: tuple[float, float, float] | None, x: float, y: float, z: float) -> float:
    if terms is None:
        return base
    a, b, c = terms
    return base + a * z + b * z * z + c * (x * x + y * y)


def rates(base: float, terms: tuple[float, float, float], state: list[float], z: float) -> list[float]:
    x, y, p, q = state
    a, b, c = terms
    n = index(base, terms, x, y, z)
    h = math.sqrt(n * n - p * p - q * q)
    return [p / h, q / h, n * 2.0 * c * x / h, n * 2.0 * c * y / h]


def step(base: float, terms: tuple[float, float, float], state: list[float], z: float, dz: float) -> list[float]:
    def moved(by: list[float], length: float) -> list[float]:
        return [s + length * k for s, k in zip(state, by, strict=True)]

    k1 = rates(base, terms, state, z)
    k2 = rates(base, terms, moved(k1, dz / 2), z + dz / 2)
    k3 = rates(base, terms, moved(k2, dz / 2), z + dz / 2)
    k4 = rates(base, terms, moved(k3, dz), z + dz)
    return moved([(a + 2 * b + 2 * c + d) / 6 for a, b, c, d in zip(k1, k2, k3, k4, strict=True)], dz)


def straight(
    at: tuple[float, float, float], along: tuple[float, float, float], radius: float, conic: float
) -> tuple[float, float, float]:
    """The hit of a straight ray on a surface, by bisection."""

    def there(t: float) -> tuple[float, float, float]:
        return (at[0] + along[0] / along[2] * t, at[1] + along[1] / along[2] * t, at[2] + t)

    low, high = -at[2] - 4.0, -at[2] + 4.0
    for _ in range(200):
        t = (low + high) / 2
        x, y, z = there(t)
        if radius and (1.0 + conic) * (x * x + y * y) >= radius * radius:
            raise ValueError("the ray goes beyond the surface")
        low, high = (low, t) if z > sag(radius, conic, x, y) else (t, high)
    return there((low + high) / 2)


def trace(origin: list[float], direction: list[float], um: float) -> dict:
    shift = dispersion(um)
    x, y, z = origin
    n, terms, base = 1.0, None, 1.0
    p, q = direction[0], direction[1]
    before = 0.0
    hits = []
    for radius, conic, thickness, behind, gradient in EYE:
        # To the surface, z counted from its vertex.
        if terms is None:
            x, y, z = straight((x, y, z), (p, q, math.sqrt(n * n - p * p - q * q)), radius, conic)
        else:
            # Where the medium's own vertex lies.
            start = -before
            state = [x, y, p, q]
            dz = -z / STEPS * 1.5
            while True:
                ahead = step(base, terms, state, z - start, dz)
                if z + dz >= sag(radius, conic, ahead[0], ahead[1]):
                    break
                state, z = ahead, z + dz
            low, high = 0.0, dz
            for _ in range(80):
                part = (low + high) / 2
                ahead = step(base, terms, state, z - start, part)
                low, high = (low, part) if z + part > sag(radius, conic, ahead[0], ahead[1]) else (part, high)
            state, z = step(base, terms, state, z - start, (low + high) / 2), z + (low + high) / 2
            x, y, p, q = state
            n = index(base, terms, x, y, z - start)
        hits.append([x, y, z])
        # Refraction: the part of n d along the surface stays (Snell).
        nx, ny, nz = normal(radius, conic, x, y)
        n2 = index(behind + shift, gradient, x, y, z)
        v = (p, q, math.sqrt(n * n - p * p - q * q))
        along = v[0] * nx + v[1] * ny + v[2] * nz
        root = math.sqrt(n2 * n2 - n * n + along * along)
        p, q = v[0] + (root - along) * nx, v[1] + (root - along) * ny
        n, terms, base, before = n2, gradient, behind + shift, thickness
        z -= thickness
    z += EYE[-1][2]
    h = math.sqrt(n * n - p * p - q * q)
    return {"hits": hits, "origin": [x, y, z], "direction": [p / n, q / n, h / n]}


def main() -> None:
    rays = []
    for um in (0.4358, 0.555, 0.6563):
        for angle in (0.0, 10.0, 30.0, 45.0):
            for height in (-1.5, 0.0, 0.4, 1.8):
                slope = math.radians(angle)
                across = 0.03 * height
                direction = [across, math.sin(slope), 0.0]
                direction[2] = math.sqrt(1.0 - across * across - direction[1] ** 2)
                # Towards the entrance pupil, about 3 mm behind the cornea.
                t = 13.0 / direction[2]
                origin = [0.3 - direction[0] * t, height - direction[1] * t, -10.0]
                rays.append({"um": um, "from": origin, "along": direction, **trace(origin, direction, um)})
    out = Path(__file__).resolve().parent.parent / "tests/reference/gradient-rays.json"
    lines = ",\n".join(json.dumps(ray) for ray in rays)
    out.write_text(
        f'{{"lens": "eye-liou-brennan", "made_by": "tools/reference-gradients.py", "rays": [\n{lines}\n]}}\n'
    )


if __name__ == "__main__":
    main()
