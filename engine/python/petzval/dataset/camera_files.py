# SPDX-License-Identifier: GPL-3.0-or-later
"""Camera parameters as COLMAP, NeRF and KITTI have them. Lengths are metres; poses are camera to world, Blender's axes, Blender units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .. import atomic_files
from .cameras import Intrinsics
from .poses import FLIP, Matrix, to_quaternion

#: A coloured point of the world: x, y, z in metres, r, g, b from 0 to 255, and its views: number of the picture, x and y in pixels.
Point = tuple[float, float, float, int, int, int, int, float, float]


@dataclass(frozen=True)
class View:
    """One picture's camera."""

    #: The picture's file, relative to the data set's folder.
    picture: str
    camera: str
    intrinsics: Intrinsics
    pose: Matrix
    metres_per_unit: float
    #: Seconds from the first frame of the scene.
    time_s: float

    @property
    def pose_m(self) -> Matrix:
        """The pose with its place in metres."""
        scaled = self.pose.copy()
        scaled[:3, 3] *= self.metres_per_unit
        return scaled


def write_colmap(folder: Path, views: Sequence[View], points: Sequence[Point]) -> None:
    """cameras.txt, images.txt and points3D.txt of COLMAP's text model (colmap.github.io/format.html). Names of pictures count from the
    folder pictures."""
    cameras: dict[Intrinsics, int] = {}
    for view in views:
        cameras.setdefault(view.intrinsics, len(cameras) + 1)
    lines = ["# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]"]
    for one, number in cameras.items():
        model, parameters = one.model, one.parameters
        if model == "OPENCV":
            # Five coefficients stand in COLMAP's model of eight: k1, k2, p1, p2, k3, k4, k5, k6.
            model, parameters = "FULL_OPENCV", (*parameters, 0.0, 0.0, 0.0)
        lines.append(f"{number} {model} {one.width} {one.height} {_words(parameters)}")
    atomic_files.write_text(folder / "cameras.txt", "\n".join(lines) + "\n")
    seen: dict[int, list[tuple[float, float, int]]] = {}
    for number, point in enumerate(points, 1):
        seen.setdefault(point[6], []).append((point[7], point[8], number))
    lines = ["# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME", "# POINTS2D[] as (X, Y, POINT3D_ID)"]
    for number, view in enumerate(views, 1):
        to_camera = np.linalg.inv(view.pose_m @ FLIP)
        words = _words((*to_quaternion(to_camera[:3, :3]), *to_camera[:3, 3]))
        lines.append(f"{number} {words} {cameras[view.intrinsics]} {view.picture.removeprefix('pictures/')}")
        lines.append(" ".join(f"{x:.4f} {y:.4f} {which}" for x, y, which in seen.get(number, [])))
    atomic_files.write_text(folder / "images.txt", "\n".join(lines) + "\n")
    lines = ["# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)"]
    counts: dict[int, int] = {}
    for number, (x, y, z, r, g, b, which, _, _) in enumerate(points, 1):
        lines.append(f"{number} {_words((x, y, z))} {r} {g} {b} 0 {which} {counts.get(which, 0)}")
        counts[which] = counts.get(which, 0) + 1
    atomic_files.write_text(folder / "points3D.txt", "\n".join(lines) + "\n")


def write_nerf(file: Path, views: Sequence[View]) -> None:
    """transforms.json of instant-ngp and nerfstudio: camera to world, OpenGL's camera axes, which are Blender's (docs.nerf.studio, "Data
    conventions"). Shared parameters stand at the top, as instant-ngp reads them; those that differ, by picture, too."""
    shared = views[0].intrinsics if len({one.intrinsics for one in views}) == 1 else None
    frames: list[dict[str, Any]] = []
    for view in views:
        own = {} if shared is not None else _nerf_intrinsics(view.intrinsics)
        frames.append(
            {"file_path": view.picture, "transform_matrix": view.pose_m.tolist(), "time": view.time_s, "camera": view.camera, **own}
        )  # fmt: skip
    top = {} if shared is None else _nerf_intrinsics(shared)
    atomic_files.write_json(file, {**top, "frames": frames}, indent=1)


def _nerf_intrinsics(one: Intrinsics) -> dict[str, Any]:
    named = one.named
    return {
        "camera_model": one.model, "w": one.width, "h": one.height, "fl_x": named.pop("fx"), "fl_y": named.pop("fy"), **named,
        "camera_angle_x": 2.0 * float(np.arctan(one.width / 2.0 / one.parameters[0])), "fit_largest_px": one.largest_px,
    }  # fmt: skip


def write_kitti(folder: Path, views: Sequence[View]) -> None:
    """calib.txt, and poses and times by camera, as KITTI's odometry data has them (devkit_odometry, readme.txt): a projection matrix
    P_i from the first camera's space, pixel coordinates from the middle of the first pixel; camera poses in the space of the first one."""
    names = list(dict.fromkeys(view.camera for view in views))
    first = {name: next(view for view in views if view.camera == name) for name in names}
    base = first[names[0]].pose_m @ FLIP
    lines = []
    for number, name in enumerate(names):
        own = first[name]
        fx, fy, cx, cy = own.intrinsics.parameters[:4]
        k = np.array([[fx, 0.0, cx - 0.5], [0.0, fy, cy - 0.5], [0.0, 0.0, 1.0]])
        from_first = np.linalg.inv(own.pose_m @ FLIP) @ base
        lines.append(f"P{number}: {_words((k @ from_first[:3]).ravel())}")
        if own.intrinsics.model != "PINHOLE":
            # As KITTI's raw data has the distortion of a picture that is not rectified.
            lines.append(f"D{number}: {_words(own.intrinsics.parameters[4:])}")
    atomic_files.write_text(folder / "calib.txt", "\n".join(lines) + "\n")
    for name in names:
        several = [view for view in views if view.camera == name]
        matrices = [np.linalg.inv(base) @ view.pose_m @ FLIP for view in several]
        end = "" if len(names) == 1 else f"_{name}"
        atomic_files.write_text(folder / f"poses{end}.txt", "".join(_words(m[:3].ravel()) + "\n" for m in matrices))
        atomic_files.write_text(folder / f"times{end}.txt", "".join(f"{view.time_s:.6e}\n" for view in several))


def _words(numbers: Any) -> str:
    """Numbers with all their digits."""
    return " ".join(repr(float(one)) for one in numbers)
