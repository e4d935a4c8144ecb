# SPDX-License-Identifier: GPL-3.0-or-later
"""The values of a script: its rounded operations by numpy, its real numbers as long decimals."""

from __future__ import annotations

import re
from decimal import Context, Decimal, localcontext
from typing import Any

import numpy as np

from .scripts import Case, read_number

#: Real numbers: sums and products of a script are exact in them or wrong by some 1e-90 of a bound.
DIGITS = 100
#: The numbers of each precision.
NUMBERS = {"f64": np.float64, "f32": np.float32}

Numbers = np.ndarray[Any, Any]
_NUMBER = re.compile(r"(?<![\w.])(\d+(?:\.\d+)?)(?:b(-?\d+)|e(-?\d+))?(?![\w.])")


def real(numbers: Numbers) -> Numbers:
    """The same numbers as exact decimals."""
    if numbers.dtype == object:
        return numbers
    return np.array([Decimal(float(number)) for number in numbers], dtype=object)


class Evaluation:
    """All values of a case's script for arrays of inputs. Call it, and read it, within `exactly()`."""

    def __init__(self, case: Case, inputs: dict[str, Numbers]):
        self._case, self._number = case, NUMBERS[case.precision]
        self.values: dict[str, Numbers] = {}
        text = re.sub(r"#.*", "", case.text("GOALS"))
        statements, block, hints = re.fullmatch(r"(.*)\{(.*?-> GOALS\s*)\}(.*)", text, re.S).groups()  # type: ignore[union-attr]
        # Of the text with comments, for one of them parts the domain from what follows of it.
        domain, _, following = case.text("GOALS").partition("\n{")[2].partition("-> GOALS")[0].partition("# follows")
        self.domain = self._conditions(domain)
        self.following = self._conditions(f"# {following}")
        self.hints = [hint.partition("{")[0].split("->") for hint in hints.split(";") if "->" in hint]
        for statement in filter(None, map(str.strip, statements.split(";"))):
            self._define(statement, inputs)

    def of_domain(self, inputs: dict[str, Numbers]) -> Evaluation:
        """The values at those of the same inputs that are of the domain."""
        fits = self.hold(self.domain)
        with np.errstate(all="raise"):
            return Evaluation(self._case, {name: numbers[fits] for name, numbers in inputs.items()})

    def _define(self, statement: str, inputs: dict[str, Numbers]) -> None:
        if statement.startswith("@"):
            return
        name, is_rounded, formula = re.fullmatch(r"(\w+) (rnd)?= (.*)", statement, re.S).groups()  # type: ignore[union-attr]
        if formula == f"rnd({name}_)":
            self.values[name] = inputs[name].astype(self._number)
        elif is_rounded:
            self.values[name] = self._rounded(formula)
        else:
            self.values[name] = self.exact(formula)

    def _rounded(self, formula: str) -> Numbers:
        """Each operation rounded, as numpy does it."""
        names = {
            name: self._round(numbers) for name, numbers in self.values.items() if re.search(rf"\b{name}\b", formula)
        }
        text = _NUMBER.sub(lambda found: f"number({found[0]!r})", formula)
        return eval(text, {"sqrt": np.sqrt, "number": lambda text: self._number(float(read_number(text)))}, names)

    def _round(self, numbers: Numbers) -> Numbers:
        """Rounded to nearest; of f32, numbers that f64 holds."""
        if numbers.dtype != object:
            return numbers
        doubles = np.array([float(number) for number in numbers])
        if self._number is np.float32 and any(Decimal(float(d)) != x for d, x in zip(doubles, numbers, strict=True)):
            raise ValueError("a real number would be rounded twice")
        return doubles.astype(self._number)

    def exact(self, formula: str) -> Numbers:
        """The value of a formula in real numbers."""
        text = re.sub(r"\|([^|]*)\|", r"abs(\1)", formula)
        if " -/ " in text:
            left, right = text.split(" -/ ")
            text = f"({left} - ({right})) / ({right})"
        names = {name: real(numbers) for name, numbers in self.values.items() if re.search(rf"\b{name}\b", text)}
        text = _NUMBER.sub(lambda found: f"number({found[0]!r})", text)
        functions = {
            "sqrt": np.sqrt,
            "abs": np.abs,
            "number": read_number,
            "rnd": lambda numbers: real(self._round(numbers)),
            "double": lambda numbers: real(np.array([float(number) for number in numbers])),
        }
        return eval(text.strip(), functions, names)

    def _conditions(self, text: str) -> list[tuple[str, str, str]]:
        """Expressions with their least and largest values."""
        found = []
        for part in re.sub(r"#.*", "", text).split("/\\"):
            if between := re.fullmatch(r"\s*(.*) in \[(.*), (.*)\]\s*", part):
                found.append(between.group(1, 2, 3))
            elif at_most := re.fullmatch(r"\s*(.*) <= (.*?)\s*", part):
                found.append((at_most[1], "-1e9", at_most[2]))
            elif part.strip():
                raise ValueError(f"a condition of an unknown form: {part}")
        return found

    def hold(self, conditions: list[tuple[str, str, str]]) -> Numbers:
        """True for the inputs that meet all the conditions."""
        fits: Any = True
        for expression, least, largest in conditions:
            value = self.exact(expression)
            fits = fits & (value >= self.exact(least)) & (value <= self.exact(largest))
        return np.asarray(fits, dtype=bool)


def exactly() -> Any:
    """The context in which decimals are real numbers. What is undefined is not a number, and fits no condition."""
    return localcontext(Context(prec=DIGITS, traps=[]))
