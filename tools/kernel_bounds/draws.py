# SPDX-License-Identifier: GPL-3.0-or-later
"""Random inputs of the scripts, near the edges of their domains as often as inside, and the largest errors there."""

from __future__ import annotations

import math
import random
from collections.abc import Callable

import numpy as np

from .evaluation import NUMBERS, Evaluation
from .scripts import Case

#: Random inputs of each case. More find no errors that are much larger.
DRAWS = 2000

Vector = tuple[float, float, float]


def unit_vector(dice: random.Random, least_z: float = -1.0) -> Vector:
    while True:
        v = (dice.uniform(-1, 1), dice.uniform(-1, 1), dice.uniform(-1, 1))
        length = math.sqrt(sum(x * x for x in v))
        if 0.1 < length < 1.0 and v[2] / length >= least_z:
            return (v[0] / length, v[1] / length, v[2] / length)


def at_angle(dice: random.Random, normal: Vector, cosine: float) -> Vector:
    """A unit vector whose product with the normal is `cosine`."""
    while True:
        v = unit_vector(dice)
        along = sum(a * b for a, b in zip(v, normal, strict=True))
        length = math.sqrt(max(1.0 - along * along, 0.0))
        if length > 0.1:
            sine = math.sqrt(max(1.0 - cosine * cosine, 0.0))
            x, y, z = (cosine * n + sine * (a - along * n) / length for a, n in zip(v, normal, strict=True))
            return (x, y, z)


def between(dice: random.Random, least: float, largest: float) -> float:
    """A number that is uniform, or whose logarithm is, or near the least: each as often."""
    return dice.choice(
        (
            dice.uniform(least, largest),
            least * (largest / least) ** dice.random(),
            min(largest, least * dice.uniform(1.0, 1.02)),
        )
    )


def draw_interface(dice: random.Random, case: Case) -> dict[str, float]:
    index = dice.uniform(1.0, 2.5)
    other = dice.choice((dice.uniform(1.0, 2.5), index * (1.0 + dice.choice((-1, 1)) * between(dice, 1e-15, 0.1))))
    return {"n1": index, "n2": other}


def draw_plane(dice: random.Random, case: Case) -> dict[str, float]:
    dz, t = between(dice, 2.0**-20, 1.0), dice.choice((-1, 1)) * between(dice, 1e-6, 1.0)
    return {"px": dice.uniform(-1, 1), "pz": -t * dz, "dx": dice.uniform(-1, 1) * math.sqrt(1 - dz * dz), "dz": dz}


def draw_sphere(dice: random.Random, case: Case) -> dict[str, float]:
    c, start = dice.uniform(0.5, 1.0), float(case.parameters.get("START", 0.99))
    normal = unit_vector(dice, 0.52)
    d = at_angle(dice, normal, between(dice, float(case.parameters["FLOOR"]), 1.0))
    hit = (-normal[0] / c, -normal[1] / c, (1.0 - normal[2]) / c)
    nearest = sum(a * b for a, b in zip(hit, d, strict=True))
    way = dice.choice((nearest, dice.uniform(-min(start, 1.0), start) / c))
    p = [a - way * b for a, b in zip(hit, d, strict=True)]
    return dict(zip(("px", "py", "pz", "dx", "dy", "dz", "c"), (*p, *d, c), strict=True))


def _refraction(dice: random.Random, from_: float, to: float, cosine: float) -> dict[str, float]:
    normal = unit_vector(dice)
    axis, d = dice.randrange(3), at_angle(dice, normal, cosine)
    return {
        "m": from_ / to,
        "e": (from_ - to) * (from_ + to) / (to * to),
        "q": cosine * cosine,
        "d": d[axis],
        "n": normal[axis],
    }


def draw_denser(dice: random.Random, case: Case) -> dict[str, float]:
    to = dice.uniform(1.0, 2.0)
    return _refraction(
        dice, dice.choice((dice.uniform(1.0, to), to / (1.0 + between(dice, 1e-7, 0.1)))), to, between(dice, 1e-5, 1.0)
    )


def draw_rarer(dice: random.Random, case: Case) -> dict[str, float]:
    highest = 0.101 if case.kernel == "refraction_critical" else 1.0
    while True:
        from_, to = dice.uniform(1.0, 2.0), 1.0
        s = between(dice, float(case.parameters["FLOOR"]), highest)
        # m^2 cos^2 i (1 - S^2) = m^2 - 1.
        squared = (from_ * from_ - 1.0) / (from_ * from_) / max(1.0 - s * s, 1e-9)
        if squared <= 1.0:
            return _refraction(dice, from_, to, math.sqrt(squared))


def draw_reflection(dice: random.Random, case: Case) -> dict[str, float]:
    normal, cosine, axis = unit_vector(dice), between(dice, 1e-5, 1.0), dice.randrange(3)
    return {"d": at_angle(dice, normal, cosine)[axis], "n": normal[axis], "w": cosine}


DRAW: dict[str, Callable[[random.Random, Case], dict[str, float]]] = {
    "interface": draw_interface,
    "plane": draw_plane,
    "sphere": draw_sphere,
    "sphere_grazing": draw_sphere,
    "refraction_denser": draw_denser,
    "refraction_rarer": draw_rarer,
    "refraction_critical": draw_rarer,
    "reflection": draw_reflection,
}


def drawn(case: Case, seed: int = 1, draws: int = DRAWS) -> Evaluation:
    """The script's values at random inputs of the domain. Python's generator gives the same in every version."""
    dice = random.Random(f"{case.name} {seed}")
    rows = [DRAW[case.kernel](dice, case) for _ in range(draws)]
    inputs = {name: np.array([row[name] for row in rows]).astype(NUMBERS[case.precision]) for name in rows[0]}
    with np.errstate(all="ignore"):
        everywhere = Evaluation(case, inputs)
    return everywhere.of_domain(inputs)


def largest_errors(case: Case, values: Evaluation) -> dict[str, float]:
    """The largest error of each goal in u."""
    return {name: float(max(np.abs(values.exact(goal))) / case.unit) for name, (goal, _) in case.goals.items()}
