# SPDX-License-Identifier: GPL-3.0-or-later
"""The scripts of engine/proof/gappa, their cases, and the bounds that Gappa proves."""

from __future__ import annotations

import re
import subprocess
from dataclasses import dataclass
from decimal import Decimal
from functools import cached_property
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SCRIPTS = ROOT / "engine/proof/gappa"
#: Bits of the significand, and Gappa's name.
FORMATS = {"f64": (53, "ieee_64"), "f32": (24, "ieee_32")}
#: Gappa takes some seconds at most.
GAPPA_SECONDS = 120


@dataclass(frozen=True)
class Case:
    """A kernel in one precision on one domain."""

    kernel: str
    precision: str
    parameters: dict[str, str]
    #: Claimed bounds of the goals in units of u.
    claims: dict[str, Decimal]

    @property
    def name(self) -> str:
        return ",".join([self.kernel, self.precision, *(f"{key}={value}" for key, value in self.parameters.items())])

    @property
    def unit(self) -> Decimal:
        """u: half of the distance from 1 to the next number."""
        return Decimal(2) ** -FORMATS[self.precision][0]

    @cached_property
    def source(self) -> str:
        return (SCRIPTS / f"{self.kernel}.g").read_text(encoding="utf-8")

    @property
    def goals(self) -> dict[str, tuple[str, str]]:
        """The expression of each goal that is bounded, and what it is a part of."""
        return {
            name: (expression, of)
            for name, expression, of in re.findall(r"^# goal (\w+): (.*), (of .*)$", self.source, re.M)
        }

    def head(self, key: str) -> str:
        """A line of the script's head; empty without it."""
        found = re.search(rf"^# {key}: (.*)$", self.source, re.M)
        return self._with_parameters(found[1]) if found else ""

    def script(self) -> str:
        """The text for Gappa, which is asked for the bounds: where it is given them, it halves the domain for hours if one is too low."""
        return self.text(" /\\ ".join(f"{expression} in ?" for expression, _ in self.goals.values()))

    def text(self, goals: str) -> str:
        """The script of this case, which ends in these goals."""
        other = "f32" if self.precision == "f64" else "f64"
        lines = [line for line in self.source.splitlines() if not line.endswith(f"# not {self.precision}")]
        lines = [
            line.removesuffix(f"# not {other}").rstrip() for line in lines if not re.match(r"# (case|goal) ", line)
        ]
        text = re.sub(r"\bFORMAT\b", FORMATS[self.precision][1], "\n".join(lines))
        return self._with_parameters(text).replace("GOALS", goals) + "\n"

    def _with_parameters(self, text: str) -> str:
        for key, value in self.parameters.items():
            text = re.sub(rf"\b{key}_SQUARED\b", f"{float(value) ** 2:.17g}", text)
            text = re.sub(rf"\b{key}\b", value, text)
        return text


def cases() -> list[Case]:
    """All cases of all scripts."""
    found = []
    for path in sorted(SCRIPTS.glob("*.g")):
        for precision, parameters, claims in re.findall(
            r"^# case (f\d\d)(.*?): (.*)$", path.read_text(encoding="utf-8"), re.M
        ):
            values = dict(part.split("=") for part in parameters.split())
            bounds = {name: Decimal(bound) for name, bound in re.findall(r"(\w+) ([\d.]+)", claims)}
            found.append(Case(path.stem, precision, values, bounds))
    return found


def read_number(text: str) -> Decimal:
    """A number as Gappa writes it: 12b-3 is 12 / 8."""
    digits, _, power = text.partition("b")
    return Decimal(digits) * Decimal(2) ** int(power or 0)


def normal(expression: str) -> str:
    """An expression without spaces and parentheses, as Gappa may print it otherwise."""
    return re.sub(r"[\s()]", "", expression)


def trusted(text: str) -> set[str]:
    """The rewritings that follow from S^2 = x where S = sqrt(x), which Gappa does not see: those under a comment that says so."""
    found = re.findall(r"^# by square roots.*\n(?:#.*\n)*([^{;]*?)\s*->\s*([^{;]*)", text, re.M)
    return {f"{normal(left)}and{normal(right)}" for left, right in found}


def complaint(text: str, said: str) -> str | None:
    """Why the output of Gappa is no proof; None if it is one of all that it lists."""
    for warning in re.findall(r"Warning: (.*)", said):
        equal = re.fullmatch(r"(.*) are not trivially equal\.", warning)
        if equal and normal(equal[1]) in trusted(text) or warning.startswith("no need for the rewriting"):
            continue
        return warning
    return None if "Results" in said or "not satisfied" in said else (said.strip().splitlines() or ["no result"])[0]


def proved(case: Case) -> dict[str, Decimal | None]:
    """The bounds in u that Gappa proves; None where it proves none."""
    text = case.script()
    try:
        done = subprocess.run(["gappa"], input=text, capture_output=True, text=True, check=False, timeout=GAPPA_SECONDS)
    except subprocess.TimeoutExpired:
        raise SystemExit(f"kernel_bounds: {case.name}: gappa was not done after {GAPPA_SECONDS} s") from None
    said = f"{done.stdout}\n{done.stderr}"
    if why := complaint(text, said):
        raise SystemExit(f"kernel_bounds: {case.name}: {why}")
    found: dict[str, Decimal | None] = {}
    for name, (expression, _) in case.goals.items():
        lines = [line for line in said.splitlines() if normal(line).startswith(f"{normal(expression)}in[")]
        ends = re.findall(r"(?<=[\[ ])-?\d+(?:b-?\d+)?(?=[\], ])", lines[0].partition(" in ")[2]) if lines else []
        found[name] = max(abs(read_number(end)) for end in ends) / case.unit if len(ends) == 2 else None
    return found


def failures(case: Case) -> list[str]:
    """A line for each goal of the case that Gappa does not prove."""
    found = []
    for name, bound in proved(case).items():
        claim, expression = case.claims.get(name), case.goals[name][0]
        if claim is None:
            found.append(f"{case.name}: no bound of {name} is claimed: {expression}")
        elif bound is None or bound > claim:
            least = "none" if bound is None else f"{bound:.9g} u"
            found.append(f"{case.name}: {name} is not proved to be within {claim} u, but {least}: {expression}")
    return found
