# SPDX-License-Identifier: GPL-3.0-or-later
"""Chessboards photographed by a calibration: their corners lie where OpenCV's formulas say, and OpenCV's own calibration of these pictures finds
the camera again. Depth, position, motion and mattes are those of the same rays."""

from __future__ import annotations

import math

import numpy as np
import pytest

WIDTH, HEIGHT = 480, 320
#: As OpenCV counts pixels: from the middle of the first. Focal lengths, principal point, then the distortion.
PINHOLE = (420.0, 423.0, 243.7, 156.2, -0.3, 0.15, 0.006, -0.005)
FISHEYE = (150.0, 151.0, 241.3, 158.8, 0.05, -0.02, 0.012, -0.003)
#: Where boards stand: the picture place of their middle, as parts of its sides, the distance, and turns about x, y and the axis, degrees.
BOARDS = (
    (0.5, 0.5, 1.05, 0, 0, 0),
    (0.36, 0.4, 1.2, 32, -18, 5),
    (0.64, 0.4, 1.2, -28, 25, -10),
    (0.36, 0.62, 1.2, 22, 30, 12),
    (0.64, 0.62, 1.2, -33, -22, -4),
    (0.5, 0.36, 1.25, 38, 5, 90),
    (0.42, 0.55, 1.1, -10, -40, 3),
    (0.58, 0.5, 1.15, 15, 38, -7),
)


def file_of(folder, numbers, *, is_fisheye: bool):
    """A calibration as ROS writes it."""
    fx, fy, cx, cy, *more = numbers
    model, more = ("equidistant", more) if is_fisheye else ("plumb_bob", [*more, 0.0])
    path = folder / "camera.yaml"
    path.write_text(
        f"image_width: {WIDTH}\nimage_height: {HEIGHT}\ncamera_name: test\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
        f"  data: [{fx}, 0, {cx}, 0, {fy}, {cy}, 0, 0, 1]\ndistortion_model: {model}\n"
        f"distortion_coefficients:\n  rows: 1\n  cols: {len(more)}\n  data: {list(more)}\n"
    )
    return path


def seen(points: np.ndarray, numbers, *, is_fisheye: bool) -> np.ndarray:
    """OpenCV's formulas: pixels from the middle of the first, of points to the right, down and ahead."""
    fx, fy, cx, cy, k1, k2, a, b = numbers
    x, y = points[:, 0] / points[:, 2], points[:, 1] / points[:, 2]
    r2 = x * x + y * y
    if is_fisheye:
        r = np.sqrt(r2)
        theta = np.arctan(r)
        t2 = theta * theta
        stretch = theta * (1 + k1 * t2 + k2 * t2**2 + a * t2**3 + b * t2**4) / np.maximum(r, 1e-12)
        x, y = x * stretch, y * stretch
    else:
        radial = 1 + k1 * r2 + k2 * r2 * r2
        x, y = x * radial + 2 * a * x * y + b * (r2 + 2 * x * x), y * radial + a * (r2 + 2 * y * y) + 2 * b * x * y
    return np.stack([fx * x + cx, fy * y + cy], 1)


def ahead(u: float, v: float, numbers, *, is_fisheye: bool) -> np.ndarray:
    """A direction about at a place of the picture: boards may stand anywhere."""
    x, y = (u * WIDTH - numbers[2]) / numbers[0], (v * HEIGHT - numbers[3]) / numbers[1]
    r = math.hypot(x, y)
    stretch = math.tan(r) / r if is_fisheye and r > 0.0 else 1.0
    return np.array([x * stretch, y * stretch, 1.0])


@pytest.fixture
def studio(blender, parts, tmp_path):
    """A scene of one board and a calibrated camera at the origin, that looks along +y; what it is by."""
    from support import chessboard

    def make(numbers, *, is_fisheye: bool, samples: int):
        scene = parts.set_up(WIDTH, HEIGHT, samples, model="CALIBRATED")
        scene.petzval.filter_width = 0.0
        scene.world = parts.grey_world(0.0)
        scene.camera.data.petzval.calibration_file = str(file_of(tmp_path, numbers, is_fisheye=is_fisheye))
        return scene, chessboard.add(blender, parts)

    return make


def stand(board, numbers, place, scale: float, *, is_fisheye: bool) -> np.ndarray:
    """Puts the board there; its corners to the right, down and ahead of the camera."""
    from mathutils import Euler, Matrix, Vector

    from support import chessboard

    u, v, distance, *turns = place
    at = ahead(u, v, numbers, is_fisheye=is_fisheye)
    if is_fisheye:
        at = at / np.linalg.norm(at)
    at = at * distance * scale
    # The board's x, y and z are the camera's right, up and back.
    in_camera = (
        Matrix.Translation(Vector((at[0], -at[1], -at[2])))
        @ Euler([math.radians(t) for t in turns]).to_matrix().to_4x4()
    )
    to_world = Euler((math.pi / 2, 0.0, 0.0)).to_matrix().to_4x4()
    board.matrix_world = to_world @ in_camera
    points = np.array([in_camera @ Vector(corner) for corner in chessboard.corners()])
    return points * [1.0, -1.0, -1.0]


def corners_of_pictures(studio, parts, tmp_path, numbers, *, is_fisheye: bool, scale: float, half: int, samples: int):
    """Corners found in pictures of all boards, those that formulas give, and those on the board, each by picture."""
    from support import chessboard

    scene, board = studio(numbers, is_fisheye=is_fisheye, samples=samples)
    found, truths, on_board = [], [], []
    for place in BOARDS:
        points = stand(board, numbers, place, scale, is_fisheye=is_fisheye)
        truth = seen(points, numbers, is_fisheye=is_fisheye)
        inside = (truth > half + 4).all(1) & (truth < np.array([WIDTH, HEIGHT]) - half - 5).all(1)
        # The edges, along the board's rows and columns.
        grid = truth.reshape(*chessboard.COUNT[::-1], 2)
        ways = [np.gradient(grid, axis=axis).reshape(-1, 2) for axis in (1, 0)]
        angles = np.stack([np.arctan2(way[:, 1], way[:, 0]) for way in ways], 1)
        grey = parts.render(tmp_path)[::-1, :, 1].astype(float)
        found.append(chessboard.refined(grey, truth[inside] + 0.3, angles[inside], half))
        truths.append(truth[inside])
        on_board.append(chessboard.corners()[inside])
    assert scene.petzval.samples == samples and sum(map(len, truths)) > 0.8 * len(BOARDS) * len(chessboard.corners())
    return found, truths, on_board


#: Whose, boards of which size, the pixels about a corner that are looked at, and samples: fewer pixels need more.
CASES = {"pinhole": (PINHOLE, False, 1.0, 9, 32), "fisheye": (FISHEYE, True, 0.42, 5, 64)}


@pytest.mark.once
@pytest.mark.parametrize("case", CASES)
def test_opencv_finds_the_camera_again(studio, parts, tmp_path, case):
    numbers, is_fisheye, scale, half, samples = CASES[case]
    found, truths, on_board = corners_of_pictures(
        studio, parts, tmp_path, numbers, is_fisheye=is_fisheye, scale=scale, half=half, samples=samples
    )
    off = np.concatenate(found) - np.concatenate(truths)
    # Of a corner some 20 to 30 pixels of edges are seen, each by 32 or 64 samples: to a hundredth of a pixel.
    assert np.sqrt((off**2).sum(1).mean()) < 0.02, np.sqrt((off**2).sum(1).mean())
    assert np.abs(off.mean(0)).max() < 0.002, off.mean(0)
    cv2 = pytest.importorskip("cv2", reason="OpenCV is not installed")
    shape, kind = ((1, -1), np.float64) if is_fisheye else ((-1, 1), np.float32)
    boards = [(one * [1, -1, 1]).reshape(*shape, 3).astype(kind) for one in on_board]
    places = [one.reshape(*shape, 2).astype(kind) for one in found]
    if is_fisheye:
        start = np.array([[160.0, 0, 240], [0, 160.0, 160], [0, 0, 1]])
        flags = cv2.CALIB_FIX_SKEW | cv2.CALIB_USE_INTRINSIC_GUESS | cv2.CALIB_RECOMPUTE_EXTRINSIC
        rms, k, d, *_ = cv2.fisheye.calibrate(boards, places, (WIDTH, HEIGHT), start, np.zeros((4, 1)), flags=flags)
    else:
        rms, k, d, *_ = cv2.calibrateCamera(boards, places, (WIDTH, HEIGHT), None, None, flags=cv2.CALIB_FIX_K3)
    again = np.array([k[0, 0], k[1, 1], k[0, 2], k[1, 2], *d.ravel()[:4]])
    print("OpenCV:", rms, again - numbers)
    assert rms < 0.02, rms
    assert np.abs(again[:4] / numbers[:4] - 1).max() < 1e-3, again
    assert np.abs(again[4:] - numbers[4:]).max() < 1e-3, again
    # Coefficients of several powers of a radius below 1 make up for each other: what counts is what they do near the picture's corner.
    corner = np.array([[0.45 * WIDTH / numbers[0], 0.45 * HEIGHT / numbers[1], 1.0]])
    apart = seen(corner, again, is_fisheye=is_fisheye) - seen(corner, numbers, is_fisheye=is_fisheye)
    assert np.abs(apart).max() < 0.05, apart


def test_passes_are_of_the_same_rays(studio, parts, blender, tmp_path):
    """Depth and position of a wall by the formulas, its matte where it stands, and the way of a moving one over the picture."""
    from support.multilayer import mattes, photograph, vectors

    scene, board = studio(PINHOLE, is_fisheye=False, samples=16)
    scene.render.resolution_x, scene.render.resolution_y = WIDTH // 4, HEIGHT // 4
    board.matrix_world = board.matrix_world.Identity(4)
    board.rotation_euler, board.location = (math.pi / 2, 0.0, 0.0), (0.05, 1.3, 0.03)
    for frame, x in ((0, 0.05), (1, 0.07), (2, 0.1)):
        board.location.x = x
        board.keyframe_insert("location", frame=frame)
    scene.frame_set(1)
    layer = scene.view_layers[0]
    layer.use_pass_z = layer.use_pass_position = layer.use_pass_vector = layer.use_pass_cryptomatte_object = True
    channels, _ = photograph(parts, scene, tmp_path / "passes.exr", samples=16)
    depth = channels["depth.z" if "depth.z" in channels else "depth.v"]
    on_wall = depth < 100.0
    assert on_wall.sum() > 2000 and np.abs(depth[on_wall] - 1.3).max() < 1e-5
    position = np.stack([channels[f"position.{axis}"] for axis in "xyz"], -1)[on_wall]
    # A position is that of a ray in the pixel: half a pixel of four of the calibration's, at most, from its middle.
    places = seen(np.stack([position[:, 0], -position[:, 2], position[:, 1]], 1), PINHOLE, is_fisheye=False)
    row, column = np.nonzero(on_wall)  # from below
    at = (places + 0.5) / 4.0 - 0.5 - np.stack([column, HEIGHT // 4 - 1 - row], 1)
    assert np.abs(at).max() < 0.51 and np.abs(at.mean(0)).max() < 0.05
    # Where the wall's point was a frame before, by the same formulas.
    before = seen(np.stack([position[:, 0] - 0.02, -position[:, 2], position[:, 1]], 1), PINHOLE, is_fisheye=False)
    moved = (before - places) / 4.0
    found = vectors(channels)[on_wall]
    # Pixels at the wall's edge are in part of the background; a vector is that of a ray, as the position is.
    error = np.abs(found[:, :2] - moved * [1, -1])
    assert np.quantile(error, 0.9) < 0.01, np.quantile(error, [0.5, 0.9, 1.0])
    covered = [coverage for key, coverage in mattes(channels, "Object").items() if coverage[on_wall].mean() > 0.9]
    assert len(covered) == 1 and covered[0][~on_wall].mean() < 0.02


def test_blur_is_of_what_is_out_of_focus(studio, parts, tmp_path):
    """With depth of field the board is sharp at the focus distance, and has the blur of a thin lens elsewhere."""
    scene, board = studio(PINHOLE, is_fisheye=False, samples=16)
    scene.render.resolution_x, scene.render.resolution_y = WIDTH // 2, HEIGHT // 2
    stand(board, PINHOLE, BOARDS[0], 1.0, is_fisheye=False)
    dof = scene.camera.data.dof
    steepest = {}
    sharp = parts.render(tmp_path)[..., 1]
    dof.use_dof, dof.aperture_fstop = True, 1.4
    for distance in (1.05, 0.3):
        dof.focus_distance = distance
        picture = parts.render(tmp_path)[..., 1]
        steepest[distance] = np.abs(np.diff(picture[60:100, 80:160], axis=1)).max()
    assert steepest[1.05] > 0.8 * np.abs(np.diff(sharp[60:100, 80:160], axis=1)).max()
    assert steepest[0.3] < 0.5 * steepest[1.05]


def test_a_file_that_is_missing_is_told(studio, blender, parts):
    scene, _ = studio(PINHOLE, is_fisheye=False, samples=1)
    own = scene.camera.data.petzval
    for chosen, told in (
        ("", "it has no calibration: choose its file"),
        ("/no/such.yml", "/no/such.yml:1:1: cannot be read"),
    ):
        own.calibration_file = chosen
        with pytest.raises(RuntimeError, match="(?s)" + told):
            blender.ops.render.render()
