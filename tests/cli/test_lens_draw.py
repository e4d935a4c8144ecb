# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval lens draw`: pictures and their content."""

import json
import math
import struct
from xml.etree import ElementTree

import pytest

pytestmark = pytest.mark.once
GLASSES = "#d3e5f2"


def drawn(petzval_cli, tmp_path, name, *more):
    out = tmp_path / name
    done = petzval_cli("lens", "draw", *more, "-o", out)
    assert done.returncode == 0, done.stderr
    return out, done


def test_a_drawing_shows_every_element_and_ray(petzval_cli, tmp_path):
    out, done = drawn(petzval_cli, tmp_path, "lens.svg", "cooke-triplet-50mm", "--fields", "0", "20", "--rays", "5")
    assert done.stdout.startswith(str(out))
    text = out.read_text()
    root = ElementTree.fromstring(text)
    assert root.tag.endswith("svg")
    # Three glasses, two fields of five rays: the marks in the legend are two lines more.
    assert text.count(GLASSES) == 3
    assert text.count("stroke: #1f5fae") == 6 and text.count("stroke: #2d8a3e") == 6
    assert "Cooke triplet" in text and "20°" in text and "f = 50.02" in text
    # The same bytes another time.
    again, _ = drawn(petzval_cli, tmp_path, "again.svg", "cooke-triplet-50mm", "--fields", "0", "20", "--rays", "5")
    assert again.read_bytes() == out.read_bytes()


def test_png_is_a_picture(petzval_cli, tmp_path):
    out, _ = drawn(petzval_cli, tmp_path, "lens.png", "newtonian-f5")
    data = out.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    width, height = struct.unpack(">II", data[16:24])
    assert width == 1500 and height >= 500


def test_json_says_what_is_drawn(petzval_cli, tmp_path):
    out, _ = drawn(
        petzval_cli, tmp_path, "lens.json", "double-gauss-f2-tronnier", "--f-number", "4", "--focus-distance", "2000"
    )
    found = json.loads(out.read_text())
    info = json.loads(
        petzval_cli(
            "lens", "info", "double-gauss-f2-tronnier", "--f-number", "4", "--focus-distance", "2000", "--json"
        ).stdout
    )
    assert [field["angle_deg"] for field in found["fields"]] == pytest.approx([0.0, 15.4, 22.0])
    assert all(len(field["rays"]) == 7 for field in found["fields"])
    assert found["film_z_mm"] == info["film_z_mm"] and found["efl_mm"] == info["efl_mm"]
    # The rays of the axis come from the object and go to the film; those at the rim past the closed stop's.
    object_z = info["object_plane_mm"]
    for ray in found["fields"][0]["rays"]:
        (z0, y0), (z1, y1) = ray[:2]
        assert y0 + (object_z - z0) * (y1 - y0) / (z1 - z0) == pytest.approx(0.0, abs=1e-6)
        assert ray[-1][0] == pytest.approx(found["film_z_mm"]) and abs(ray[-1][1]) < 0.2
    rim = max(abs(ray[1 + found["stop"]][1]) for ray in found["fields"][0]["rays"])
    assert rim == pytest.approx(found["stop_semi_diameter_mm"], rel=1e-6)


def test_what_stays_dark_is_said(petzval_cli, tmp_path):
    out, done = drawn(petzval_cli, tmp_path, "lens.svg", "petzval-kodak", "--fields", "0", "60")
    assert "nothing comes through from 60 degrees" in done.stderr
    assert "60° (dark)" in out.read_text()


@pytest.mark.parametrize(
    "arguments, said",
    [
        (("cooke-triplet-50mm", "-o", "lens.bmp"), "its ending is not .svg, .png, .pdf or .json"),
        (("cooke-triplet-50mm", "--rays", "0", "-o", "lens.svg"), "0 rays a field: give 1 to 1000"),
        (("cooke-triplet-50mm", "--fields", "200", "-o", "lens.svg"), "a field of 200 degrees"),
        (("cooke-triplet-50mm", "-o", "nowhere/lens.svg"), "cannot write nowhere/lens.svg"),
        (("no-such-lens", "-o", "lens.svg"), "no-such-lens"),
    ],
)
def test_what_cannot_be_drawn_is_said_in_a_line(petzval_cli, arguments, said):
    done = petzval_cli("lens", "draw", *arguments)
    assert done.returncode != 0 and said in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


#: Every sixth lens in `make test`, all as a recipe.
@pytest.mark.parametrize("step", [6, pytest.param(1, marks=pytest.mark.recipe)])
def test_every_shipped_lens_can_be_drawn(step):
    """By the engine: as many rays on the axis as asked for, whole lines, nothing that is no number; but for the eye with gradients,
    whose rays take long: tests/cli/test_lens_eyes.py draws it."""
    from petzval import _native
    from petzval.places import lenses_folder

    for path in sorted(lenses_folder().glob("*.lens"))[::step]:
        if path.stem == "eye-liou-brennan":
            continue
        found = json.loads(_native.lens_drawing_json(_native.Lens(str(path)), None, [], 5))
        assert len(found["fields"][0]["rays"]) == 5, path.name
        for field in found["fields"]:
            places = [number for ray in field["rays"] for place in ray for number in place]
            assert all(math.isfinite(number) for number in places), path.name
        assert all(len(surface["points"]) > 2 for surface in found["surfaces"]), path.name
