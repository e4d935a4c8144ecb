# SPDX-License-Identifier: GPL-3.0-or-later
"""Enclosures of functions of four variables in -1 to 1, many at a time: a cubic polynomial each, and a bound of the remainder."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np

_ORDER = 3
#: Powers of the four variables, by rising degree.
POWERS = sorted((p for p in product(range(_ORDER + 1), repeat=4) if sum(p) <= _ORDER), key=lambda p: (sum(p), p))
_PLACE = {powers: i for i, powers in enumerate(POWERS)}
_DEGREE = np.array([sum(powers) for powers in POWERS])
_EVEN = np.array([all(p % 2 == 0 for p in powers) and sum(powers) > 0 for powers in POWERS])
_ODD = np.array([any(p % 2 for p in powers) for powers in POWERS])
#: For each monomial those that it may be multiplied with, and where the products stand.
_PARTNERS = [
    (
        np.array([j for j in range(len(POWERS)) if _DEGREE[i] + _DEGREE[j] <= _ORDER]),
        np.array(
            [
                _PLACE[tuple(a + b for a, b in zip(POWERS[i], POWERS[j], strict=True))]
                for j in range(len(POWERS))
                if _DEGREE[i] + _DEGREE[j] <= _ORDER
            ]
        ),
    )
    for i in range(len(POWERS))
]
#: A sum of n <= 200 products of doubles is off by less than (n + 1) 2^-53 of the sum of their sizes, 2.3e-14: more than that.
_ROUNDING = 5e-14

Array = Any


class Enclosure:
    """`polynomial` (coefficients by rows, functions by columns) and `rest` >= |function - polynomial|."""

    __slots__ = ("polynomial", "rest")

    def __init__(self, polynomial: Array, rest: Array) -> None:
        self.polynomial, self.rest = polynomial, rest

    @staticmethod
    def constant(values: Array) -> Enclosure:
        values = np.asarray(values, float)
        polynomial = np.zeros((len(POWERS), values.size))
        polynomial[0] = values
        return Enclosure(polynomial, np.zeros(values.size))

    @staticmethod
    def between(low: Array, high: Array, variable: int) -> Enclosure:
        """The numbers from `low` to `high`, as a function of one variable."""
        found = Enclosure.constant(0.5 * (low + high))
        powers = [0, 0, 0, 0]
        powers[variable] = 1
        found.polynomial[_PLACE[tuple(powers)]] = 0.5 * (high - low)
        return Enclosure(found.polynomial, _ROUNDING * (np.abs(low) + np.abs(high)))

    @staticmethod
    def of_terms(terms: dict[tuple[int, ...], Array], count: int) -> Enclosure:
        polynomial = np.zeros((len(POWERS), count))
        for powers, values in terms.items():
            polynomial[_PLACE[powers]] = values
        return Enclosure(polynomial, np.zeros(count))

    @property
    def size(self) -> Array:
        return np.abs(self.polynomial).sum(0) * (1 + _ROUNDING) + self.rest

    def bounds(self) -> tuple[Array, Array]:
        """No value is below the first or above the second."""
        odd = np.abs(self.polynomial[_ODD]).sum(0)
        even = self.polynomial[_EVEN]
        slack = self.rest + _ROUNDING * self.size
        middle = self.polynomial[0]
        return middle - odd + np.minimum(even, 0).sum(0) - slack, middle + odd + np.maximum(even, 0).sum(0) + slack

    def _rounded(self) -> Enclosure:
        return Enclosure(self.polynomial, self.rest * (1 + _ROUNDING) + _ROUNDING * np.abs(self.polynomial).sum(0))

    def __add__(self, other: Any) -> Enclosure:
        if isinstance(other, Enclosure):
            return Enclosure(self.polynomial + other.polynomial, self.rest + other.rest)._rounded()
        polynomial = self.polynomial.copy()
        polynomial[0] += other
        return Enclosure(polynomial, self.rest)._rounded()

    __radd__ = __add__

    def __neg__(self) -> Enclosure:
        return Enclosure(-self.polynomial, self.rest)

    def __sub__(self, other: Any) -> Enclosure:
        return self.__add__(-other)

    def __rsub__(self, other: Any) -> Enclosure:
        return (-self).__add__(other)

    def __mul__(self, other: Any) -> Enclosure:
        if not isinstance(other, Enclosure):
            return Enclosure(self.polynomial * other, self.rest * np.abs(other))._rounded()
        a, b = self.polynomial, other.polynomial
        polynomial = np.zeros_like(a)
        for i, (partners, places) in enumerate(_PARTNERS):
            polynomial[places] += a[i] * b[partners]
        by_degree = [[np.abs(x[degree == _DEGREE]).sum(0) for degree in range(_ORDER + 1)] for x in (a, b)]
        cut = sum(
            by_degree[0][i] * by_degree[1][j] for i in range(_ORDER + 1) for j in range(_ORDER + 1) if i + j > _ORDER
        )
        a_size, b_size = np.abs(a).sum(0), np.abs(b).sum(0)
        rest = a_size * other.rest + b_size * self.rest + self.rest * other.rest + cut + _ROUNDING * a_size * b_size
        return Enclosure(polynomial, rest * (1 + _ROUNDING) + 1e-300)

    __rmul__ = __mul__

    def inverse(self) -> Enclosure:
        """1 / f by its series about the middle: with f = m (1 - x), |x| <= q < 1, the part cut off is at most q^4 / (m (1 - q))."""
        middle = self.polynomial[0]
        x = 1.0 - self * (1.0 / middle)
        q = x.size
        series = 1.0 + x * (1.0 + x * (1.0 + x))
        lost = np.where(q < 0.9, q**4 / (1.0 - np.minimum(q, 0.9)), np.inf)
        found = series * (1.0 / middle)
        return Enclosure(found.polynomial, found.rest + lost / np.abs(middle) * (1 + 1e-9))

    def root(self) -> Enclosure:
        """The square root by its series about the middle: with f = m (1 + x), |x| <= q < 1, the fourth term is at most 5/128 q^4 / (1 - q)^3.5."""
        middle = self.polynomial[0]
        safe = np.where(middle > 0, middle, np.nan)
        x = self * (1.0 / safe) - 1.0
        q = x.size
        series = 1.0 + x * (0.5 + x * (-0.125 + x * 0.0625))
        lost = np.where(q < 0.9, 5 / 128 * q**4 / (1.0 - np.minimum(q, 0.9)) ** 3.5, np.inf)
        found = series * np.sqrt(safe)
        return Enclosure(found.polynomial, found.rest + lost * np.sqrt(safe) * (1 + 1e-9))

    def widened(self, more: Array) -> Enclosure:
        return Enclosure(self.polynomial, self.rest + more)

    def alone(self) -> Enclosure:
        """The polynomial without the rest: a guess."""
        return Enclosure(self.polynomial, np.zeros_like(self.rest))
