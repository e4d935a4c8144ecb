# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval lens check|trace` from outside: every reference ray through the whole command, and what it refuses.

tests/reference holds decimal strings and rays of a 50-digit computation that shares no code with the engine.
"""

from __future__ import annotations

import json
import math
import time

import pytest

from support.command_line import LENSES, LINES_NM, RELATIVE, answer, assert_complains
from support.places import REFERENCE, ROOT

pytestmark = pytest.mark.once

RAY = {"origin": [0, 0, -10], "direction": [0, 0, 1], "wavelength_nm": 550}


# Right answers ---------------------------------------------------------------------------------------------------


#: The reference's word for a lost ray, and the command's.
STATUS = {
    "ok": {"ok"},
    "miss": {"missed", "wrong_sheet"},
    "wrong_sheet": {"missed", "wrong_sheet"},
    "vignetted": {"outside_aperture", "blade_stop"},
    "tir": {"tir"},
}


def distance(first, second):
    return math.dist(first, second)


@pytest.mark.parametrize("direction", ["rays", "reverse"])
@pytest.mark.parametrize("path", LENSES, ids=lambda path: path.stem)
def test_trace_gives_the_reference_rays(petzval_cli, tmp_path, path, direction):
    table = REFERENCE / "rays" / f"{path.stem}.json"
    rays = json.loads(table.read_text())[direction] if table.exists() else []
    question = {
        "rays": [{"origin": ray["o"], "direction": ray["d"], "wavelength_nm": LINES_NM[ray["w"]]} for ray in rays]
    }
    if direction == "reverse":
        question["from"] = "film"
    asked = tmp_path / "rays.json"
    asked.write_text(json.dumps(question))
    traced = answer(petzval_cli("lens", "trace", path, "--rays", asked, "--json"))["rays"]
    assert len(traced) == len(rays)
    for number, (got, ray) in enumerate(zip(traced, rays, strict=True)):
        assert got["status"] in STATUS[ray["s"]], (number, got, ray)
        assert got["surface"] == ray.get("i"), (number, got, ray)
        if ray["s"] == "miss":
            continue
        assert len(got["hits"]) == len(ray["h"]), number
        size = max(1.0, *(abs(value) for hit in ray["h"] for value in hit))
        for mine, exact in zip(got["hits"], ray["h"], strict=True):
            assert distance(mine, exact) <= RELATIVE * size, (number, mine, exact)
        if ray["s"] == "ok":
            assert distance(got["direction"], ray["e"]) <= RELATIVE, (number, got["direction"], ray["e"])


@pytest.mark.parametrize("name", ["tessar-brendel", "cassegrain-f12"])
def test_single_precision_is_asked_for_and_had(petzval_cli, name):
    rays = json.loads((REFERENCE / "rays" / f"{name}.json").read_text())["rays"][:40]
    asked = [{"origin": ray["o"], "direction": ray["d"], "wavelength_nm": LINES_NM[ray["w"]]} for ray in rays]
    question = json.dumps({"rays": asked})

    def traced(*options):
        lens = REFERENCE / "lenses" / f"{name}.lens"
        return answer(petzval_cli("lens", "trace", lens, "--rays", "-", "--json", *options, stdin=question))["rays"]

    double, single = traced("--precision", "f64"), traced("--precision", "f32")
    assert double == traced()
    differences = []
    for number, (f64, f32) in enumerate(zip(double, single, strict=True)):
        assert (f32["status"], f32["surface"]) == (f64["status"], f64["surface"]), number
        size = max(1.0, *(abs(value) for hit in f64["hits"] for value in hit))
        for hit64, hit32 in zip(f64["hits"], f32["hits"], strict=True):
            differences.append(distance(hit64, hit32) / size)
    # Roundings of f32, and neither none of them nor many.
    assert 1e-9 < max(differences) < 2e-6, max(differences)


# The forms of the command ----------------------------------------------------------------------------------------


def test_check_says_what_it_read(petzval_cli, good_lens):
    done = petzval_cli("lens", "check", good_lens, good_lens)
    assert done.returncode == 0
    assert done.stdout.splitlines() == ["ok: Two lenses and a stop, 4 surfaces"] * 2


def test_check_goes_on_after_a_bad_file(petzval_cli, good_lens, tmp_path):
    done = petzval_cli("lens", "check", tmp_path / "none.lens", good_lens)
    assert done.returncode == 1
    assert done.stdout.splitlines() == ["ok: Two lenses and a stop, 4 surfaces"]
    assert len(done.stderr.splitlines()) == 1


def test_every_shipped_lens_is_sound(petzval_cli):
    shipped = sorted(path.stem for path in (ROOT / "lenses").glob("*.lens"))
    assert len(shipped) > 30
    done = petzval_cli("lens", "check", *shipped)
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) == len(shipped)


def test_a_shipped_lens_goes_by_name(petzval_cli):
    by_name = answer(petzval_cli("lens", "info", "wide-angle-smith-f3.4", "--json"))
    by_path = answer(petzval_cli("lens", "info", ROOT / "lenses/wide-angle-smith-f3.4.lens", "--json"))
    assert by_name == by_path


def test_trace_scales_and_stops_down(petzval_cli, good_lens):
    ray = {"origin": [0, 1.5, -10], "direction": [0, 0, 1]}

    def traced(ray, *options):
        question = json.dumps({"rays": [ray]})
        return answer(petzval_cli("lens", "trace", good_lens, "--rays", "-", "--json", *options, stdin=question))[
            "rays"
        ][0]

    plain = traced(ray)
    efl = answer(petzval_cli("lens", "info", good_lens, "--json"))["efl_mm"]
    doubled = traced({**ray, "origin": [0, 3.0, -20]}, "--focal-length", repr(2.0 * efl))
    assert doubled["status"] == plain["status"] == "ok"
    assert doubled["direction"] == pytest.approx(plain["direction"], abs=1e-12)
    assert doubled["origin"] == pytest.approx([2.0 * value for value in plain["origin"]], abs=1e-10)
    assert traced(ray, "--f-number", "22")["status"] == "blade_stop"


@pytest.mark.parametrize(("lens", "focus_mm"), [("anamorphic-2x-front-focus", 2700.0), ("nikkor-105-f1.4", 3000.0)])
def test_trace_is_focused(petzval_cli, lens, focus_mm):
    """Light of a point in focus hits the film in one point, upright and across, once the lens's groups stand where they belong."""
    info = json.loads(petzval_cli("lens", "info", lens, "--focus-distance", focus_mm, "--json").stdout)
    pupil_mm = info["entrance_pupil"]["z_mm"]
    point = [0.0, 0.0, pupil_mm - focus_mm]
    rays = [
        {"origin": point, "direction": [x, y, focus_mm]} for x, y in ((0, 0), (0, 3), (0, -6), (2, 0), (-4, 1), (3, 3))
    ]

    def spread(*options):
        asked = json.dumps({"rays": rays})
        told = json.loads(petzval_cli("lens", "trace", lens, "--rays", "-", "--json", *options, stdin=asked).stdout)[
            "rays"
        ]
        places = []
        for one in told:
            (x, y, z), (dx, dy, dz) = one["origin"], one["direction"]
            way = (info["film_z_mm"] - z) / dz
            places.append((x + way * dx, y + way * dy))
        return max(math.hypot(*place) for place in places)

    # Light is up to a quarter of the opening wide: some micrometres of spherical aberration are left.
    assert spread("--focus-distance", focus_mm) < 0.015
    assert spread() > 0.08


def test_trace_as_lines(petzval_cli, good_lens):
    question = json.dumps(
        {
            "rays": [
                {"origin": [0, 0, -10], "direction": [0, 0, 1], "wavelength_nm": 550},
                {"origin": [0, 30, -10], "direction": [0, 0, 1], "wavelength_nm": 550},
            ]
        }
    )
    done = petzval_cli("lens", "trace", good_lens, "--rays", "-", stdin=question)
    assert done.returncode == 0, done.stderr
    first, second = done.stdout.splitlines()
    assert first.startswith("0: ok, ")
    assert second == "1: outside_aperture at surface 0"


# Bad lens files --------------------------------------------------------------------------------------------------

ROW = "50 4 1.5168/64.17 20 0 0\n"
STOP = "0 5 air 10 0 1\n"

#: What is wrong: the file's content, and where the message must point (None: the file as a whole).
BAD_FILES = {
    "unknown glass": (ROW + "-50 5 XYZZY9 20 0 0\n" + STOP, "2"),
    "a column missing": (ROW + "-50 5 air 20 0\n" + STOP, "2"),
    "a column too many": (ROW + "-50 5 air 20 0 0 7\n" + STOP, "2"),
    "not a number": (ROW + STOP + "-50 five air 20 0 0\n", "3"),
    "NaN": ("nan 4 1.5 20 0 0\n" + STOP, "1"),
    "infinite": (ROW + STOP + "50 inf air 20 0 0\n", "3"),
    "negative diameter": (ROW + "-50 5 air -20 0 0\n" + STOP, "2"),
    "isstop neither 0 nor 1": (ROW + "0 5 air 10 0 2\n", "2"),
    "no stop": (ROW + "-50 5 air 20 0 0\n", None),
    "two stops": (ROW + STOP + STOP, "3"),
    "empty": ("", None),
    "comments only": ("# name: nothing\n#radius thickness glass diameter conic isstop\n", None),
    "diameter beyond the sphere": ("5 4 1.5 20 0 0\n" + STOP, "1"),
    "an index below one half": ("50 4 0.2 20 0 0\n" + STOP, "1"),
}


@pytest.mark.parametrize("case", BAD_FILES)
@pytest.mark.parametrize("action", ["check", "info"])
def test_a_bad_file_is_named_with_its_line(petzval_cli, tmp_path, case, action):
    content, line = BAD_FILES[case]
    path = tmp_path / "bad.lens"
    path.write_text(content)
    done = petzval_cli("lens", action, path)
    assert_complains(done, "bad.lens")
    if line is not None:
        assert f"bad.lens:{line}" in done.stderr or f"line {line}" in done.stderr, done.stderr


def test_a_binary_file_is_refused(petzval_cli, tmp_path):
    path = tmp_path / "picture.lens"
    path.write_bytes(bytes(range(256)) * 4)
    assert_complains(petzval_cli("lens", "check", path), "picture.lens")


def test_a_missing_file_is_named_and_its_neighbours_offered(petzval_cli):
    assert_complains(petzval_cli("lens", "info", "biotar-1928", "--json"), "biotar-1928", "biotar-1927")


def test_a_folder_is_no_lens(petzval_cli, tmp_path):
    assert_complains(petzval_cli("lens", "check", tmp_path), tmp_path.name)


# Bad questions ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "options",
    [
        ("--wavelength", "green"),
        ("--wavelength", "nan"),
        ("--focal-length", "inf"),
        ("--focus-distance", "nan"),
        ("--f-number",),
        ("--no-such-option",),
    ],
    ids=" ".join,
)
def test_bad_usage_is_one_line_and_2(petzval_cli, good_lens, options):
    assert_complains(petzval_cli("lens", "info", good_lens, *options), "--help", status=2)


@pytest.mark.parametrize("arguments", [(), ("lens",), ("lens", "info"), ("lens", "polish"), ("cook",)], ids=" ".join)
def test_a_missing_or_unknown_command_is_2(petzval_cli, arguments):
    assert_complains(petzval_cli(*arguments), "--help", status=2)


@pytest.mark.parametrize(
    "options",
    [
        ("--wavelength", "0"),
        ("--focal-length", "0"),
        ("--f-number", "-2"),
        ("--focus-distance", "-5"),
    ],
    ids=" ".join,
)
def test_an_impossible_setting_is_1(petzval_cli, good_lens, options):
    assert_complains(petzval_cli("lens", "info", good_lens, *options, "--json"))


BAD_RAYS = {
    "not JSON": "{",
    "a list": "[]",
    "no rays": "{}",
    "rays not a list": '{"rays": 3}',
    "unknown side": json.dumps({"from": "left", "rays": [RAY]}),
    "no direction": json.dumps({"rays": [{**RAY, "direction": [0, 0, 0]}]}),
    "NaN": json.dumps({"rays": [{**RAY, "origin": [math.nan, 0, 0]}]}),
    "two coordinates": json.dumps({"rays": [{**RAY, "origin": [0, 0]}]}),
    "no colour": json.dumps({"rays": [{**RAY, "wavelength_nm": -550}]}),
    "words": json.dumps({"rays": [{**RAY, "origin": "here"}]}),
    "a misspelt key": json.dumps({"rays": [{**RAY, "wavelength": 550}]}),
    "a misspelt key of all": json.dumps({"rays": [RAY], "form": "film"}),
}


@pytest.mark.parametrize("case", BAD_RAYS)
def test_bad_rays_are_refused(petzval_cli, good_lens, case):
    assert_complains(petzval_cli("lens", "trace", good_lens, "--rays", "-", "--json", stdin=BAD_RAYS[case]))


def test_directions_may_have_any_length(petzval_cli, good_lens):
    rays = [{**RAY, "direction": [0.0, math.ldexp(1 / 64, by), math.ldexp(1.0, by)]} for by in (0, -996, 664, 1000)]
    done = petzval_cli("lens", "trace", good_lens, "--rays", "-", "--json", stdin=json.dumps({"rays": rays}))
    first, *others = answer(done)["rays"]
    assert first["status"] == "ok"
    assert all(other == first for other in others)


def test_a_thousand_surfaces_are_traced_and_100_000_rows_refused(petzval_cli, tmp_path):
    def lens(pairs):
        path = tmp_path / f"{pairs}.lens"
        path.write_text(STOP + "0 1 1.5 20 0 0\n0 1 air 20 0 0\n" * pairs)
        return path

    # Plates of glass: each moves the ray aside by the same length, and leaves its direction as it was.
    question = json.dumps({"rays": [{"origin": [0, 0.0, -1], "direction": [0, 0.001, 1.0]}]})
    traced = {}
    for pairs in (1, 499):
        done = petzval_cli("lens", "trace", lens(pairs), "--rays", "-", "--json", stdin=question)
        [traced[pairs]] = answer(done)["rays"]
        assert traced[pairs]["status"] == "ok"
    assert traced[499]["direction"] == pytest.approx(traced[1]["direction"], abs=1e-12)
    assert len(traced[499]["hits"]) == 999
    start = time.monotonic()
    assert_complains(petzval_cli("lens", "check", lens(50_000)), "50000.lens")
    # Of it most is the start of Python.
    assert time.monotonic() - start < 5.0


def test_a_missing_file_of_rays_is_named(petzval_cli, good_lens, tmp_path):
    assert_complains(petzval_cli("lens", "trace", good_lens, "--rays", tmp_path / "none.json"), "none.json")


def test_no_rays_no_answer(petzval_cli, good_lens):
    done = petzval_cli("lens", "trace", good_lens, "--rays", "-", "--json", stdin='{"rays": []}')
    assert answer(done) == {"rays": []}
