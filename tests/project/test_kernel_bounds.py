# SPDX-License-Identifier: GPL-3.0-or-later
"""The bounds of the kernels' rounding errors are proved by Gappa, stand on the page, and are of what the compiled kernels do."""

from __future__ import annotations

import json
import math
import random
import shutil
from decimal import Decimal

import numpy as np
import pages
import pytest
from kernel_bounds.__main__ import MISSING, PAGE, main, table
from kernel_bounds.draws import DRAW, at_angle, drawn, largest_errors, unit_vector
from kernel_bounds.evaluation import NUMBERS, Evaluation, exactly
from kernel_bounds.scripts import SCRIPTS, Case, cases, complaint, failures

from support.command_line import answer

pytestmark = pytest.mark.once

CASES = cases()
#: Decimals of 100 digits keep at least these of a difference of nearly equal numbers.
LOST = Decimal("1e-60")


# Gappa -----------------------------------------------------------------------------------------------------------


@pytest.fixture
def gappa():
    if not shutil.which("gappa"):
        pytest.skip(MISSING)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_gappa_proves_every_goal(case, gappa):
    assert failures(case) == []


def test_every_script_has_cases_of_both_precisions_and_every_goal_a_claim():
    kernels = {path.stem for path in SCRIPTS.glob("*.g")}
    assert {(case.kernel, case.precision) for case in CASES} == {(kernel, p) for kernel in kernels for p in NUMBERS}
    assert kernels == DRAW.keys()
    for case in CASES:
        assert case.claims.keys() == case.goals.keys(), case.name


def test_a_claim_that_is_too_small_is_one_line_that_names_it(gappa):
    case = next(case for case in CASES if case.kernel == "reflection")
    halved = Case(case.kernel, case.precision, case.parameters, {"direction": case.claims["direction"] / 2})
    (line,) = failures(halved)
    assert line.startswith("reflection,f") and "direction is not proved to be within" in line and "\n" not in line


def test_a_rewriting_that_gappa_does_not_see_is_no_proof_unless_it_is_a_root():
    said = "Warning: X and {} are not trivially equal.\nResults:\n  x in [1, 2]\n"
    text = "# by square roots: X.\nX -> Y * Y;\nX -> Z;\n"
    assert complaint(text, said.format("Y * Y")) is None
    assert complaint(text, said.format("Z")) == "X and Z are not trivially equal."
    assert complaint(text, "Error: syntax error") == "Error: syntax error"


def test_the_table_on_the_page_is_the_one_that_is_made_now():
    """Its bounds, the errors of drawn inputs, and what docs/numerics.md has: `make proofs` renews it."""
    text = PAGE.read_text(encoding="utf-8")
    assert pages.filled(text, "kernels", table(CASES)) == text


def test_without_gappa_a_line_says_what_to_install(monkeypatch, capsys):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    for options, status in ([], 1), (["--if-there"], 0):
        monkeypatch.setattr("sys.argv", ["kernel_bounds", *options])
        assert main() == status
        assert capsys.readouterr().err == f"{MISSING}\n"


# Random inputs ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_errors_of_random_inputs_are_within_the_bounds(case):
    # Other inputs than those of the page.
    with exactly():
        values = drawn(case, seed=2)
        assert len(next(iter(values.values.values()))) > 1000
        for name, error in largest_errors(case, values).items():
            assert error <= case.claims[name], name
        for expression, least, largest in values.following:
            value = values.exact(expression)
            assert all(value >= values.exact(least) - LOST) and all(value <= values.exact(largest) + LOST), expression
        for left, right in values.hints:
            assert max(abs(values.exact(left.strip()) - values.exact(right.strip()))) < LOST, (left, right)


# The compiled kernels --------------------------------------------------------------------------------------------

RAYS = 400
#: CANCELLED of conic.rs and NEAR_CRITICAL of interface.rs.
CANCELLED = NEAR_CRITICAL = 0.01


def columns(rows: list[list[float]]) -> list[np.ndarray]:
    return list(np.array(rows).T)


def rays(dice: random.Random, is_plane: bool) -> tuple[list[dict], list[np.ndarray]]:
    """Cases of `petzval surface trace`, all alike in form, and their numbers: origin, direction, radius, indices."""
    rows = []
    for _ in range(RAYS):
        radius = 0.0 if is_plane else dice.uniform(5.0, 80.0)
        normal = (0.0, 0.0, 1.0) if is_plane else unit_vector(dice, 0.4)
        cosine = dice.choice((dice.uniform(0.05, 1.0), 10.0 ** dice.uniform(-3, -0.5)))
        d = at_angle(dice, normal, cosine)
        hit = [-radius * normal[0], -radius * normal[1], radius * (1 - normal[2])]
        way = dice.uniform(-1.0, 3.0) * (radius or 30.0)
        if is_plane:
            hit = [dice.uniform(-20, 20), dice.uniform(-20, 20), 0.0]
        glass = 1.5 + 0.3 * dice.random()
        critical = glass * math.sqrt(1.0 - cosine * cosine) * (1.0 + 10.0 ** dice.uniform(-5, -2.5))
        rows.append(
            [
                *(h - way * x for h, x in zip(hit, d, strict=True)),
                *d,
                radius,
                *dice.choice(((1.0, glass), (glass, 1.0), (glass, critical))),
            ]
        )
    cases = [
        {
            "surface": {"radius": r[6], "k": 0.0, "semi_diameter": None, "mirror": False},
            "side": 1,
            "n1": r[7],
            "n2": r[8],
            "origin": r[:3],
            "direction": r[3:6],
        }
        for r in rows
    ]
    return cases, columns(rows)


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def carried(origin, direction):
    along = -dot(origin, direction)
    return [a + b * along for a, b in zip(origin, direction, strict=True)]


def evaluated(kernel: str, precision: str, inputs: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    case = next(case for case in CASES if (case.kernel, case.precision) == (kernel, precision))
    with exactly(), np.errstate(all="ignore"):
        return Evaluation(case, inputs).values


def sphere(kernel: str, precision: str, p, d, c) -> tuple[list[np.ndarray], dict[str, np.ndarray]]:
    """The hit by the script, and its values; y is x with x and y exchanged."""
    names = ("px", "py", "pz", "dx", "dy", "dz", "c")
    values = evaluated(kernel, precision, dict(zip(names, (*p, *d, c), strict=True)))
    turned = evaluated(kernel, precision, dict(zip(names, (p[1], p[0], p[2], d[1], d[0], d[2], c), strict=True)))
    return [values["x"], turned["x"], values["z"]], values


def plane(precision: str, p, d) -> tuple[list[np.ndarray], dict[str, np.ndarray]]:
    names = ("px", "pz", "dx", "dz")
    values = evaluated("plane", precision, dict(zip(names, (p[0], p[2], d[0], d[2]), strict=True)))
    turned = evaluated("plane", precision, dict(zip(names, (p[1], p[2], d[1], d[2]), strict=True)))
    return [values["x"], turned["x"], values["z"]], values


def same_bits(found: list, expected: np.ndarray) -> bool:
    return np.array_equal(np.array(found, dtype=float), expected.astype(float))


@pytest.mark.parametrize("is_plane", [False, True], ids=["sphere", "plane"])
@pytest.mark.parametrize("precision", NUMBERS)
def test_the_scripts_are_the_compiled_kernels_to_the_last_bit(petzval_cli, precision, is_plane):
    number = NUMBERS[precision]
    asked, (x, y, z, dx, dy, dz, radius, n1, n2) = rays(random.Random(f"{precision} {is_plane}"), is_plane)

    def traced(**changes) -> list[dict]:
        mirrors = [case | {"surface": case["surface"] | changes} for case in asked]
        done = petzval_cli(
            "surface", "trace", "-", "--json", "--precision", precision, stdin=json.dumps({"cases": mirrors})
        )
        return answer(done)["cases"]

    # As SingleSurface::trace does it: of unit length and carried in f64, and carried again in its own numbers.
    over = 1.0 / np.sqrt(dot((dx, dy, dz), (dx, dy, dz)))
    d = [a * over for a in (dx, dy, dz)]
    p = [a.astype(number) for a in carried((x, y, z), d)]
    d = [a.astype(number) for a in d]
    p = carried(p, d)
    if is_plane:
        point, values = plane(precision, p, d)
        branches = [("plane", np.ones(RAYS, dtype=bool), point, values)]
    else:
        c = (1.0 / radius).astype(number)
        (usual_point, usual), (grazing_point, grazing) = (
            sphere(kernel, precision, p, d, c) for kernel in ("sphere", "sphere_grazing")
        )
        is_usual = usual["q"] > usual["b"] * usual["b"] * number(CANCELLED)
        # Where B is positive the code takes the other form of the root, of which there is no script.
        has_script = usual["b"] < 0
        branches = [
            ("sphere", has_script & is_usual, usual_point, usual),
            ("grazing", has_script & ~is_usual, grazing_point, grazing),
        ]
    refracted, mirrored = traced(), traced(mirror=True)
    m = (n1 / n2).astype(number)
    e = ((n1 - n2) * (n1 + n2) / (n2 * n2)).astype(number)
    compared = dict.fromkeys(("denser", "rarer", "critical", "mirror", *(branch[0] for branch in branches)), 0)
    for name, fits, point, values in branches:
        is_hit = np.array([case["point"] is not None for case in refracted])
        chosen = np.flatnonzero(fits & is_hit & (values["q"] > 0))
        compared[name] += len(chosen)
        for i in chosen:
            assert same_bits(refracted[i]["point"], np.array([a[i] for a in point])), (name, asked[i])
            # The normal of the code is turned: 1 - c z.
            assert is_plane or refracted[i]["normal"][2] == -float(values["nz"][i])
        normal = np.array([refracted[i]["normal"] for i in chosen]).T.astype(number)
        q, cosine = values["q"][chosen], values["cosine"][chosen]
        outs: dict[str, list[np.ndarray]] = {"denser": [], "rarer": [], "critical": [], "mirror": []}
        for a, n in zip(d, normal, strict=True):
            inputs = {"d": a[chosen], "n": n, "q": q, "m": m[chosen], "e": e[chosen], "w": cosine}
            for kernel in ("denser", "rarer", "critical"):
                script = evaluated(f"refraction_{kernel}", precision, inputs)
                outs[kernel].append(script["out"])
            outs["mirror"].append(evaluated("reflection", precision, inputs)["out"])
        rarer = evaluated("refraction_rarer", precision, inputs)
        near = rarer["radicand"] < rarer["incident_squared"] * number(NEAR_CRITICAL)
        for j, i in enumerate(chosen):
            assert same_bits(mirrored[i]["direction"], np.array([a[j] for a in outs["mirror"]])), asked[i]
            compared["mirror"] += 1
            if refracted[i]["status"] == "ok":
                kernel = "denser" if e[i] < 0 else "critical" if near[j] else "rarer"
                assert same_bits(refracted[i]["direction"], np.array([a[j] for a in outs[kernel]])), (kernel, asked[i])
                compared[kernel] += 1
    # Each branch has been compared, not one of them alone.
    assert min(compared.values()) > 3, compared
