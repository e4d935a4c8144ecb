# SPDX-License-Identifier: GPL-3.0-or-later
"""Cameras fitted to lenses, beside pictures taken through the lenses: chessboards whose corners lie where the model says and by which OpenCV's own
calibration finds the same camera; positions of a wall on the rays of the map; and the calibrated camera's picture over the lens's."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

WIDTH, HEIGHT, FOCUS_M = 480, 320, 1.1
LENS, FILM = "angenieux-retrofocus-r1", (36.0, 24.0)
#: Where boards stand: the picture place of their middle, the distance, and turns about x, y and the axis, degrees.
BOARDS = (
    (0.5, 0.5, 1.1, 0, 0, 0),
    (0.33, 0.37, 1.15, 32, -18, 5),
    (0.67, 0.37, 1.15, -28, 25, -10),
    (0.33, 0.65, 1.15, 22, 30, 12),
    (0.67, 0.65, 1.15, -33, -22, -4),
    (0.5, 0.36, 1.2, 38, 5, 90),
    (0.42, 0.55, 1.05, -10, -40, 3),
    (0.58, 0.5, 1.1, 15, 38, -7),
)
OPTIONS = ("--film", "36x24", "--size", f"{WIDTH}x{HEIGHT}", "--focus-distance", str(1000.0 * FOCUS_M))


@pytest.fixture(scope="module")
def fitted(petzval_cli, tmp_path_factory):
    """The answer for the lens, its calibration's file and its ray map."""
    folder = tmp_path_factory.mktemp("fitted")
    files = (folder / "camera.yml", folder / "rays.exr")
    done = petzval_cli("lens", "calibrate", LENS, *OPTIONS, "-o", files[0], "--map", files[1], "--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout), *files


def take_lens(scene, samples: int):
    """The scene's camera takes the lens, stopped far down, as `fitted` has it."""
    from support.places import ROOT

    own = scene.camera.data.petzval
    own.model = "LENS"
    own.lens_file = str(ROOT / "lenses" / f"{LENS}.lens")
    own.film_mode, own.film_width, own.film_height = "SIZE", *FILM
    own.spectrum, own.wide_open, own.f_number = "SINGLE", False, 64.0
    own.focus_mode = "CAMERA"
    scene.camera.data.dof.focus_distance = FOCUS_M
    scene.petzval.filter_width = 0.0
    scene.petzval.samples = samples
    for effect in ("ghosts", "glare", "diffraction", "transmission", "vignetting"):
        setattr(scene.petzval.effects, effect, "OFF")


@pytest.fixture
def studio(blender, parts):
    """A scene of one board before the lens, which looks along +y from the origin."""
    from support import chessboard

    def make(samples: int):
        scene = parts.set_up(WIDTH, HEIGHT, samples)
        scene.world = parts.grey_world(0.0)
        take_lens(scene, samples)
        return scene, chessboard.add(blender, parts)

    return make


def seen(points: np.ndarray, p: dict) -> np.ndarray:
    """OpenCV's formulas: pixels from the middle of the first, of points to the right, down and ahead."""
    x, y = points[:, 0] / points[:, 2], points[:, 1] / points[:, 2]
    r2 = x * x + y * y
    stretch = 1.0 + p["k1"] * r2 + p["k2"] * r2**2 + p["k3"] * r2**3
    return np.stack([p["fx"] * x * stretch + p["cx"] - 0.5, p["fy"] * y * stretch + p["cy"] - 0.5], 1)


def stand(board, p: dict, place) -> np.ndarray:
    """Puts the board there; its corners to the right, down and ahead of the camera."""
    from mathutils import Euler, Matrix, Vector

    from support import chessboard

    u, v, distance, *turns = place
    at = np.array([(u * WIDTH - p["cx"]) / p["fx"], (v * HEIGHT - p["cy"]) / p["fy"], 1.0]) * distance
    in_camera = (
        Matrix.Translation(Vector((at[0], -at[1], -at[2])))
        @ Euler([math.radians(t) for t in turns]).to_matrix().to_4x4()
    )
    board.matrix_world = Euler((math.pi / 2, 0.0, 0.0)).to_matrix().to_4x4() @ in_camera
    return np.array([in_camera @ Vector(corner) for corner in chessboard.corners()]) * [1.0, -1.0, -1.0]


@pytest.mark.once
def test_opencv_finds_the_same_camera_in_pictures_of_the_lens(studio, parts, tmp_path, fitted):
    from support import chessboard

    found, *_ = fitted
    p, half = found["parameters"], 7
    scene, board = studio(64)
    corners, model, on_board = [], [], []
    for place in BOARDS:
        truth = seen(stand(board, p, place), p)
        inside = (truth > half + 4).all(1) & (truth < np.array([WIDTH, HEIGHT]) - half - 5).all(1)
        grid = truth.reshape(*chessboard.COUNT[::-1], 2)
        ways = [np.gradient(grid, axis=axis).reshape(-1, 2) for axis in (1, 0)]
        angles = np.stack([np.arctan2(way[:, 1], way[:, 0]) for way in ways], 1)
        grey = parts.render(tmp_path)[::-1, :, 1].astype(float)
        corners.append(chessboard.refined(grey, truth[inside] + 0.2, angles[inside], half))
        model.append(truth[inside])
        on_board.append(chessboard.corners()[inside])
    assert sum(map(len, model)) > 0.8 * len(BOARDS) * len(chessboard.corners())
    # Known boards before the model: its residual, the finder's 0.02 pixel (test_calibrated_camera.py), and of boards that stand before and behind
    # the focus the parallax of a pupil that wanders by 0.3 mm: 470 pixels by 0.3 mm by (1/0.95 - 1/1.1) per m is 0.02 pixel.
    off = np.concatenate(corners) - np.concatenate(model)
    print("model:", np.sqrt((off**2).sum(1).mean()), off.mean(0), np.abs(off).max())
    assert np.sqrt((off**2).sum(1).mean()) < 0.04 and np.abs(off.mean(0)).max() < 0.01, off.mean(0)
    cv2 = pytest.importorskip("cv2", reason="OpenCV is not installed")
    boards = [(one * [1, -1, 1]).reshape(-1, 1, 3).astype(np.float32) for one in on_board]
    places = [one.reshape(-1, 1, 2).astype(np.float32) for one in corners]
    rms, k, d, *_ = cv2.calibrateCamera(boards, places, (WIDTH, HEIGHT), None, None)
    # OpenCV's calibration knows no axis: the same field, but for a turn of the whole camera.
    x, y = np.meshgrid(np.linspace(20, WIDTH - 20, 23), np.linspace(20, HEIGHT - 20, 15))
    pixels = np.stack([x.ravel(), y.ravel()], 1)
    mine = np.array([[p["fx"], 0, p["cx"] - 0.5], [0, p["fy"], p["cy"] - 0.5], [0, 0, 1]])
    own = np.array([p["k1"], p["k2"], 0.0, 0.0, p["k3"]])
    fields = [cv2.undistortPoints(pixels.reshape(-1, 1, 2), *camera).reshape(-1, 2) for camera in ((mine, own), (k, d))]
    a, b = (
        np.concatenate([field, np.ones((len(field), 1))], 1) / np.sqrt(1.0 + (field**2).sum(1))[:, None]
        for field in fields
    )
    u, _, vt = np.linalg.svd(b.T @ a)
    turn = u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt
    apart = np.linalg.norm(b @ turn - a, axis=1) * p["fx"]
    print("OpenCV:", rms, k[0, 0] - p["fx"], k[1, 1] - p["fy"], np.sqrt((apart**2).mean()), apart.max())
    assert rms < 0.04 and k[0, 0] == pytest.approx(p["fx"], rel=1e-3)
    assert np.sqrt((apart**2).mean()) < 0.03 and apart.max() < 0.1, apart.max()


def test_positions_lie_on_the_rays_of_the_map(studio, parts, tmp_path, fitted):
    """A tilted wall's positions beside where the map's rays meet it: those of a pixel are anywhere in it, and their mean is in its middle."""
    from support import zipped_exr
    from support.multilayer import photograph

    found, _, rays = fitted
    scene, board = studio(16)
    corners = stand(board, found["parameters"], (0.5, 0.5, 1.1, 25, -15, 0))
    board.scale = (1.0, 1.0, 1.0)
    scene.view_layers[0].use_pass_position = True
    channels, _ = photograph(parts, scene, tmp_path / "passes.exr", samples=16)
    position = np.stack([channels[f"position.{axis}"] for axis in "xyz"], -1)[::-1]
    # To the right, down and ahead, mm.
    position = np.stack([position[..., 0], -position[..., 2], position[..., 1]], -1) * 1000.0
    on_wall = np.linalg.norm(position, axis=-1) > 100.0
    assert on_wall.sum() > 20000
    map_channels, _ = zipped_exr.read(rays)
    origin, direction = (
        np.stack([map_channels[f"{what}.{axis}"] for axis in "XYZ"], -1) for what in ("origin", "direction")
    )
    normal = np.cross(corners[1] - corners[0], corners[-1] - corners[0])
    normal /= np.linalg.norm(normal)
    way = ((corners[0] * 1000.0 - origin) @ normal) / (direction @ normal)
    meets = origin + direction * way[..., None]
    # By how many pixels: along the picture's axes, by the neighbours' distances.
    steps = [np.gradient(meets, axis=axis) for axis in (1, 0)]
    off = (position - meets)[on_wall]
    solved = []
    for right, down, one in zip(steps[0][on_wall][::7], steps[1][on_wall][::7], off[::7], strict=True):
        solved.append(np.linalg.lstsq(np.stack([right, down], 1), one, rcond=None)[0])
    solved = np.array(solved)
    # The blur of F/64 is a twentieth of a pixel here.
    assert np.abs(solved).max() < 0.65, np.abs(solved).max()
    assert np.abs(solved.mean(0)).max() < 0.02, solved.mean(0)


def test_the_fitted_camera_takes_the_lens_s_picture(studio, parts, tmp_path, fitted):
    """The board by the lens and by a calibrated camera in the same place, from the fitted file."""
    found, calibration, _ = fitted
    scene, board = studio(64)
    stand(board, found["parameters"], (0.33, 0.37, 1.1, 10, -10, 5))
    by_lens = parts.render(tmp_path)[..., 1].astype(float)
    own = scene.camera.data.petzval
    own.model, own.calibration_file = "CALIBRATED", str(calibration)
    by_model = parts.render(tmp_path)[..., 1].astype(float)
    slopes = np.gradient(by_lens)
    # How far one picture is to be moved to be the other, pixels: by least squares over their slopes.
    columns = np.stack([slopes[1].ravel(), slopes[0].ravel()], 1)
    shift, *_ = np.linalg.lstsq(columns, (by_model - by_lens).ravel(), rcond=None)
    assert np.abs(shift).max() < 0.01, shift
    # Edges are of 64 samples each: what differs is in the pixels that an edge crosses.
    assert np.abs(by_model - by_lens).mean() < 0.01 and np.abs(by_lens).mean() > 0.05
