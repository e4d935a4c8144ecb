# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval lens info` from outside: every reference lens through the whole command.

tests/reference holds decimal strings of a 50-digit computation that shares no code with the engine.
"""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from support.command_line import LENSES, LINES_NM, RELATIVE, answer, assert_complains
from support.places import REFERENCE
from support.render_commands import many

pytestmark = pytest.mark.once


#: Every sixth in `make test`, the others as recipes: engine/optics/tests/all/reference_paraxial.rs has all of them in every run.
EACH_LENS = [
    pytest.param(path, id=path.stem, marks=[pytest.mark.recipe] * (i % 6 != 0)) for i, path in enumerate(LENSES)
]


def near_mm(path: Path) -> float:
    """A distance of focus at which the lens is near: eight focal lengths before its focus."""
    exact = json.loads((REFERENCE / "paraxial.json").read_text())[path.stem]["d"]
    return float(exact["enp"]) - min(float(exact["ffd"]), 0.0) + 8.0 * abs(float(exact["efl"]))


@pytest.fixture(scope="module")
def infos(request, tmp_path_factory):
    """`infos(path, *options)` of every lens of this run: all in one process, as a command's start takes longer than its work."""
    paths = {item.callspec.params["path"] for item in request.session.items if "infos" in item.fixturenames}
    asked = [
        (path, *options)
        for path in sorted(paths)
        for options in (
            (),
            # The d line's wavelength is the one that is taken if none is given.
            *(("--wavelength", nm) for line, nm in LINES_NM.items() if line != "d"),
            ("--focus-distance", repr(near_mm(path))),
        )
    ]
    done = many([["lens", "info", *one, "--json"] for one in asked], tmp_path_factory.mktemp("infos"))
    known = dict(zip(asked, done, strict=True))
    return lambda *one: answer(known[one])


def published_rows(path: Path) -> list[list[str]]:
    return [line.split() for line in path.read_text().splitlines() if line.strip() and not line.startswith("#")]


# Right answers ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", EACH_LENS)
def test_info_gives_the_reference_first_order_data(infos, path):
    reference = json.loads((REFERENCE / "paraxial.json").read_text())[path.stem]
    rows = published_rows(path)
    last_vertex = math.fsum(float(row[1]) for row in rows[:-1])
    for line, wavelength_nm in LINES_NM.items():
        info = infos(path) if line == "d" else infos(path, "--wavelength", wavelength_nm)
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


@pytest.mark.parametrize("path", EACH_LENS)
def test_info_gives_the_reference_seidel_and_chromatic_sums(infos, path):
    reference = json.loads((REFERENCE / "paraxial.json").read_text())[path.stem]["seidel_d"]
    info = infos(path)
    assert info["seidel_field_deg"] == reference["field_deg"]
    for key, names in {"seidel": ("SI", "SII", "SIII", "SIV", "SV"), "chromatic": ("CL", "CT")}.items():
        sums = [float(reference[name]) for name in names]
        largest = max(map(abs, sums))
        pairs = list(zip(info[key], sums, strict=True))
        if path.stem == "plano-hyperbolic-50mm" and key == "seidel":
            # Its first surface is a plane in the pupil: the reference's form of S V is 0/0 there and leaves its part out.
            pairs.pop()
        for mine, exact in pairs:
            assert abs(mine - exact) <= RELATIVE * largest, (mine, exact)
        by_surface = info[f"{key}_by_surface"]
        assert len(by_surface) == info["surfaces"]
        for column, total in zip(zip(*by_surface, strict=True), info[key], strict=True):
            assert math.fsum(column) == pytest.approx(total, abs=1e-12 * math.fsum(map(abs, column)))


@pytest.mark.parametrize("path", EACH_LENS)
def test_info_gives_near_conjugates(infos, path):
    """Newton's relations, from the reference's foci; through mirrors too."""
    reference = json.loads((REFERENCE / "paraxial.json").read_text())[path.stem]["d"]
    exact = {name: float(value) for name, value in reference.items() if value is not None}
    rows = published_rows(path)
    last_vertex = math.fsum(float(row[1]) for row in rows[:-1])
    far = infos(path)
    focus_distance = near_mm(path)
    info = infos(path, "--focus-distance", repr(focus_distance))
    object_z = exact["enp"] - focus_distance
    efl = abs(exact["efl"])
    magnification = -efl / (exact["ffd"] - object_z)
    # Light goes towards -z behind an odd number of mirrors.
    towards_film = math.copysign(1.0, exact["bfd"])
    film = last_vertex + exact["bfd"] - towards_film * magnification * abs(exact["efl_rear"])
    size = max(efl, abs(last_vertex), focus_distance)
    assert info["focus_distance_mm"] == focus_distance
    assert info["object_plane_mm"] == pytest.approx(object_z, abs=1e-12 * size)
    assert info["magnification"] == pytest.approx(magnification, rel=1e-10)
    assert info["film_z_mm"] == pytest.approx(film, abs=1e-11 * size)
    assert info["total_track_mm"] == info["film_z_mm"]
    # N (1 - m / m_p): the pupils' own magnification.
    pupils = -efl / (exact["ffd"] - exact["enp"])
    working = exact["f_number_stop"] * abs(1.0 - magnification / pupils)
    assert info["working_f_number"] == pytest.approx(working, rel=1e-10)
    assert info["seidel_field_deg"] == far["seidel_field_deg"]
    assert info["seidel"] != far["seidel"]
    # What does not depend on the conjugate stays.
    for key in ("efl_mm", "bfd_mm", "entrance_pupil", "exit_pupil", "f_number", "petzval_radius_mm"):
        assert info[key] == pytest.approx(far[key], rel=1e-14)
    assert (far["object_plane_mm"], far["focus_distance_mm"], far["magnification"]) == (None, None, 0.0)
    assert far["working_f_number"] == pytest.approx(far["f_number"], rel=1e-14)


# The forms of the command ----------------------------------------------------------------------------------------


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


def test_info_tells_how_far_out_the_light_comes(petzval_cli, good_lens):
    info = answer(petzval_cli("lens", "info", good_lens, "--json"))
    assert info["axial_beam_cut_by_surface"] is None
    fields = [info[key] for key in ("vignetting_free_field_deg", "half_vignetted_field_deg", "largest_field_deg")]
    assert 0.0 < fields[0] < fields[1] < fields[2] < 90.0
    stopped = answer(petzval_cli("lens", "info", good_lens, "--f-number", "22", "--json"))
    assert stopped["vignetting_free_field_deg"] > fields[0]
    # Just inside of the free field, nothing is cut; just outside, something is.
    angle = math.radians(fields[0])

    def beam(angle):
        d = [0.0, math.sin(angle), math.cos(angle)]
        rows = [y / 100.0 for y in range(-1500, 1501)]
        rays = [{"origin": [0, y * d[2] - 40 * d[1], -y * d[1] - 40 * d[2]], "direction": d} for y in rows]
        done = petzval_cli("lens", "trace", good_lens, "--rays", "-", "--json", stdin=json.dumps({"rays": rays}))
        return answer(done)["rays"]

    def cut_behind_the_stop(rays):
        """Rays through the stop, surface 2, that a later rim cuts, and gaps in what comes through the stop."""
        through = [number for number, ray in enumerate(rays) if ray["status"] == "ok"]
        ends = [rays[number] for number in (through[0] - 1, through[-1] + 1)]
        return [ray["surface"] for ray in ends]

    assert cut_behind_the_stop(beam(0.99 * angle)) == [2, 2]
    assert cut_behind_the_stop(beam(1.05 * angle)) != [2, 2]


def test_info_names_the_rim_that_cuts_the_axial_beam(petzval_cli):
    info = answer(petzval_cli("lens", "info", "sonnar-50-f2", "--json"))
    assert info["vignetting_free_field_deg"] == 0.0
    assert info["axial_beam_cut_by_surface"] == 4
    table = petzval_cli("lens", "info", "sonnar-50-f2").stdout
    assert "surface 4 cuts the beam on the axis" in table


def test_an_anamorphic_lens_has_two_sections(petzval_cli, good_lens):
    """The shipped one halves angles across, so its focal length there is half, in the same focal plane."""
    info = answer(petzval_cli("lens", "info", "anamorphic-2x-double-gauss", "--json"))
    across = info["section_x"]
    # The cylinders' radii are rounded to 1e-6 of the afocal ones.
    assert across["efl_mm"] == pytest.approx(info["efl_mm"] / 2, rel=1e-4)
    assert across["image_focal_plane_mm"] == pytest.approx(info["image_focal_plane_mm"], abs=0.01)
    assert "across (x): focal length" in petzval_cli("lens", "info", "anamorphic-2x-double-gauss").stdout
    assert answer(petzval_cli("lens", "info", good_lens, "--json"))["section_x"] is None


def test_a_fisheye_looks_behind_itself(petzval_cli):
    info = answer(petzval_cli("lens", "info", "laikin-fisheye-170", "--json"))
    assert 85.0 < info["half_vignetted_field_deg"] < 90.0 < info["largest_field_deg"] < 95.0


def test_what_is_infinite_is_null(petzval_cli, tmp_path):
    window = tmp_path / "window.lens"
    window.write_text("0 5 1.5 20 0 1\n0 50 air 20 0 0\n")
    info = answer(petzval_cli("lens", "info", window, "--json"))
    for key in ("efl_mm", "bfd_mm", "f_number", "working_f_number", "magnification", "petzval_radius_mm"):
        assert info[key] is None, key
    assert info["film_z_mm"] == 55.0
    assert all(math.isfinite(value) for value in info["seidel"])
    telecentric = tmp_path / "telecentric.lens"
    telecentric.write_text("50 0 1.5 30 0 0\n0 100 air 30 0 0\n0 20 air 5 0 1\n")
    info = answer(petzval_cli("lens", "info", telecentric, "--json"))
    assert info["entrance_pupil"] == {"z_mm": None, "diameter_mm": None}
    for key in ("seidel", "seidel_by_surface", "chromatic", "seidel_field_deg", "vignetting_free_field_deg"):
        assert info[key] is None, key
    for path in (window, telecentric):
        done = petzval_cli("lens", "info", path)
        assert done.returncode == 0, done.stderr
        assert "nan" not in done.stdout.lower() and "none" in done.stdout
    assert_complains(petzval_cli("lens", "info", telecentric, "--focus-distance", "1000"), "entrance pupil")


def test_the_table_has_the_sums_by_surface(petzval_cli, good_lens):
    info = answer(petzval_cli("lens", "info", good_lens, "--json"))
    lines = petzval_cli("lens", "info", good_lens).stdout.splitlines()
    first = next(number for number, line in enumerate(lines) if line.startswith("surface "))
    assert " ".join(lines[first].split()) == "surface S I S II S III S IV S V C L C T"
    names = [*map(str, range(info["surfaces"])), "sum"]
    rows = [*zip(info["seidel_by_surface"], info["chromatic_by_surface"], strict=True)]
    rows.append((info["seidel"], info["chromatic"]))
    table = [line.split() for line in lines[first + 1 :]]
    assert [row[0] for row in table] == names
    for row, (seidel, chromatic) in zip(table, rows, strict=True):
        numbers = [*seidel, *chromatic]
        assert [float(text) for text in row[1:]] == pytest.approx(numbers, abs=1e-5 * max(map(abs, numbers)) + 1e-6)
