# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval surface trace` from outside: every hard case of the reference through the whole command.

tests/reference/hard-cases.json holds answers to 30 digits, and how much each moves by one rounding of its input.
"""

from __future__ import annotations

import json
import math
from decimal import Decimal, localcontext

import pytest

from support.command_line import answer, assert_complains
from support.places import REFERENCE

pytestmark = pytest.mark.once

HARD_CASES = REFERENCE / "hard-cases.json"
CASES = json.loads(HARD_CASES.read_text())["cases"]

#: The reference's word for the fate of a ray, and the command's.
STATUS = {
    "ok": {"ok"},
    "miss": {"missed", "wrong_sheet"},
    "wrong_sheet": {"missed", "wrong_sheet"},
    "vignetted": {"outside_aperture"},
    "tir": {"tir"},
}
#: All that may come back.
WORDS = {"ok", "missed", "wrong_sheet", "outside_aperture", "obstructed", "tir", "not_converged"}

EASY = {
    "id": "easy",
    "surface": {"radius": 50, "k": 0, "semi_diameter": 20, "mirror": False},
    "side": 1,
    "n1": 1,
    "n2": 1.5,
    "origin": [3, -4, -20],
    "direction": [0.1, 0.05, 1],
}


@pytest.fixture
def trace(petzval_cli):
    """Traces cases given as values: `trace(case, "--precision", "f32")` is the list of answers."""

    def run(*cases_and_options):
        cases = [part for part in cases_and_options if isinstance(part, dict)]
        options = [part for part in cases_and_options if isinstance(part, str)]
        done = petzval_cli("surface", "trace", "-", "--json", *options, stdin=json.dumps({"cases": cases}))
        return answer(done)["cases"]

    return run


@pytest.fixture(scope="module")
def hard(petzval_cli):
    """The answers to all hard cases, by precision and id."""
    answers = {}
    for precision in ("f64", "f32", "printed"):
        done = petzval_cli("surface", "trace", HARD_CASES, "--precision", precision, "--json")
        answers[precision] = answer(done)["cases"]
    return answers


def error(found, exact):
    return math.hypot(*(float(Decimal(mine) - Decimal(theirs)) for mine, theirs in zip(found, exact, strict=True)))


# Right answers ---------------------------------------------------------------------------------------------------


def test_answers_come_in_the_order_of_the_cases(hard):
    for cases in hard.values():
        assert [case["id"] for case in cases] == [case["id"] for case in CASES]
        assert all(set(case) == {"id", "status", "t", "point", "normal", "direction"} for case in cases)
        assert {case["status"] for case in cases} <= WORDS


@pytest.mark.parametrize("number", range(len(CASES)), ids=lambda number: CASES[number]["id"])
def test_a_hard_case_comes_out(hard, number):
    case, got = CASES[number], hard["f64"][number]
    expect, sensitivity = case["expect"], case["ulp_sensitivity"]
    flips = sensitivity["status_flips"]
    assert got["status"] in STATUS[expect["status"]] or flips, (got, expect)

    def tolerance(what):
        # What the reference's own README calls fair.
        return max(1e-11, 10.0 * float(sensitivity[what]))

    if got["point"] is not None and expect.get("point") is not None:
        assert error(got["point"], expect["point"]) <= tolerance("point")
        radius = abs(float(case["surface"]["radius"]))
        curved = tolerance("point") / radius if radius else 0.0
        assert error(got["normal"], expect["normal"]) <= max(tolerance("direction"), curved)
        # Of a long way, its last digit too.
        rounding = 4e-16 * abs(float(expect["t"]))
        assert abs(float(Decimal(got["t"]) - Decimal(expect["t"]))) <= tolerance("point") + rounding
        assert math.hypot(*got["normal"]) == pytest.approx(1.0, abs=1e-14)
    else:
        assert expect.get("point") is None or flips
    if got["status"] == "ok" and expect["status"] == "ok":
        assert error(got["direction"], expect["dir"]) <= tolerance("direction")
        assert math.hypot(*got["direction"]) == pytest.approx(1.0, abs=1e-14)
    if got["status"] != "ok":
        assert got["direction"] is None


def test_what_is_met_is_given_even_where_the_ray_ends(hard):
    for got in hard["f64"]:
        is_met = got["status"] in {"ok", "outside_aperture", "obstructed", "tir"}
        for key in ("t", "point", "normal"):
            assert (got[key] is not None) == is_met, got


def test_precisions_differ_as_they_should(hard, trace):
    # An easy ray: f32 off by its roundings, the printed equations not at all.
    [double], [single], [printed] = (trace(EASY, "--precision", name) for name in ("f64", "f32", "printed"))
    assert 1e-9 < error(single["point"], double["point"]) < 1e-5
    assert 1e-9 < error(single["direction"], double["direction"]) < 1e-6
    assert error(printed["point"], double["point"]) < 1e-12
    assert error(printed["direction"], double["direction"]) < 1e-12
    # The hard ones: the stable form loses none where the printed one is wrong in many.

    def wrong(precision):
        return sum(
            got["status"] not in STATUS[case["expect"]["status"]]
            for case, got in zip(CASES, hard[precision], strict=True)
            if not case["ulp_sensitivity"]["status_flips"]
        )

    assert wrong("f64") == 0
    assert wrong("printed") > 10


@pytest.mark.parametrize("precision", ["f64", "f32", "printed"])
def test_no_answer_is_no_number(petzval_cli, precision):
    done = petzval_cli("surface", "trace", HARD_CASES, "--precision", precision, "--json")
    json.loads(done.stdout, parse_constant=pytest.fail)


def test_same_medium_keeps_the_direction_and_a_mirror_turns_it(trace):
    same, mirror = trace({**EASY, "n2": 1}, {**EASY, "surface": {**EASY["surface"], "mirror": True}})
    length = math.hypot(*EASY["direction"])
    assert same["direction"] == pytest.approx([value / length for value in EASY["direction"]], abs=1e-15)
    n = mirror["normal"]
    cosine = sum(a * b for a, b in zip(same["direction"], n, strict=True))
    reflected = [d - 2.0 * cosine * component for d, component in zip(same["direction"], n, strict=True)]
    assert mirror["direction"] == pytest.approx(reflected, abs=1e-14)


def test_numbers_may_be_words(trace):
    words = {
        **EASY,
        "surface": {"radius": "50.0", "k": "0", "semi_diameter": "2e1", "mirror": False},
        "n1": "1",
        "n2": "1.5",
        "origin": ["3", "-4", "-20"],
        "direction": ["0.1", "0.05", "1"],
    }
    assert trace(words) == trace(EASY)


@pytest.mark.parametrize("exponent", [-1040, -996, -664, 0, 664, 1000])
def test_directions_may_have_any_length(trace, exponent):
    # Times a power of two, so that they are the same direction to the bit; -1040 leaves a few bits fewer.
    direction = [math.ldexp(component, exponent) for component in (0.125, 0.0625, 1.0)]
    for precision in ("f64", "f32", "printed"):
        [given] = trace({**EASY, "direction": direction}, "--precision", precision)
        [plain] = trace({**EASY, "direction": [0.125, 0.0625, 1.0]}, "--precision", precision)
        assert given == plain, precision


class Exact:
    """A ray at a sphere in numbers of 80 digits."""

    def __init__(self, case):
        self.radius, self.n1, self.n2 = (Decimal(case[key]) for key in ("radius", "n1", "n2"))
        self.origin, self.direction = ([Decimal(x) for x in case[key]] for key in ("origin", "direction"))

    def point_and_direction(self):
        with localcontext() as context:
            context.prec = 80
            length = sum(x * x for x in self.direction).sqrt()
            d = [x / length for x in self.direction]
            from_centre = [x - c for x, c in zip(self.origin, (0, 0, self.radius), strict=True)]
            b = sum(x * y for x, y in zip(from_centre, d, strict=True))
            root = (b * b - sum(x * x for x in from_centre) + self.radius * self.radius).sqrt()
            # The crossing at the vertex' side: towards +z it is the first of a positive radius.
            t = -b - root.copy_sign(self.radius)
            point = [x + t * y for x, y in zip(self.origin, d, strict=True)]
            normal = [(c - x) / self.radius for x, c in zip(point, (0, 0, self.radius), strict=True)]
            cos, ratio = sum(x * y for x, y in zip(normal, d, strict=True)), self.n1 / self.n2
            bent = (1 - ratio * ratio * (1 - cos * cos)).sqrt() - ratio * cos
            return point, [ratio * x + bent * y for x, y in zip(d, normal, strict=True)]


#: Radii in mm, distances of the origin in mm, and indices before and after.
RADII = [1e-6, 1e-3, 1.0, -1.0, 1e3, 1e9, 1e12, -1e12]
DISTANCES = [0.0, 1.0, 1e6, 1e12]
INDICES = [(1.0, 4.0), (1.0, 1.0001), (3.9, 4.0), (1.5, 1.45)]


@pytest.mark.parametrize("radius", RADII)
def test_far_origins_and_radii_of_any_size(trace, radius):
    size = min(abs(radius), 10.0)
    cases = []
    # From farther away the rounding of what is given alone decides whether a ray hits.
    for away in (away for away in DISTANCES if away * 2.0**-53 < 1e-3 * abs(radius)):
        for n1, n2 in INDICES:
            direction = [0.02, -0.05, 1.0]
            aim = [0.1 * size, 0.2 * size, 0.0]
            origin = [x - (away + 2.0 * size) * y for x, y in zip(aim, direction, strict=True)]
            cases.append({"radius": radius, "n1": n1, "n2": n2, "origin": origin, "direction": direction})
    asked = [{**EASY, **case, "surface": {"radius": case.pop("radius")}} for case in map(dict, cases)]
    asked = [{key: value for key, value in one.items() if key not in {"radius", "id"}} for one in asked]
    for case, got in zip(cases, trace(*asked), strict=True):
        point, direction = Exact(case).point_and_direction()
        assert got["status"] == "ok", case
        # Half a unit in the last place of what is given, times how far it is carried; and some for what is computed.
        reach = max(*map(abs, case["origin"]), size)
        assert error(got["point"], point) <= 8 * 2.0**-53 * reach, case
        slope = 8 * 2.0**-53 * (reach / abs(radius) + 1.0)
        assert error(got["direction"], direction) <= 8 * slope, case
        assert math.hypot(*got["direction"]) == pytest.approx(1.0, abs=1e-14)


def test_what_may_be_left_out(trace):
    short = {"surface": {"radius": 0}, "n1": 1.5, "n2": 1.5, "origin": [1, 2, -3], "direction": [0, 0, 2]}
    mirror = {**short, "surface": {"radius": 0, "mirror": True, "semi_diameter": None}}
    del mirror["n2"]
    first, second = trace(short, mirror)
    assert first == {"id": 0, "status": "ok", "t": 3, "point": [1, 2, 0], "normal": [0, 0, 1], "direction": [0, 0, 1]}
    assert (second["id"], second["direction"]) == (1, [0, 0, -1])


def test_obstructions_aspheres_and_toroids(trace):
    along = {**EASY, "origin": [3, 4, -20], "direction": [0, 0, 1]}

    def with_surface(**surface):
        return {**along, "surface": {"radius": 50, **surface}}

    dark, bright, asphere, cylinder, toroid = trace(
        with_surface(obstruction=5.1),
        with_surface(obstruction=5.0),
        with_surface(k=-1, terms=[[4, "1e-5"], [6, -2e-8]]),
        with_surface(radius_x=0),
        with_surface(radius_x=-80),
    )
    assert (dark["status"], bright["status"]) == ("obstructed", "ok")
    assert dark["point"] == bright["point"]
    assert asphere["point"][2] == pytest.approx(25.0 / 100.0 + 1e-5 * 5.0**4 - 2e-8 * 5.0**6, abs=1e-13)
    circle = 50.0 - math.sqrt(50.0**2 - 4.0**2)
    assert cylinder["point"][2] == pytest.approx(circle, abs=1e-13)
    assert toroid["point"][2] == pytest.approx(-80.0 + math.sqrt((80.0 + circle) ** 2 - 3.0**2), abs=1e-13)


# The forms of the command ----------------------------------------------------------------------------------------


def test_lines_for_people(petzval_cli):
    tir = {**EASY, "id": "flat", "surface": {"radius": 0}, "n1": 1.5, "n2": 1, "direction": [0, 0.9, 0.5]}
    lost = {**EASY, "id": "past", "origin": [60, 0, -20], "direction": [0, 0, 1]}
    done = petzval_cli("surface", "trace", "-", stdin=json.dumps({"cases": [EASY, tir, lost]}))
    assert done.returncode == 0, done.stderr
    first, second, third = done.stdout.splitlines()
    assert first.startswith("easy: ok, at (") and "goes on along (" in first
    assert second.startswith("flat: tir, at (") and "goes on" not in second
    assert third == "past: missed"


def test_no_cases_no_answer(petzval_cli):
    assert answer(petzval_cli("surface", "trace", "-", "--json", stdin='{"cases": []}')) == {"cases": []}


def test_help_tells_the_format(petzval_cli):
    done = petzval_cli("surface", "trace", "--help")
    assert done.returncode == 0
    for word in ("semi_diameter", "side", "n1, n2", "radius_x", "printed"):
        assert word in done.stdout


# Bad questions ---------------------------------------------------------------------------------------------------

BAD_FILES = {
    "not JSON": ("{", "not JSON"),
    "a list": ("[]", "no list of cases"),
    "no cases": ("{}", "no list of cases"),
    "cases no list": ('{"cases": 3}', "no list of cases"),
    "NaN": (json.dumps({"cases": [{**EASY, "n1": math.nan}]}), "JSON"),
    "deep": ("[" * 100000, "JSON"),
    "long": ('{"cases": [' + "9" * 5000 + "]}", "JSON"),
}


@pytest.mark.parametrize("case", BAD_FILES)
def test_a_bad_file_is_refused(petzval_cli, case):
    text, words = BAD_FILES[case]
    assert_complains(petzval_cli("surface", "trace", "-", stdin=text), words)


def surface(**changes):
    return {"surface": {**EASY["surface"], **changes}}


#: What is wrong: the change to the easy case, and the field that must be named.
BAD_CASES = {
    "no surface": ({"surface": None}, "surface.radius"),
    "no radius": (surface(radius=None), "surface.radius"),
    "radius a word": (surface(radius="wide"), "surface.radius"),
    "infinite radius": (surface(radius="inf"), "surface.radius"),
    "radius too small": (surface(radius=1e-320), "surface.radius"),
    "k a list": (surface(k=[1]), "surface.k"),
    "mirror a word": (surface(mirror="yes"), "surface.mirror"),
    "no aperture": (surface(semi_diameter=0), "surface.semi_diameter"),
    "negative obstruction": (surface(obstruction=-1), "surface.obstruction"),
    "power of one": (surface(terms=[[1, 0.5]]), "surface.terms"),
    "power of 21": (surface(terms=[[21, 0.5]]), "surface.terms"),
    "terms no pairs": (surface(terms=[4, 0.5]), "surface.terms"),
    "radius_x a word": (surface(radius_x="round"), "surface.radius_x"),
    "side 0": ({"side": 0}, "side"),
    "side a word": ({"side": "left"}, "side"),
    "index 0": ({"n1": 0}, "n1"),
    "negative index": ({"n2": -1.5}, "n2"),
    "index missing": ({"n2": None}, "n2"),
    "two coordinates": ({"origin": [0, 0]}, "origin"),
    "a coordinate too many": ({"origin": [0, 0, 0, 0]}, "origin"),
    "too large a number": ({"origin": [0, 0, "1e999"]}, "origin"),
    "no direction": ({"direction": [0, 0, 0]}, "direction"),
    "words for a direction": ({"direction": "up"}, "direction"),
}


#: A misspelt key: the change to the easy case, and what must be named.
UNKNOWN_KEYS = {
    "of a case": ({"orgin": [0, 0, 0]}, '"orgin"'),
    "of a surface": (surface(conic=-1), 'surface."conic"'),
}


@pytest.mark.parametrize("where", UNKNOWN_KEYS)
def test_an_unknown_key_is_named(petzval_cli, where):
    change, key = UNKNOWN_KEYS[where]
    bad = {**EASY, "id": "the-bad-one", **change}
    done = petzval_cli("surface", "trace", "-", "--json", stdin=json.dumps({"cases": [EASY, bad]}))
    assert_complains(done, "the-bad-one", key, "--help")
    done = petzval_cli("surface", "trace", "-", "--json", stdin=json.dumps({"cases": [EASY], "casses": []}))
    assert_complains(done, '"casses"', "--help")


@pytest.mark.parametrize("what", BAD_CASES)
def test_a_bad_case_is_named_with_its_field(petzval_cli, what):
    change, field = BAD_CASES[what]
    bad = {**EASY, "id": "the-bad-one", **change}
    done = petzval_cli("surface", "trace", "-", "--json", stdin=json.dumps({"cases": [EASY, bad]}))
    assert_complains(done, "the-bad-one", f'"{field}"', "--help")


def test_a_case_that_is_none_is_named_by_its_number(petzval_cli):
    done = petzval_cli("surface", "trace", "-", stdin=json.dumps({"cases": [EASY, 7]}))
    assert_complains(done, "case 1")


def test_the_paper_has_no_equations_for_aspheres(petzval_cli):
    asphere = {**EASY, "id": "wavy", **surface(terms=[[4, 1e-5]])}
    question = json.dumps({"cases": [asphere]})
    done = petzval_cli("surface", "trace", "-", "--precision", "printed", stdin=question)
    assert_complains(done, "wavy", "terms", "f64")


def test_a_missing_file_is_named(petzval_cli, tmp_path):
    assert_complains(petzval_cli("surface", "trace", tmp_path / "none.json"), "none.json")
    assert_complains(petzval_cli("surface", "trace", tmp_path), tmp_path.name)
    binary = tmp_path / "picture.json"
    binary.write_bytes(bytes(range(256)))
    assert_complains(petzval_cli("surface", "trace", binary), "picture.json")


@pytest.mark.parametrize(
    "arguments",
    [(), ("polish",), ("trace",), ("trace", "-", "--precision", "f16"), ("trace", "-", "--no-such-option")],
    ids=" ".join,
)
def test_bad_usage_is_one_line_and_2(petzval_cli, arguments):
    assert_complains(petzval_cli("surface", *arguments), "--help", status=2)
