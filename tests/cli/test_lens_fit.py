# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval lens fit`: a perturbed copy of a lens is found again by its calibration, a real camera comes nearer, and what cannot be."""

from __future__ import annotations

import json
import re

import pytest

from support.command_line import assert_complains
from support.places import ROOT

pytestmark = pytest.mark.once
LENS = "double-gauss-f2-tronnier"
#: The DSLR of the ETH3D benchmark's scene "courtyard" (Schöps and others 2017), a Nikon D3X with 35.9 x 24.0 mm, as its cameras.txt has it. The
#: benchmark names no lens; its focal length is 20.2 mm.
ETH3D = (
    "0 THIN_PRISM_FISHEYE 6048 4032 3411.42 3410.02 3041.29 2014.07 0.21047 0.21102 -5.36231e-06 0.00051541 -0.158023 0.406856 "
    "-8.46499e-05 0.000861313\n"
)
RATIONAL = ("--coefficients", "k1,k2,k3,k4,k5,k6")


@pytest.fixture(scope="module")
def fit(petzval_cli):
    """The answer of `petzval lens fit LENS --calibration FILE ... --json`."""

    def run(lens, calibration, *arguments):
        done = petzval_cli("lens", "fit", lens, "--calibration", calibration, *arguments, "--json")
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run


@pytest.fixture(scope="module")
def perturbed(petzval_cli, tmp_path_factory):
    """A copy of the lens with its gap before the stop 0.4 mm wider, the whole 1.5 % larger; its calibration, the gap's surface and widths."""
    folder = tmp_path_factory.mktemp("perturbed")
    lines = (ROOT / "lenses" / f"{LENS}.lens").read_text().splitlines()
    head = next(i for i, line in enumerate(lines) if line.startswith("#radius"))
    rows = [line.split() for line in lines[head + 1 :] if line.strip() and not line.startswith("#")]
    gap = next(i for i, row in enumerate(rows) if row[2] == "air" and float(row[1]) > 5.0)
    before = float(rows[gap][1])
    rows[gap][1] = str(before + 0.4)
    path = folder / "wider.lens"
    path.write_text("\n".join([*lines[: head + 1], *(" ".join(row) for row in rows)]) + "\n")
    efl = json.loads(petzval_cli("lens", "info", path, "--json").stdout)["efl_mm"]
    options = ("--focal-length", str(1.015 * efl), "--film", "72x48", "--size", "1920x1280")
    done = petzval_cli("lens", "calibrate", path, *options, *RATIONAL, "-o", folder / "camera.yml")
    assert done.returncode == 0, done.stderr
    return folder / "camera.yml", gap, before, 1.015 * efl


def test_a_perturbed_copy_is_found_again(fit, petzval_cli, perturbed, tmp_path):
    """The published lens, fitted to the calibration of its perturbed copy: its gap to 0.02 mm, its focal length to 1e-4, and next to nothing
    left. The calibration's formula leaves a thousandth of a pixel, of which each takes its part."""
    calibration, gap, before, efl = perturbed
    out = tmp_path / "fitted.lens"
    found = fit(LENS, calibration, "--film", "72x48", "--gaps", f"1:{gap}", "-o", out)
    (one,) = found["gaps"]
    assert one["surface"] == gap and one["before_mm"] == pytest.approx(before, abs=1e-9)
    assert one["after_mm"] - before == pytest.approx(0.4, abs=0.02) and not one["is_at_end"]
    assert found["after"]["efl_mm"] == pytest.approx(efl, rel=1e-4)
    assert found["before"]["rms_px"] > 5.0 and found["after"]["rms_px"] < 0.01
    assert found["after"]["rms_um"] == pytest.approx(37.5 * found["after"]["rms_px"], rel=1e-9)
    # The file is that lens: it is read again, says where it is from, and needs no other fit.
    text = out.read_text()
    assert re.search(r"^# fitted: to camera\.yml \(opencv, 1920 x 1280 pixels", text, re.MULTILINE)
    assert "# film: 72 x 48" in text and "# focal_length:" not in text
    info = json.loads(petzval_cli("lens", "info", out, "--json").stdout)
    assert info["efl_mm"] == pytest.approx(found["after"]["efl_mm"], rel=1e-12)
    again = fit(out, calibration, "--adjust", "film-distance")
    assert again["before"]["rms_px"] == pytest.approx(found["after"]["rms_px"], rel=1e-3)


def test_without_the_gap_more_is_left(fit, perturbed):
    calibration, gap, *_ = perturbed
    alone = fit(LENS, calibration, "--film", "72x48")
    both = fit(LENS, calibration, "--film", "72x48", "--gaps", f"5%:{gap}")
    assert both["after"]["rms_px"] < 0.2 * alone["after"]["rms_px"] < 0.2 * alone["before"]["rms_px"]


def test_a_focus_distance_is_found(fit, petzval_cli, tmp_path):
    """A lens that is focused by its film at 1.5 m: a far scene's calibration of it, with the film where 1.5 m is sharp, cannot be had by the
    command; so the calibration is of the plane at 1.5 m, and the lens starts at 3 m, whose plane is taken to be the scene."""
    camera = tmp_path / "camera.yml"
    options = ("--film", "72x48", "--size", "1920x1280")
    done = petzval_cli("lens", "calibrate", LENS, *options, *RATIONAL, "--focus-distance", "1500", "-o", camera)
    assert done.returncode == 0, done.stderr
    found = fit(LENS, camera, "--film", "72x48", "--adjust", "focus", "--focus-distance", "3000")
    assert found["after"]["focus_distance_mm"] == pytest.approx(1500.0, rel=1e-3)
    assert found["after"]["rms_px"] < 0.01 < found["before"]["rms_px"]


def test_groups_that_focus_are_found_by_their_distortion(fit, petzval_cli, tmp_path):
    """A lens whose rear group focuses, at 0.5 m: from 0.7 m on, and from infinity with its size free, too. It stays a lens that focuses."""
    camera = tmp_path / "camera.yml"
    done = petzval_cli("lens", "calibrate", "nikkor-28-f1.4", "--focus-distance", "500", "-o", camera)
    assert done.returncode == 0, done.stderr
    found = fit("nikkor-28-f1.4", camera, "--adjust", "focus", "--focus-distance", "700", "-o", tmp_path / "a.lens")
    assert found["after"]["focus_distance_mm"] == pytest.approx(500.0, rel=2e-3)
    both = fit("nikkor-28-f1.4", camera, "--adjust", "focus,focal-length")
    # The model of three coefficients leaves a hundredth of a pixel, which the two share.
    assert both["after"]["focus_distance_mm"] == pytest.approx(500.0, rel=0.02)
    assert both["scale"] == pytest.approx(1.0, abs=2e-3)
    assert "# moving:" in (tmp_path / "a.lens").read_text()


def test_a_zoom_is_written_as_it_stands(fit, petzval_cli, tmp_path):
    camera = tmp_path / "camera.yml"
    zoom = ("nikkor-z-24-70-f4", "--focal-length", "50")
    done = petzval_cli("lens", "calibrate", *zoom, *RATIONAL, "-o", camera)
    assert done.returncode == 0, done.stderr
    found = fit(zoom[0], camera, *zoom[1:], "-o", tmp_path / "a.lens")
    assert found["before"]["rms_px"] < 0.01 and found["scale"] == pytest.approx(1.0, abs=1e-5)
    info = json.loads(petzval_cli("lens", "info", tmp_path / "a.lens", "--json").stdout)
    assert info["efl_mm"] == pytest.approx(50.0, abs=1e-3)
    assert "# moving:" not in (tmp_path / "a.lens").read_text()


def test_a_real_camera_comes_nearer(fit, tmp_path):
    """Lenses of about 20 mm beside the D3X: scaled they come from 400 to 1000 um to 40 to 90, and with gaps nearer still. No patent is the
    product, nor of the one that was used, so more cannot be asked."""
    cameras = tmp_path / "cameras.txt"
    cameras.write_text(ETH3D)
    for lens in ("nikkor-20-f1.8", "biogon-21-f4.5"):
        scaled = fit(lens, cameras, "--film", "35.9x24")
        with_gaps = fit(lens, cameras, "--film", "35.9x24", "--gaps", "5%")
        assert scaled["before"]["rms_um"] > 400.0 and scaled["after"]["rms_um"] < 100.0
        assert with_gaps["after"]["rms_um"] < 0.9 * scaled["after"]["rms_um"], lens
        # By its own pinhole and pixels of 5.936 um.
        assert scaled["after"]["efl_mm"] == pytest.approx(20.25, rel=0.05)
    same = fit("nikkor-20-f1.8", cameras, "--pixel-pitch-um", "5.9358465608")
    assert same["after"]["rms_px"] == pytest.approx(
        fit("nikkor-20-f1.8", cameras, "--film", "35.9x24")["after"]["rms_px"]
    )


def opencv_file(path, fx, fy, size=(1920, 1280)):
    width, height = size
    path.write_text(
        f"%YAML:1.0\n---\nimage_width: {width}\nimage_height: {height}\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
        f"   data: [ {fx}, 0., {width / 2 - 0.5}, 0., {fy}, {height / 2 - 0.5}, 0., 0., 1. ]\n"
        "distortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n   data: [ 0., 0., 0., 0., 0. ]\n"
    )
    return path


def test_what_cannot_be_is_one_line(petzval_cli, tmp_path):
    good = opencv_file(tmp_path / "good.yml", 1300.0, 1300.0)
    cases = [
        (("nikkor-24-f1.8", opencv_file(tmp_path / "square.yml", 1300, 1300, (1280, 1280))), "has another shape than a film of 36 x 24 mm"),
        (("nikkor-24-f1.8", opencv_file(tmp_path / "wide.yml", 1300, 1430)), "pixels are not of this shape"),
        (("nikkor-24-f1.8", opencv_file(tmp_path / "far.yml", 5300, 5300)), "the calibration's focal length is 99.37 mm"),
        (("kreitzer-tele", good), "names no film: give --pixel-pitch-um or --film"),
        (("questar-3.5", good, "--pixel-pitch-um", "900"), "has mirrors"),
        (("nikkor-24-f1.8", good, "--adjust", "none"), "nothing is to be adjusted"),
        (("nikkor-24-f1.8", good, "--adjust", "zoom"), "nothing called 'zoom' is adjusted; name focal-length, focus"),
        (("nikkor-24-f1.8", good, "--gaps", "120%"), "a tolerance of 1.2 for gaps"),
        (("nikkor-24-f1.8", good, "--gaps", "0.1:0"), "behind surface 0 is no fixed gap in air"),
        (("nikkor-24-f1.8", good, "-o", tmp_path / "a.zmx"), "its ending is not .lens"),
        (("nikkor-24-f1.8", tmp_path / "none.yml"), "none.yml:1:1: cannot be read"),
    ]  # fmt: skip
    for (lens, calibration, *more), words in cases:
        assert_complains(petzval_cli("lens", "fit", lens, "--calibration", calibration, *more), words)
    wide = petzval_cli(
        "lens", "fit", "nikkor-24-f1.8", "--calibration", tmp_path / "wide.yml", "--pixel-pitch-um", "18.75,17.0455"
    )
    assert wide.returncode == 0, wide.stderr
    bad = petzval_cli("lens", "fit", "nikkor-24-f1.8", "--calibration", good, "--gaps", "some")
    assert_complains(bad, "argument --gaps: invalid tolerance value: 'some'", status=2)


def test_what_is_not_told_apart_is_noted(petzval_cli, perturbed):
    calibration, *_ = perturbed
    done = petzval_cli(
        "lens", "fit", LENS, "--calibration", calibration, "--film", "72x48", "--adjust", "focal-length,film-distance"
    )
    assert done.returncode == 0 and "hardly tells apart" in done.stderr
    assert done.stderr.rstrip().endswith("focal-length and film-distance"), done.stderr
