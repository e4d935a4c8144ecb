# SPDX-License-Identifier: GPL-3.0-or-later
"""All rays of cells through a lens, surface by surface.

Each surface is z = sag(x² + y²); the way to it is guessed by Newton's method and proved by the size of what is left. Snell's law is that
of unit normals. Both are other formulas than the prover's.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .enclosures import Enclosure

Array = Any
Vector = list[Enclosure]
#: Newton steps on polynomials.
_STEPS = 7
#: Rims as wide as rounding of their squares may make them, in parts of themselves.
_RIM = 1e-14


@dataclass
class Verdict:
    """The fate of each cell: every ray passes, or none gets past a surface."""

    passes: Array
    stopped: list[Array]


def index_of(medium: dict[str, Any], nm: Enclosure) -> Enclosure:
    """The index at wavelengths, nm, which lie on one side of each end of the formula's range."""
    low, high = medium["range_nm"]
    middle = nm.polynomial[0]
    outside = np.zeros(middle.size, bool)
    at = middle.copy()
    for end, is_beyond in ((low, np.less), (high, np.greater)):
        if end is not None:
            beyond = is_beyond(middle, end)
            at[beyond], outside = end, outside | beyond
    clamped = Enclosure.constant(at)
    keep = np.where(outside, 0.0, 1.0)
    nm = Enclosure(
        np.vstack([np.where(outside, clamped.polynomial[0], nm.polynomial[0])[None], nm.polynomial[1:] * keep]),
        nm.rest * keep,
    )
    value = _formula(medium["formula"], medium["numbers"], nm * 1e-3)
    if medium["is_reciprocal"]:
        value = value.inverse()
    return value.__add__(medium["index_shift"])


def _power(um: Enclosure, power: float) -> Enclosure:
    base = um.inverse() if power < 0 else um
    found = Enclosure.constant(np.ones(um.rest.size))
    if abs(power) % 1 == 0.5:
        found = base.root()
    elif power % 1:
        raise ValueError(f"a power of {power}")
    for _ in range(int(abs(power))):
        found = found * base
    return found


def _formula(word: str, n: list[float], um: Enclosure) -> Enclosure:
    squared = um * um
    zero = Enclosure.constant(np.zeros(um.rest.size))

    def powers(numbers: list[float]) -> Enclosure:
        return sum((_power(um, p) * b for b, p in zip(numbers[::2], numbers[1::2], strict=True)), zero)

    if word == "constant":
        return zero + n[0]
    if word == "sellmeier":
        poles = zip(n[1::2], n[2::2], strict=True)
        return sum((squared * b * (squared - c).inverse() for b, c in poles), zero + (1.0 + n[0])).root()
    if word == "polynomial":
        return (powers(n[1:]) + n[0]).root()
    if word == "rational":
        last = 2 + 2 * int(n[1])
        triples = zip(n[last::3], n[last + 1 :: 3], n[last + 2 :: 3], strict=True)
        return sum(
            (_power(um, p) * b * (squared - c).inverse() for b, p, c in triples), powers(n[2:last]) + n[0]
        ).root()
    if word == "cauchy":
        return powers(n[1:]) + n[0]
    if word == "gas":
        inverse = squared.inverse()
        return sum(((c - inverse).inverse() * b for b, c in zip(n[1::2], n[2::2], strict=True)), zero + (1.0 + n[0]))
    if word == "buchdahl":
        away = um - n[0]
        w = away * (away * n[1] + 1.0).inverse()
        return w * (w * n[4] + n[3]) + n[2]
    if word == "herzberger":
        x = (squared - 0.028).inverse()
        return x * (x * n[2] + n[1]) + squared * (squared * (squared * n[5] + n[4]) + n[3]) + n[0]
    raise ValueError(f"glass formula {word}")


def _dot(a: Vector, b: Vector) -> Enclosure:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _profile(surface: dict[str, Any], u: Enclosure) -> tuple[Enclosure, Enclosure]:
    """Sag and its derivative by u = x² + y²."""
    c, k = surface["curvature_per_mm"], surface["conic"]
    zero = Enclosure.constant(np.zeros(u.rest.size))
    sag, slope = zero, zero
    if c:
        w = (1.0 - u * ((1.0 + k) * c * c)).root()
        sag = u * c * (w + 1.0).inverse()
        slope = w.inverse() * (0.5 * c)
    for power, a in surface["terms"]:
        radius = None
        if power % 2:
            high = np.sqrt(np.maximum(u.bounds()[1], 0.0)) * (1 + 1e-12)
            radius = u.root()
            crude = Enclosure.constant(0.5 * high).widened(0.5 * high)
            better = np.isfinite(radius.rest) & (radius.rest < crude.rest)
            radius = Enclosure(
                np.where(better, radius.polynomial, crude.polynomial), np.where(better, radius.rest, crude.rest)
            )
        below = Enclosure.constant(np.ones(u.rest.size))
        for _ in range(power // 2 - 1):
            below = below * u
        if radius is not None:
            below = below * radius
        sag = sag + below * u * a
        slope = slope + below * (0.5 * power * a)
    return sag, slope


def _at(p: Vector, d: Vector, t: Enclosure) -> Vector:
    return [p[i] + d[i] * t for i in range(3)]


def _crossing(surface: dict[str, Any], p: Vector, d: Vector) -> tuple[Vector, Enclosure, Array]:
    """Hits and slope of the sag there, and where they are proved to be hits with the right sign of N · D."""
    side = surface["side"]

    def function(t: Enclosure) -> tuple[Enclosure, Enclosure]:
        at = _at(p, d, t)
        sag, slope = _profile(surface, at[0] * at[0] + at[1] * at[1])
        return at[2] - sag, d[2] - (at[0] * d[0] + at[1] * d[1]) * slope * 2.0

    t = -p[2] * d[2].inverse()
    t = t.alone()
    for _ in range(_STEPS):
        value, slope = function(t)
        t = (t - value * slope.inverse()).alone()
    error = function(t)[0].size
    least = (function(t.widened(4.0 * error))[1] * side).bounds()[0]
    proved = (least > 0.26) | (error * 1.001 <= 4.0 * error * least)
    proved &= (least > 0) & np.isfinite(error)
    t = t.widened(np.where(proved, error / np.where(proved, least, 1.0) * (1 + 1e-9), np.inf))
    at = _at(p, d, t)
    sag, slope = _profile(surface, at[0] * at[0] + at[1] * at[1])
    better = sag.rest < at[2].rest
    at[2] = Enclosure(np.where(better, sag.polynomial, at[2].polynomial), np.where(better, sag.rest, at[2].rest))
    return at, slope, proved


def _beside(surface: dict[str, Any], p: Vector, d: Vector) -> Array:
    """True where no ray comes through the cap within the clear aperture: outside of the rim at every height of it."""
    c, k, rim = surface["curvature_per_mm"], surface["conic"], surface["clear_squared_mm2"]
    inside = 1.0 - (1.0 + k) * c * c * rim
    if surface["terms"] or inside < 0:
        return np.zeros(p[0].rest.size, bool)
    sag = c * rim / (1.0 + inside**0.5)
    z = Enclosure.constant(np.full(p[0].rest.size, 0.5 * sag)).widened(0.5 * abs(sag) * (1 + 1e-9))
    at = _at(p, d, (z - p[2]) * d[2].inverse())
    return (at[0] * at[0] + at[1] * at[1]).bounds()[0] > rim * (1 + _RIM)


def _missed(surface: dict[str, Any], p: Vector, d: Vector) -> Array:
    """True where the quadratic of a conicoid has no root."""
    c, k = surface["curvature_per_mm"], surface["conic"]
    if surface["terms"] or not c:
        return np.zeros(p[0].rest.size, bool)
    a = (d[2] * d[2] * k + 1.0) * c
    b = (_dot(p, d) + p[2] * d[2] * k) * c - d[2]
    e = (_dot(p, p) + p[2] * p[2] * k) * c - p[2] * 2.0
    return (b * b - a * e).bounds()[1] < 0


def followed(certificate: dict[str, Any], p: Vector, d: Vector, nm: Enclosure) -> Verdict:
    """The fates of the rays from `p`, seen from the last vertex, along `d`."""
    count = nm.rest.size
    indices = [index_of(medium, nm) for medium in certificate["media"]]
    surfaces = certificate["surfaces"]
    passes = np.ones(count, bool)
    followed_here = np.ones(count, bool)
    stopped = [np.zeros(count, bool) for _ in surfaces]
    for surface in surfaces:
        p = [p[0], p[1], p[2] + surface["to_here_mm"]]
        at, slope, proved = _crossing(surface, p, d)
        u = at[0] * at[0] + at[1] * at[1]
        low, high = u.bounds()
        rim, inner = surface["clear_squared_mm2"], surface["obstruction_squared_mm2"]
        opening = certificate["opening_mm"] ** 2 if surface["is_stop"] else np.inf
        out = proved & ((low > rim * (1 + _RIM)) | (low > opening * (1 + _RIM)))
        through = proved & (high < rim * (1 - _RIM)) & (high < opening * (1 - _RIM))
        if inner > 0:
            out |= proved & (high < inner * (1 - _RIM))
            through &= low > inner * (1 + _RIM)
        out |= _beside(surface, p, d) | _missed(surface, p, d)
        normal = [-at[0] * slope * 2.0, -at[1] * slope * 2.0, Enclosure.constant(np.ones(count))]
        length = (u * slope * slope * 4.0 + 1.0).root().inverse()
        normal = [x * length for x in normal]
        cosine = _dot(normal, d) * surface["side"]
        if surface["action"] == "refract":
            leaves, enters = (indices[i] for i in surface["media"])
            m = leaves * enters.inverse()
            inside = 1.0 - m * m * (1.0 - cosine * cosine)
            out |= proved & (inside.bounds()[1] < 0)
            bend = (inside.root() - m * cosine) * surface["side"]
            d = [d[i] * m + normal[i] * bend for i in range(3)]
        elif surface["action"] == "reflect":
            twice = cosine * (2.0 * surface["side"])
            d = [d[i] - normal[i] * twice for i in range(3)]
        stopped[surface["surface"]] = followed_here & out
        followed_here &= proved & np.isfinite(d[0].rest) & np.isfinite(d[1].rest) & np.isfinite(d[2].rest)
        passes &= through & followed_here
        d = [d[0], d[1], _along(d)]
        p = at
    return Verdict(passes, stopped)


def _along(d: Vector) -> Enclosure:
    """z of a unit direction from x and y, where that says more."""
    root = (1.0 - (d[0] * d[0] + d[1] * d[1])).root() * np.sign(d[2].polynomial[0])
    low, high = d[2].bounds()
    better = ((low > 0) | (high < 0)) & (root.rest < d[2].rest)
    return Enclosure(np.where(better, root.polynomial, d[2].polynomial), np.where(better, root.rest, d[2].rest))
