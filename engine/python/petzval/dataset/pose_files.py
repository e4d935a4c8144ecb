# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of camera poses: COLMAP images.txt, NeRF transforms.json, KITTI poses, CSV. Their lengths are metres.

COLMAP: world to camera, quaternion w x y z, camera axes x right, y down, z forward (colmap.github.io/format.html). NeRF: camera to world,
camera axes as Blender's. KITTI odometry: rows of a matrix (3, 4) from camera to the first camera, axes as COLMAP's (devkit_odometry, readme.txt);
the first camera's axes are laid so that it looks along the world's y, z up.
"""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np

from ..errors import CommandError
from .poses import FLIP, Matrix, Pose, euler_deg, of_quaternion, orthonormal, placed

FORMATS = ("colmap", "nerf", "kitti", "csv")

#: KITTI's axes (x right, y down, z forward) in a world whose z is up.
_UPRIGHT = np.array([[1.0, 0, 0, 0], [0, 0, 1.0, 0], [0, -1.0, 0, 0], [0, 0, 0, 1.0]])


def format_of(file: Path) -> str | None:
    """The format of a file by its name; None: the name has none."""
    if file.name == "images.txt":
        return "colmap"
    return {".json": "nerf", ".csv": "csv", ".txt": "kitti"}.get(file.suffix.lower())


def read(file: Path, kind: str, metres_per_unit: float = 1.0) -> list[Pose]:
    """The poses of a file, in its order; COLMAP's by the names of their pictures. Raises `CommandError` with the line."""
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise CommandError(
            f"cannot read {file}: {getattr(error, 'strerror', None) or error}: name a file of poses"
        ) from None
    found = {"colmap": _colmap, "nerf": _nerf, "kitti": _kitti, "csv": _csv}[kind](file, text)
    if not found:
        raise CommandError(f"{file}: no pose is in it: is it a file of the format {kind}")
    scaled = []
    for matrix, frame in found:
        matrix = matrix.copy()
        matrix[:3, 3] /= metres_per_unit
        scaled.append(Pose(matrix=matrix, frame=frame))
    return scaled


_Found = list[tuple[Matrix, int | None]]


def _numbers(file: Path, line: int, words: list[str]) -> list[float]:
    try:
        values = [float(word) for word in words]
    except ValueError as error:
        raise CommandError(f"{file}:{line}: {error}") from None
    if not np.isfinite(values).all():
        raise CommandError(f"{file}:{line}: a number is not finite")
    return values


def _colmap(file: Path, text: str) -> _Found:
    named: list[tuple[str, Matrix]] = []
    lines = [(n, line) for n, line in enumerate(text.splitlines(), 1) if not line.startswith("#")]
    while lines and not lines[-1][1].strip():
        lines.pop()
    # Every other line holds points of the picture, and may be empty.
    for number, line in lines[::2]:
        words = line.split(maxsplit=9)
        if len(words) != 10:
            raise CommandError(f"{file}:{number}: must be IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME: {line[:60]}")
        q = _numbers(file, number, words[1:8])
        try:
            to_camera = placed(of_quaternion(tuple(q[:4])), np.array(q[4:]))
        except ValueError as error:
            raise CommandError(f"{file}:{number}: {error}") from None
        named.append((words[9], np.linalg.inv(to_camera) @ FLIP))
    return [(matrix, None) for _, matrix in sorted(named, key=lambda one: one[0])]


def _nerf(file: Path, text: str) -> _Found:
    try:
        frames = json.loads(text)["frames"]
        found: _Found = []
        for number, frame in enumerate(frames):
            matrix = np.array(frame["transform_matrix"], float)
            if matrix.shape != (4, 4) or not np.isfinite(matrix).all():
                raise CommandError(f"{file}: frames[{number}]: transform_matrix must be 4 x 4 finite numbers")
            found.append((orthonormal(matrix), None))
        return found
    except json.JSONDecodeError as error:
        raise CommandError(f"{file}:{error.lineno}:{error.colno}: no JSON: {error.msg}") from None
    except (KeyError, TypeError, ValueError) as error:
        raise CommandError(f"{file}: frames with a transform_matrix each are missing: {error}") from None


def _kitti(file: Path, text: str) -> _Found:
    found: _Found = []
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip():
            continue
        values = _numbers(file, number, line.split())
        if len(values) != 12:
            raise CommandError(f"{file}:{number}: must be 12 numbers, a matrix of 3 rows: there are {len(values)}")
        matrix = np.vstack([np.reshape(values, (3, 4)), [0.0, 0.0, 0.0, 1.0]])
        try:
            found.append((orthonormal(_UPRIGHT @ matrix @ FLIP), None))
        except ValueError as error:
            raise CommandError(f"{file}:{number}: {error}") from None
    return found


def _csv(file: Path, text: str) -> _Found:
    rows = csv.DictReader(text.splitlines())
    names = [name.strip() for name in rows.fieldnames or []]
    rows.fieldnames = names
    turns = next((t for t in (["qw", "qx", "qy", "qz"], ["rx", "ry", "rz"]) if set(t) <= set(names)), None)
    unknown = set(names) - {"x", "y", "z", "frame", *(turns or ())}
    if turns is None or unknown or not {"x", "y", "z"} <= set(names):
        raise CommandError(
            f"{file}:1: columns must be x, y, z, and qw, qx, qy, qz or rx, ry, rz (degrees), and frame or not"
            + (f": unknown: {', '.join(sorted(unknown))}" if unknown else "")
        )
    found: _Found = []
    for number, row in enumerate(rows, 2):
        if None in row or None in row.values():
            raise CommandError(f"{file}:{number}: must be {len(names)} values")
        place = _numbers(file, number, [row[name] for name in "xyz"])
        turn = tuple(_numbers(file, number, [row[name] for name in turns]))
        try:
            rotation = of_quaternion(turn) if len(turn) == 4 else euler_deg((turn[0], turn[1], turn[2]))
            frame = int(row["frame"]) if "frame" in names else None
        except ValueError as error:
            raise CommandError(f"{file}:{number}: {error}") from None
        found.append((placed(rotation, np.array(place)), frame))
    return found
