# SPDX-License-Identifier: GPL-3.0-or-later
"""Camera poses: matrices from camera space (x right, y up, the view along -z) to world space, (4, 4), in Blender units."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Matrix = npt.NDArray[np.float64]
Vector = tuple[float, float, float]

#: The turn from Blender's camera axes to those of computer vision (x right, y down, z forward), and back.
FLIP = np.diag([1.0, -1.0, -1.0, 1.0])


@dataclass(frozen=True)
class Pose:
    """The place and direction of a camera: by one of `rotation_deg`, `quaternion`, `target` and `matrix`."""

    location: Vector = (0.0, 0.0, 0.0)
    #: Euler angles about X, then Y, then Z, degrees, as Blender's XYZ.
    rotation_deg: Vector | None = None
    #: w, x, y, z.
    quaternion: tuple[float, ...] | None = None
    #: The place that is in the picture's middle, or the name of an object whose origin is.
    target: Vector | str | None = None
    up: Vector = (0.0, 0.0, 1.0)
    matrix: Matrix | None = None
    #: The scene's frame; None: the one that the whole data set has.
    frame: int | None = None

    def resolved(self, place_of: Callable[[str], Vector]) -> Matrix:
        """The matrix; `place_of` gives the origin of an object by its name. Raises `ValueError`."""
        if self.matrix is not None:
            return self.matrix
        if self.target is not None:
            at = place_of(self.target) if isinstance(self.target, str) else self.target
            return looking_at(self.location, at, self.up)
        turn = (
            euler_deg(self.rotation_deg or (0.0, 0.0, 0.0))
            if self.quaternion is None
            else of_quaternion(self.quaternion)
        )
        return placed(turn, self.location)


def placed(turn: Matrix, location: Vector | Matrix) -> Matrix:
    """A rotation (3, 3) and a place as one matrix."""
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = turn, location
    return made


def euler_deg(angles_deg: Vector) -> Matrix:
    """Blender's XYZ: about X first, then Y, then Z; (3, 3)."""
    (sx, sy, sz), (cx, cy, cz) = np.sin(np.radians(angles_deg)), np.cos(np.radians(angles_deg))
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    turned: Matrix = about_z @ about_y @ about_x
    return turned


def of_quaternion(quaternion: tuple[float, ...]) -> Matrix:
    """The rotation (3, 3) of w, x, y, z, which need not have length one. Raises `ValueError` of a zero one."""
    length = math.sqrt(sum(one * one for one in quaternion))
    if length < 1e-9:
        raise ValueError("a quaternion of zeros turns nothing")
    w, x, y, z = (one / length for one in quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def to_quaternion(turn: Matrix) -> tuple[float, float, float, float]:
    """w, x, y, z with w >= 0 of a rotation (3, 3): the largest of the four from its diagonal, the others by it, so that none is a
    difference of nearly equal numbers (Shepperd 1978)."""
    m = turn
    squares = np.array([1 + m[0, 0] + m[1, 1] + m[2, 2], 1 + m[0, 0] - m[1, 1] - m[2, 2],
                        1 - m[0, 0] + m[1, 1] - m[2, 2], 1 - m[0, 0] - m[1, 1] + m[2, 2]])  # fmt: skip
    products = np.array(
        [
            [squares[0], m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]],
            [m[2, 1] - m[1, 2], squares[1], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0]],
            [m[0, 2] - m[2, 0], m[0, 1] + m[1, 0], squares[2], m[1, 2] + m[2, 1]],
            [m[1, 0] - m[0, 1], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], squares[3]],
        ]
    )
    row = products[int(np.argmax(squares))]
    row = row / np.linalg.norm(row)
    w, x, y, z = (float(one) for one in (row if row[0] >= 0.0 else -row))
    return w, x, y, z


def looking_at(location: Vector | Matrix, target: Vector | Matrix, up: Vector = (0.0, 0.0, 1.0)) -> Matrix:
    """The pose of a camera with the target in the middle of its picture. Raises `ValueError` where that says no direction. A view along
    `up` has the world's y up in the picture, or its z."""
    back = np.asarray(location, float) - np.asarray(target, float)
    length = np.linalg.norm(back)
    if length < 1e-9:
        raise ValueError("the camera stands in its own target")
    back /= length
    right = np.cross(np.asarray(up, float), back)
    for other in ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0)):
        if np.linalg.norm(right) < 1e-6:
            right = np.cross(other, back)
    right /= np.linalg.norm(right)
    return placed(np.stack([right, np.cross(back, right), back], axis=1), np.asarray(location, float))


def orthonormal(matrix: Matrix) -> Matrix:
    """A pose without the scale that an object may have: the next rotation, by singular values. Raises `ValueError` of a matrix that mirrors
    or flattens."""
    u, sizes, v = np.linalg.svd(matrix[:3, :3])
    turn = u @ v
    if sizes[-1] < 1e-9 or np.linalg.det(turn) < 0.0:
        raise ValueError("the matrix mirrors or flattens space")
    return placed(turn, matrix[:3, 3])


def orbit(centre: Vector, radius: float, elevation_deg: float, count: int, start_deg: float) -> list[Matrix]:
    """Poses evenly on a circle about the vertical through `centre`, counter-clockwise from above, each with the centre in its middle."""
    found = []
    for i in range(count):
        turn, up = math.radians(start_deg + 360.0 * i / count), math.radians(elevation_deg)
        way = np.array([math.cos(up) * math.cos(turn), math.cos(up) * math.sin(turn), math.sin(up)])
        found.append(looking_at(np.asarray(centre) + radius * way, centre))
    return found
