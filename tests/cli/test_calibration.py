# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval calibration info|convert|stmap`, and `petzval render --calibration`: what a user types, on files as programs write them."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

from support.command_line import assert_complains
from support.places import ROOT
from support.render_commands import picture

CAMERAS = ROOT / "tests/reference/calibrations/cameras.txt"
#: As OpenCV's calibration sample writes it (opencv/samples/data/left_intrinsics.yml: the numbers of its left camera).
OPENCV = """%YAML:1.0
---
nframes: 13
image_width: 640
image_height: 480
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 5.3591573396163199e+02, 0., 3.4228315473308373e+02, 0.,
       5.3591573396163199e+02, 2.3557082909788173e+02, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ -2.6637260909660682e-01, -3.8588898922304653e-02,
       1.7831947042852964e-03, -2.8122100441115472e-04,
       2.3839153080878486e-01 ]
"""


@pytest.fixture
def opencv_file(tmp_path):
    path = tmp_path / "left.yml"
    path.write_text(OPENCV)
    return path


def test_info_says_what_a_file_holds(petzval_cli, opencv_file):
    done = petzval_cli("calibration", "info", opencv_file)
    assert done.returncode == 0, done.stderr
    assert "OpenCV's YAML, 1 camera" in done.stdout and "k1 -0.2663726091" in done.stdout
    found = json.loads(petzval_cli("calibration", "info", opencv_file, "--json").stdout)
    (camera,) = found["cameras"]
    assert camera["size_px"] == [640, 480] and camera["parameters"]["cx"] == pytest.approx(
        342.78315473308373, abs=1e-12
    )
    assert camera["covered"] == 1.0 and 50.0 < camera["horizontal_field_deg"] < 70.0
    dark = json.loads(petzval_cli("calibration", "info", CAMERAS, "--json").stdout)["cameras"][3]
    # The fold of r (1 - r^2 / 2) is at a radius of 0.816.
    assert dark["valid_to_deg"] == pytest.approx(np.degrees(np.arctan(np.sqrt(2.0 / 3.0))), abs=1e-6)
    assert 0.3 < dark["covered"] < 0.7 and dark["reason"] == "the distortion folds back before"


def test_a_calibration_goes_from_program_to_program(petzval_cli, opencv_file, tmp_path):
    first = json.loads(petzval_cli("calibration", "info", opencv_file, "--json").stdout)["cameras"][0]["parameters"]
    before = opencv_file
    for name in ("a.yaml", "b.json", "c.txt", "d.yml"):
        after = tmp_path / name
        if name == "c.txt":
            # COLMAP's models with k3 are rational.
            done = petzval_cli("calibration", "convert", before, after, "--to", "colmap")
        else:
            done = petzval_cli("calibration", "convert", before, after)
        assert done.returncode == 0, done.stderr
        before = after
    again = json.loads(petzval_cli("calibration", "info", before, "--json").stdout)["cameras"][0]["parameters"]
    # Half a pixel is taken off the principal point and put on: the last bit may go.
    assert again == pytest.approx(first, rel=1e-13)


def test_what_opencv_itself_reads_is_what_was_written(petzval_cli, opencv_file, tmp_path):
    cv2 = pytest.importorskip("cv2")
    for name in ("again.yml", "again.json"):
        out = tmp_path / name
        assert petzval_cli("calibration", "convert", opencv_file, out).returncode == 0
        theirs = cv2.FileStorage(str(out), cv2.FILE_STORAGE_READ)
        matrix, distortion = theirs.getNode("camera_matrix").mat(), theirs.getNode("distortion_coefficients").mat()
        assert matrix[0, 2] == pytest.approx(342.28315473308373, rel=1e-15) and matrix[0, 0] == 535.91573396163199
        assert distortion.ravel()[4] == 0.23839153080878486


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (OPENCV[:300], r"left.yml:1\d:\d+: 'nothing' where a list of numbers belongs"),
        (OPENCV[:400], r"left.yml:\d+:\d+: .*; the file is broken off, or not YAML or JSON"),
        (OPENCV.replace("5.3591573396163199e+02, 0., 3.4", "0.83, 0., 3.4"), "fx is 0.83 in a picture 640 pixels wide or high"),
        (OPENCV.replace("image_width: 640\n", ""), r"left.yml:1:1: |has no size of its picture"),
        ("hello\n", "there is no camera in it"),
        ("1 PINHOLE 640 480 500\n", "1 numbers where 4 of PINHOLE"),
    ],
)  # fmt: skip
def test_wrong_files_are_told_in_a_line(petzval_cli, opencv_file, text, told):
    opencv_file.write_text(text)
    done = petzval_cli("calibration", "info", opencv_file)
    assert done.returncode == 1 and done.stdout == "" and len(done.stderr.splitlines()) == 1
    assert re.search(told, done.stderr), done.stderr


def test_what_cannot_be_done_is_told(petzval_cli, tmp_path):
    out = tmp_path / "out.yaml"
    assert_complains(petzval_cli("calibration", "convert", CAMERAS, out), "there are 4; choose one of 1, 2, 3, 4")
    assert_complains(petzval_cli("calibration", "convert", CAMERAS, tmp_path / "out.png"), "its ending says no format")
    assert_complains(
        petzval_cli("calibration", "stmap", CAMERAS, "-o", tmp_path / "m.exr"), "there are 4 cameras; choose one of"
    )
    assert_complains(petzval_cli("calibration", "info", tmp_path / "none.yml"), "none.yml:1:1: cannot be read")
    assert not out.exists()


def test_a_map_takes_the_distortion_out(petzval_cli, blender, tmp_path):
    """Its numbers are those of the model, by hand: camera 2 is OpenCV's."""
    out = tmp_path / "map.exr"
    done = petzval_cli("calibration", "stmap", CAMERAS, "--camera", "2", "-o", out)
    assert done.returncode == 0, done.stderr
    st = picture(out)
    assert st.shape == (64, 96, 4)
    fx, fy, cx, cy, k1, k2, p1, p2 = 80, 81, 47.2, 33.1, -0.25, 0.06, 0.002, -0.001
    column, row = np.meshgrid(np.arange(96) + 0.5, np.arange(64)[::-1] + 0.5)
    x, y = (column - cx) / fx, (row - cy) / fy
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2 * r2
    u = fx * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + cx
    v = fy * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + cy
    assert np.abs(st[..., 0] - u / 96).max() < 1e-6 and np.abs(st[..., 1] - (1 - v / 64)).max() < 1e-6


def test_a_render_by_a_calibration(cli_renders):
    """A pinhole's calibration is Blender's pinhole, pixel by pixel; one that folds says so; another shape is refused."""
    size = ("--resolution", "96x64", "--samples", 4)
    plain, same, dark, wrong = cli_renders(
        ("--camera", "pinhole", "--focal-length", 37.5, "--film", "36x24", *size),
        ("--calibration", str(CAMERAS), "--calibration-camera", "1", *size),
        ("--calibration", str(CAMERAS), "--calibration-camera", "4", *size),
        ("--calibration", str(CAMERAS), "--calibration-camera", "1", "--resolution", "64x64", "--samples", 1),
    )
    assert plain.returncode == same.returncode == dark.returncode == 0, plain.stderr + same.stderr + dark.stderr
    assert (np.abs(picture(plain.out) - picture(same.out)) < 1e-3).mean() > 0.999
    assert same.stats["lens"] == "calibrated" and same.stats["camera_rays_lost"] == 0
    (told,) = [one for one in dark.stats["warnings"] if "outside of its calibration" in one]
    assert "the distortion folds back before, valid to 39.2 degrees" in told
    part = float(re.search(r"([\d.]+) % of the picture is black", told).group(1)) / 100
    assert abs(dark.stats["camera_rays_lost"] / dark.stats["camera_rays"] - part) < 0.02
    assert picture(dark.out)[0, 0, :3].max() == 0.0
    assert wrong.returncode == 1 and "has another shape; set a resolution of 96 x 64" in wrong.stderr
