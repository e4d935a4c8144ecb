# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval lens calibrate`: focal lengths by closed forms, rays of the map traced back, OpenCV's own projection, and what cannot be."""

from __future__ import annotations

import json

import numpy as np
import pytest

from support import zipped_exr
from support.command_line import assert_complains
from support.places import ROOT

pytestmark = pytest.mark.once
#: A small picture of a wide lens, whole.
WIDE = ("nikkor-24-f1.8", "--size", "192x128")
FISHEYE = ("fisheye-nikkor-16-f2.8", "--size", "192x128", "--model", "fisheye")


@pytest.fixture(scope="module")
def calibrate(petzval_cli):
    """The answer of `petzval lens calibrate ... --json`."""

    def run(*arguments):
        done = petzval_cli("lens", "calibrate", *arguments, "--json")
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run


def rays_of(path):
    """Origins and directions of a ray map, (height, width, 3), and where it has any."""
    channels, comments = zipped_exr.read(path)
    assert "the ray of each pixel" in comments
    of = [np.stack([channels[f"{what}.{axis}"] for axis in "XYZ"], -1) for what in ("origin", "direction")]
    return *of, channels["A"] == 1.0


def test_a_lens_without_distortion_is_a_pinhole(calibrate, petzval_cli):
    """A tenth of a degree of a telescope: its focal length over the pixel's width; and focused near, the image's distance that its magnification
    says, as tan θ is the height over the distance from the entrance pupil. Its own distortion is of the third power: less than 1e-6 there."""
    lens = ("triplet-telescope-100mm", "--film", "0.36x0.24", "--size", "720x480", "--coefficients", "none")
    far = calibrate(*lens)
    assert far["free"] == ["fx"] and far["rms_px"] < 1e-3
    assert far["parameters"]["fx"] == pytest.approx(far["efl_mm"] / 0.0005, rel=2e-6)
    assert (far["parameters"]["cx"], far["parameters"]["cy"]) == (360.0, 240.0)
    near = calibrate(*lens, "--focus-distance", "3000")
    info = json.loads(petzval_cli("lens", "info", lens[0], "--focus-distance", "3000", "--json").stdout)
    assert near["parameters"]["fx"] == pytest.approx(-info["magnification"] * 3000.0 / 0.0005, rel=2e-6)


def test_a_shifted_film_shifts_the_principal_point(calibrate):
    """A lens 3 mm to the right and 1.5 mm up against a film of 36 x 24 mm: the axis lies a twelfth right of the middle and a sixteenth above."""
    found = calibrate("hologon-15-f8", "--size", "360x240", "--shift", "3,1.5")
    centre = [found["parameters"]["cx"], found["parameters"]["cy"]]
    film = found["picture_mm"]
    # The axis lies where the film was before it moved to the left and down, and the picture on the film is upside down.
    assert np.abs(np.array(centre) - [180.0 - 3.0 / film[0] * 360.0, 120.0 + 1.5 / film[1] * 240.0]).max() < 1e-9
    assert found["rms_px"] < 0.01


@pytest.mark.parametrize("case", [WIDE, FISHEYE])
def test_rays_of_the_map_come_back(calibrate, petzval_cli, tmp_path, case):
    """Every twelfth ray, sent from the scene through the lens, hits the film in the middle of its pixel: to the rounding of 32 bits."""
    found = calibrate(*case, "--map", tmp_path / "rays.exr")
    origin, direction, is_lit = rays_of(tmp_path / "rays.exr")
    assert is_lit.mean() == pytest.approx(found["lit"], abs=0.01)
    assert np.abs(np.linalg.norm(direction, axis=-1)[is_lit] - 1.0).max() < 1e-6
    rows, columns = np.nonzero(is_lit)
    rows, columns = rows[::12], columns[::12]
    turn = np.array([1.0, -1.0, -1.0])
    start = origin[rows, columns].astype(float) * turn + [0.0, 0.0, found["centre_z_mm"]]
    along = -direction[rows, columns].astype(float) * turn
    # From some way before the lens on, so that the ray has to find the first surface itself.
    asked = [{"origin": list(p - 40.0 * d), "direction": list(d)} for p, d in zip(start, along, strict=True)]
    done = petzval_cli("lens", "trace", case[0], "--rays", "-", "--json", stdin=json.dumps({"rays": asked}))
    out = json.loads(done.stdout)["rays"]
    film_z = json.loads(petzval_cli("lens", "info", case[0], "--json").stdout)["film_z_mm"]
    places = []
    for ray in out:
        assert ray["status"] == "ok", ray
        p, d = np.array(ray["origin"]), np.array(ray["direction"])
        places.append((p + d * (film_z - p[2]) / d[2])[:2])
    (width, height), (across, up) = found["size_px"], found["picture_mm"]
    places = np.array(places)
    pixels = np.stack([(0.5 - places[:, 0] / across) * width, (0.5 + places[:, 1] / up) * height], 1)
    assert np.abs(pixels - np.stack([columns + 0.5, rows + 0.5], 1)).max() < 1e-4


def numpy_residual(found, direction):
    """The distances of directions, projected by OpenCV's formulas, from the middles of their pixels, pixels."""
    p = found["parameters"]
    x, y = direction[..., 0] / direction[..., 2], direction[..., 1] / direction[..., 2]
    r2 = x * x + y * y
    stretch = 1.0 + p["k1"] * r2 + p["k2"] * r2**2 + p["k3"] * r2**3
    height, width = x.shape
    off_x = p["fx"] * x * stretch + p["cx"] - (np.arange(width) + 0.5)
    off_y = p["fy"] * y * stretch + p["cy"] - (np.arange(height) + 0.5)[:, None]
    return off_x, off_y


def test_residuals_are_what_the_formulas_leave(calibrate, tmp_path):
    found = calibrate(*WIDE, "--map", tmp_path / "rays.exr", "--residual", tmp_path / "off.exr")
    _, direction, is_lit = rays_of(tmp_path / "rays.exr")
    channels, _ = zipped_exr.read(tmp_path / "off.exr")
    off = np.hypot(channels["X"], channels["Y"])
    expected = numpy_residual(found, direction.astype(float))
    assert is_lit.all() and (channels["A"] == 1.0).all()
    # Directions of 32 bits are 6e-8 off, of 130 pixels of focal length and slopes to 0.9.
    assert max(np.abs(channels["X"] - expected[0]).max(), np.abs(channels["Y"] - expected[1]).max()) < 1e-4
    # The grid of the command has the corners, where there is most; the map has the middles of their pixels.
    assert np.sqrt((off**2).mean()) == pytest.approx(found["rms_px"], rel=0.1)
    assert 0.5 * found["worst_px"] < off.max() <= found["worst_px"] + 1e-4


@pytest.mark.parametrize("case", [WIDE, FISHEYE])
def test_opencv_reads_the_file_and_projects_to_the_same_places(calibrate, tmp_path, case):
    cv2 = pytest.importorskip("cv2", reason="OpenCV is not installed")
    found = calibrate(*case, "-o", tmp_path / "camera.yml", "--map", tmp_path / "rays.exr")
    _, direction, is_lit = rays_of(tmp_path / "rays.exr")
    file = cv2.FileStorage(str(tmp_path / "camera.yml"), cv2.FILE_STORAGE_READ)
    matrix, distortion = (file.getNode(name).mat() for name in ("camera_matrix", "distortion_coefficients"))
    # OpenCV's formula of fisheyes takes the tangent of the angle, and ends at 90 degrees.
    is_seen = is_lit & (direction[..., 2] > 0.05)
    assert is_seen.mean() > 0.9
    points = direction[is_seen].astype(float)
    points = points / points[:, 2:]
    none = np.zeros(3)
    if "fisheye" in case:
        places, _ = cv2.fisheye.projectPoints(points.reshape(-1, 1, 3), none, none, matrix, distortion)
    else:
        places, _ = cv2.projectPoints(points, none, none, matrix, distortion)
    rows, columns = np.nonzero(is_seen)
    off = np.linalg.norm(places.reshape(-1, 2) - np.stack([columns, rows], 1), axis=1)
    assert off.max() < found["worst_px"] + 1e-3 and np.sqrt((off**2).mean()) < 1.2 * found["rms_px"] + 1e-3


def test_files_are_read_again(calibrate, petzval_cli, tmp_path):
    """The parameters of every format are those of the command, and `--to` says which."""
    for ending, options in ((".yml", ()), (".json", ()), (".yaml", ()), (".txt", ()), (".yaml", ("--to", "opencv"))):
        out = tmp_path / f"camera{ending}"
        found = calibrate("planar-80-f2.8", "--size", "960x960", "-o", out, *options)
        info = json.loads(petzval_cli("calibration", "info", out, "--json").stdout)["cameras"][0]
        assert info["model"] == "opencv" and info["size_px"] == [960, 960]
        assert info["parameters"] == pytest.approx(found["parameters"], rel=1e-12)


def test_every_model_is_near(calibrate):
    """A wide lens of 45.8 degrees at 480 pixels, by each model: polynomials to a tenth of a pixel, one or two numbers to a few."""
    lens = ("biogon-21-f4.5", "--size", "480x320")
    polynomials = (
        "opencv",
        "fisheye",
        "thin-prism-fisheye",
        "rad-tan-thin-prism-fisheye",
        "omni",
        "f-theta",
        "f-theta-to-pixels",
    )
    for model in (*polynomials, "fov", "division", "eucm", "double-sphere"):
        found = calibrate(*lens, "--model", model)
        most = 0.1 if model in polynomials else 2.0
        assert found["rms_px"] < most and found["covered"] == 1.0, (model, found["rms_px"])


def test_lenses_without_symmetry(calibrate, tmp_path):
    """An anamorphic lens squeezes by two; OpenCV's tilted sensor is a tilted film; an element that is displaced moves the principal point."""
    squeezed = calibrate("anamorphic-2x-double-gauss")["parameters"]
    # To first order of its design: 100 mm up and 50 mm across.
    assert squeezed["fy"] / squeezed["fx"] == pytest.approx(2.0, rel=0.01)
    plain = calibrate("nikkor-24-f1.8", "--tilt", "3")
    tilted = calibrate("nikkor-24-f1.8", "--tilt", "3", "--coefficients", "k1,k2,k3,tau_x,tau_y")
    assert tilted["rms_px"] < 0.06 < 10 * tilted["rms_px"] < plain["rms_px"]
    assert abs(tilted["parameters"]["tau_y"]) < 1e-6 < abs(tilted["parameters"]["tau_x"])
    moved = tmp_path / "moved.lens"
    text = (ROOT / "lenses/cooke-triplet-50mm.lens").read_text()
    moved.write_text(text.replace("#radius", "# element: 4-5 decenter_y=0.3\n#radius"))
    found = calibrate(moved)
    assert abs(found["parameters"]["cy"] - 640.0) > 5.0 and abs(found["parameters"]["cx"] - 960.0) < 1e-3
    assert found["rms_px"] < 1.0


def test_a_zoom_stands_where_it_is_asked(calibrate, petzval_cli):
    for focal in ("24.72", "50", "67.9"):
        found = calibrate("nikkor-z-24-70-f4", "--focal-length", focal, "--size", "1920x1280")
        width = found["picture_mm"][0]
        assert found["parameters"]["fx"] * width / 1920 == pytest.approx(float(focal), rel=2e-3)


def test_the_part_that_is_lit_is_fitted(petzval_cli, calibrate):
    """A lens whose picture is a circle in its film."""
    found = calibrate("laikin-fisheye-170", "--model", "fisheye", "--film", "36x24", "--size", "360x240")
    # Its 85 degrees are 7.0 mm from the middle, of a film of 864 mm2, by the equidistant start of its distortion -7 %.
    assert 0.1 < found["lit"] < 0.25 and found["rms_px"] < 0.02
    assert any("% of the picture by its chief rays" in note for note in found["notes"])
    done = petzval_cli("lens", "calibrate", "laikin-fisheye-170", "--model", "fisheye", "--film", "36x24")
    assert done.returncode == 0 and "the model is fitted there" in done.stderr


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("cooke-triplet-50mm", "--model", "mercator"), ("there is no camera model 'mercator'; use one of opencv, fisheye",)),
        (("cooke-triplet-50mm", "--model", "st-map"), ("the model st-map is not fitted; use one of opencv",)),
        (("cooke-triplet-50mm", "--coefficients", "k1,q2"), ("the model opencv has no coefficient 'q2'; it has k1, k2, p1",)),
        (("fisheye-nikkor-16-f2.8",), ("the model opencv cannot see all of the lit picture", "90.2 degrees", "fisheye")),
        (("questar-3.5",), ("has mirrors",)),
        (("cooke-triplet-50mm", "--to", "colmap"), ("--to is the format of --output",)),
        (("cooke-triplet-50mm", "-o", "a.png"), ("its ending says no format",)),
        (("cooke-triplet-50mm", "--map", "a.png"), ("its ending is not .exr: change --map",)),
        (("cooke-triplet-50mm", "--model", "eucm", "-o", "{tmp}/a.yml"), ("OpenCV's YAML has no model like eucm",)),
        (("cooke-triplet-50mm", "--film", "3x2", "--shift", "900,0"), ("lights nothing of this film",)),
        (("cooke-triplet-50mm", "--size", "20000x20000", "--map", "{tmp}/a.exr"), ("a map of 20000 x 20000 pixels: give less",)),
    ],
)  # fmt: skip
def test_what_cannot_be_is_one_line(petzval_cli, tmp_path, arguments, words):
    arguments = [one.replace("{tmp}", str(tmp_path)) for one in arguments]
    status = 2 if "--to" in arguments else 1
    assert_complains(petzval_cli("lens", "calibrate", *arguments), *words, status=status)
    assert not (tmp_path / "a.yml").exists()


def test_what_is_out_of_the_ordinary_is_noted(petzval_cli, tmp_path):
    """Another shape than the film's, a model that folds, and one that leaves pixels."""
    cropped = petzval_cli("lens", "calibrate", "nikkor-24-f1.8", "--size", "1920x1080")
    assert "the picture takes 36 x 20.25 mm of the film's 36 x 24 mm" in cropped.stderr and cropped.returncode == 0
    folded = petzval_cli("lens", "calibrate", "laikin-fisheye-170")
    assert folded.returncode == 0 and "folds at its edge" in folded.stderr, folded.stderr
    pinhole = petzval_cli("lens", "calibrate", "nikkor-24-f1.8", "--coefficients", "none")
    assert "give more --coefficients" in pinhole.stderr


def test_the_nearest_centre_leaves_less_elsewhere(calibrate):
    """The same for a far scene, to which the centre is nothing; for a near one the point nearest to all rays is better."""
    pupil, nearest = (calibrate("nikkor-24-f1.8", "--centre", centre) for centre in ("pupil", "nearest"))
    assert pupil["parameters"]["fx"] == pytest.approx(nearest["parameters"]["fx"], rel=1e-12)
    assert pupil["centre_z_mm"] == pupil["pupil_z_mm"] < nearest["centre_z_mm"]
    at_1_m = [
        next(one for one in found["elsewhere"] if one["distance_mm"] == 1000.0)["rms_px"] for found in (pupil, nearest)
    ]
    assert at_1_m[1] < 0.6 * at_1_m[0], at_1_m
