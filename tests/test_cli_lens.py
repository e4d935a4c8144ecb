# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval lens check|info|trace` from outside: every reference lens and ray through the whole command.

tests/reference holds decimal strings and rays of a 50-digit computation that shares no code with the engine.
"""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

pytestmark = pytest.mark.once

ROOT = Path(__file__).resolve().parent.parent
REFERENCE = ROOT / "tests/reference"
LENSES = sorted((REFERENCE / "lenses").glob("*.lens"))
LINES_NM = {"F": 486.1327, "d": 587.5618, "C": 656.2725}

# What the contract promises of the whole command: the reference to twelve digits.
RELATIVE = 1e-12

RAY = {"origin": [0, 0, -10], "direction": [0, 0, 1], "wavelength_nm": 550}

GOOD = """\
# name: Two lenses and a stop
#radius thickness glass diameter conic isstop
50 4 1.5168/64.17 20 0 0
-50 5 air 20 0 0
0 5 air 10 0 1
0 90 air 20 0 0
"""


@pytest.fixture
def good_lens(tmp_path):
    path = tmp_path / "good.lens"
    path.write_text(GOOD)
    return path


def answer(done):
    """The one JSON object of a command that must have gone well."""
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return json.loads(done.stdout)


def assert_complains(done, *words, status=1):
    """One line on stderr, in the one form, with these words; nothing on stdout."""
    assert done.returncode == status, (done.stdout, done.stderr)
    assert done.stdout == ""
    lines = done.stderr.splitlines()
    assert len(lines) == 1, done.stderr
    assert lines[0].startswith("petzval: ")
    for word in words:
        assert word in lines[0]


def published_rows(path: Path) -> list[list[str]]:
    return [line.split() for line in path.read_text().splitlines() if line.strip() and not line.startswith("#")]


# Right answers ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", LENSES, ids=lambda path: path.stem)
def test_info_gives_the_reference_first_order_data(petzval_cli, path):
    reference = json.loads((REFERENCE / "paraxial.json").read_text())[path.stem]
    rows = published_rows(path)
    last_vertex = math.fsum(float(row[1]) for row in rows[:-1])
    for line, wavelength_nm in LINES_NM.items():
        info = answer(petzval_cli("lens", "info", path, "--wavelength", wavelength_nm, "--json"))
        exact = {name: float(value) for name, value in reference[line].items() if value is not None}
        expected = {
            # Positive if converging, through an odd number of mirrors too.
            "efl_mm": math.copysign(exact["efl_rear"], exact["efl"]),
            "bfd_mm": exact["bfd"],
            "ffd_mm": exact["ffd"],
            "object_focal_plane_mm": exact["ffd"],
            "object_principal_plane_mm": exact["pp_front"],
            "image_principal_plane_mm": last_vertex + exact["pp_rear"],
            "image_focal_plane_mm": last_vertex + exact["bfd"],
            "petzval_radius_mm": exact.get("petzval_radius"),
            "entrance_pupil.z_mm": exact.get("enp"),
            "entrance_pupil.diameter_mm": exact.get("enp_diameter"),
            "exit_pupil.z_mm": last_vertex + exact["exp"] if "exp" in exact else None,
            "exit_pupil.diameter_mm": exact.get("exp_diameter"),
        }
        for key, value in expected.items():
            got = info
            for part in key.split("."):
                got = got[part]
            if value is None:
                assert got is None, (line, key)
            else:
                # Small distances are differences of large ones: the lens's own size is the measure there.
                size = max(abs(value), abs(exact["efl_rear"]), abs(last_vertex))
                assert abs(got - value) <= RELATIVE * size, (line, key, got, value)
        assert info["wavelength_nm"] == wavelength_nm
        assert info["surfaces"] == len(rows)


@pytest.mark.parametrize("path", LENSES, ids=lambda path: path.stem)
def test_info_gives_the_reference_seidel_sums(petzval_cli, path):
    reference = json.loads((REFERENCE / "paraxial.json").read_text())[path.stem]["seidel_d"]
    info = answer(petzval_cli("lens", "info", path, "--json"))
    assert info["seidel_field_deg"] == reference["field_deg"]
    sums = [float(reference[name]) for name in ("SI", "SII", "SIII", "SIV", "SV")]
    largest = max(map(abs, sums))
    pairs = list(zip(info["seidel"], sums, strict=True))
    if path.stem == "plano-hyperbolic-50mm":
        # Its first surface is a plane in the pupil: the reference's form of S V is 0/0 there and leaves its part out.
        pairs.pop()
    for mine, exact in pairs:
        assert abs(mine - exact) <= RELATIVE * largest, (mine, exact)


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


def test_single_precision_is_refused_until_it_is_built(petzval_cli, good_lens):
    question = json.dumps({"rays": [RAY]})
    done = petzval_cli("lens", "trace", good_lens, "--rays", "-", "--precision", "f32", "--json", stdin=question)
    assert_complains(done, "f32")


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


def test_info_as_a_table(petzval_cli, good_lens):
    done = petzval_cli("lens", "info", good_lens)
    assert done.returncode == 0, done.stderr
    info = answer(petzval_cli("lens", "info", good_lens, "--json"))
    rows = [line for line in done.stdout.splitlines() if line.startswith("focal length ")]
    assert len(rows) == 1
    assert rows[0].split()[-2:] == [f"{info['efl_mm']:.6f}", "mm"]
    assert "Two lenses and a stop" in done.stdout


def test_info_scales_stops_down_and_focuses(petzval_cli, good_lens):
    plain = answer(petzval_cli("lens", "info", good_lens, "--json"))
    scaled = answer(petzval_cli("lens", "info", good_lens, "--focal-length", "100", "--json"))
    assert scaled["efl_mm"] == pytest.approx(100.0, rel=1e-12)
    factor = 100.0 / plain["efl_mm"]
    assert scaled["bfd_mm"] == pytest.approx(factor * plain["bfd_mm"], rel=1e-12)
    stopped = answer(petzval_cli("lens", "info", good_lens, "--f-number", "16", "--json"))
    assert stopped["f_number"] == pytest.approx(16.0, rel=1e-12)
    # The diaphragm never opens past the clear apertures: the f-number in force is shown.
    open_wide = answer(petzval_cli("lens", "info", good_lens, "--f-number", "0.2", "--json"))
    assert open_wide["f_number"] == plain["f_number"]
    near = answer(petzval_cli("lens", "info", good_lens, "--focus-distance", "1000", "--json"))
    assert near["film_z_mm"] > plain["film_z_mm"]
    far = answer(petzval_cli("lens", "info", good_lens, "--focus-distance", "inf", "--json"))
    assert far["film_z_mm"] == pytest.approx(far["image_focal_plane_mm"], rel=1e-12)


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
}


@pytest.mark.parametrize("case", BAD_RAYS)
def test_bad_rays_are_refused(petzval_cli, good_lens, case):
    assert_complains(petzval_cli("lens", "trace", good_lens, "--rays", "-", "--json", stdin=BAD_RAYS[case]))


def test_a_missing_file_of_rays_is_named(petzval_cli, good_lens, tmp_path):
    assert_complains(petzval_cli("lens", "trace", good_lens, "--rays", tmp_path / "none.json"), "none.json")


def test_no_rays_no_answer(petzval_cli, good_lens):
    done = petzval_cli("lens", "trace", good_lens, "--rays", "-", "--json", stdin='{"rays": []}')
    assert answer(done) == {"rays": []}
