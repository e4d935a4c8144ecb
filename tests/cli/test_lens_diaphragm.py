# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval lens info|trace` with blades or a mask in the diaphragm."""

from __future__ import annotations

import json
import struct
import zlib
from math import cos, pi, radians, sin, sqrt

import pytest

from support.command_line import GOOD_LENS, answer, assert_complains

pytestmark = pytest.mark.once

STOP_MM = 10.0


@pytest.fixture
def lens(tmp_path):
    """A lens whose stop, surface 2, is the round hole of 10 mm that limits it."""
    path = tmp_path / "good.lens"
    path.write_text(GOOD_LENS)
    return path


@pytest.fixture
def info(petzval_cli, lens):
    return lambda *options: answer(petzval_cli("lens", "info", lens, "--json", *options))


@pytest.fixture
def passing(petzval_cli, lens):
    """`passing(options...)`: for points of the stop at 97 % of its radius, whether a ray through each gets through."""

    def run(*options, angles=range(0, 360, 5), part=0.97):
        # From the film side straight ahead: after the stop comes air alone.
        at = [(part * STOP_MM / 2 * cos(radians(a)), part * STOP_MM / 2 * sin(radians(a))) for a in angles]
        rays = [{"origin": [x, y, 20.0], "direction": [0.0, 0.0, -1.0], "wavelength_nm": 587.5618} for x, y in at]
        question = json.dumps({"from": "film", "rays": rays})
        traced = answer(petzval_cli("lens", "trace", lens, "--rays", "-", "--json", *options, stdin=question))["rays"]
        for ray in traced:
            assert (ray["status"], ray["surface"]) in (("ok", None), ("blade_stop", 2), ("outside_aperture", 2)), ray
        return [ray["status"] == "ok" for ray in traced]

    return run


def square_png(path, side, is_open):
    """A grey picture; `is_open(x, y)` of the middles of its pixels, from -1 to 1, y up."""

    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    middles = [(2 * i + 1) / side - 1 for i in range(side)]
    rows = b"".join(b"\0" + bytes(255 * is_open(x, -y) for x in middles) for y in middles)
    head = struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    )
    return path


def test_blades_close_over_the_round_opening(info):
    """The corners of a polygon lie on the circle: the same planes and f-number, less area."""
    round_one, six, curved = info(), info("--blades", 6), info("--blades", 6, "--blade-curvature", 0.5)
    own = {"stop_area_mm2", "f_number_by_area", "t_number"}
    # Without the corners' steeper rays the glass lets through a little more, or less.
    assert six["t_number"] == pytest.approx(round_one["t_number"], rel=1e-4)
    assert {key: value for key, value in six.items() if key not in own} == {
        key: value for key, value in round_one.items() if key not in own
    }
    radius = round_one["stop_diameter_mm"] / 2
    assert round_one["stop_area_mm2"] == pytest.approx(pi * radius**2, rel=1e-12)
    assert round_one["f_number_by_area"] == pytest.approx(round_one["f_number"], rel=1e-12)
    hexagon = 1.5 * sqrt(3.0) * radius**2
    assert six["stop_area_mm2"] == pytest.approx(hexagon, rel=1e-12)
    assert six["f_number_by_area"] == pytest.approx(six["f_number"] * sqrt(pi * radius**2 / hexagon), rel=1e-12)
    assert six["stop_area_mm2"] < curved["stop_area_mm2"] < round_one["stop_area_mm2"]
    assert info("--blades", 6, "--blade-curvature", 1)["stop_area_mm2"] == round_one["stop_area_mm2"]


def test_the_table_shows_the_area(petzval_cli, lens):
    rows = petzval_cli("lens", "info", lens, "--blades", 6).stdout.splitlines()
    assert any(row.startswith("diaphragm's area") and row.endswith(" mm2") for row in rows)


def test_rays_stop_at_the_blades(passing):
    assert all(passing())
    # At 97 % of the radius a hexagon is open within asin's reach of its corners: cos(30 deg) / 0.97 = cos(26.8 deg).
    for turn in (0, 10):
        open_at = passing("--blades", 6, "--blade-rotation", turn)
        for angle, is_open in zip(range(0, 360, 5), open_at, strict=True):
            from_corner = abs((angle - turn + 30) % 60 - 30)
            assert is_open == (from_corner < 30 - 26.8), (turn, angle)
    assert sum(passing("--blades", 6)) < sum(passing("--blades", 6, "--blade-curvature", 0.8))


def test_a_mask_shapes_the_opening(info, passing, tmp_path):
    pytest.importorskip("bpy")
    right = square_png(tmp_path / "right.png", 16, lambda x, _y: x > 0.0)
    whole = info()
    masked = info("--aperture-mask", right)
    assert masked["f_number"] == whole["f_number"]
    # The areas of cells on the rim are counted to a hundredth.
    assert masked["stop_area_mm2"] == pytest.approx(whole["stop_area_mm2"] / 2, rel=0.01)
    for turn in (0, 90):
        open_at = passing("--aperture-mask", right, "--blade-rotation", turn, angles=range(5, 360, 10), part=0.9)
        for angle, is_open in zip(range(5, 360, 10), open_at, strict=True):
            assert is_open == (cos(radians(angle - turn)) > 0.0), (turn, angle)
    upper = square_png(tmp_path / "upper.png", 16, lambda _x, y: y > 0.0)
    open_at = passing("--aperture-mask", upper, angles=(90, 270), part=0.5)
    assert open_at == [True, False]


@pytest.mark.parametrize(
    "options",
    [
        ("--blades", "2"),
        ("--blades", "25"),
        ("--blades", "six"),
        ("--blade-curvature", "round"),
        ("--blade-rotation", "nan"),
        ("--blades", "6", "--aperture-mask", "mask.png"),
    ],
)
def test_bad_usage(petzval_cli, lens, options):
    assert_complains(petzval_cli("lens", "info", lens, *options), "--help", status=2)


def test_what_the_engine_refuses(petzval_cli, lens):
    done = petzval_cli("lens", "info", lens, "--blades", "6", "--blade-curvature", "1.5", "--json")
    assert_complains(done, "curvature", "1.5")


def test_masks_that_are_none(petzval_cli, lens, tmp_path):
    assert_complains(petzval_cli("lens", "info", lens, "--aperture-mask", tmp_path / "none.png"), "none.png")
    pytest.importorskip("bpy")
    (tmp_path / "text.png").write_text("this is no picture")
    assert_complains(petzval_cli("lens", "info", lens, "--aperture-mask", tmp_path / "text.png"), "text.png")
    dark = square_png(tmp_path / "dark.png", 8, lambda _x, _y: False)
    assert_complains(petzval_cli("lens", "info", lens, "--aperture-mask", dark), "dark.png", "dark")
