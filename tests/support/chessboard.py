# SPDX-License-Identifier: GPL-3.0-or-later
"""A chessboard before a camera, and its corners in pictures, for tests of calibrated cameras."""

from __future__ import annotations

import math

import numpy as np

#: Inner corners across and up, and the side of a square, Blender units.
COUNT, SIDE = (9, 6), 0.1


def add(bpy, parts, name: str = "Board"):
    """A board in the plane z = 0, its middle at the origin, x to the right and y up; it glows, and a white margin is about it."""
    white, black = parts.emitter((1.0, 1.0, 1.0), 1.0), parts.emitter((0.0, 0.0, 0.0), 0.0)
    across, up = COUNT[0] + 3, COUNT[1] + 3
    xs = (np.arange(across + 1) - 0.5 * across) * SIDE
    ys = (np.arange(up + 1) - 0.5 * up) * SIDE
    vertices = [(float(x), float(y), 0.0) for y in ys for x in xs]
    faces, materials = [], []
    for j in range(up):
        for i in range(across):
            first = j * (across + 1) + i
            faces.append((first, first + 1, first + across + 2, first + across + 1))
            inside = 0 < i < across - 1 and 0 < j < up - 1
            materials.append(1 if inside and (i + j) % 2 else 0)
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    mesh.materials.append(white)
    mesh.materials.append(black)
    mesh.polygons.foreach_set("material_index", materials)
    mesh.update()
    board = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(board)
    return board


def corners() -> np.ndarray:
    """The inner corners on the board, row by row from the upper left as it is seen from +z: (n, 3)."""
    across, up = COUNT
    xs = (np.arange(across) - 0.5 * (across - 1)) * SIDE
    ys = (np.arange(up)[::-1] - 0.5 * (up - 1)) * SIDE
    return np.array([(x, y, 0.0) for y in ys for x in xs])


def refined(picture: np.ndarray, near: np.ndarray, half: int) -> np.ndarray:
    """Corners in a grey picture, first row at the top, each the saddle of a chessboard within `half` pixels of a place near it.

    As a corner of OpenCV's `cornerSubPix` (Foerstner and Guelch 1987): the point to which the gradients about it are perpendicular.
    """
    slope_y, slope_x = np.gradient(picture)
    found = np.array(near, float)
    for number in range(len(found)):
        for _ in range(40):
            x, y = found[number]
            column, row = round(x), round(y)
            at = np.s_[row - half : row + half + 1, column - half : column + half + 1]
            gx, gy = slope_x[at].ravel(), slope_y[at].ravel()
            dy, dx = np.mgrid[-half : half + 1, -half : half + 1]
            px, py = column + dx.ravel(), row + dy.ravel()
            weight = np.exp(-((px - x) ** 2 + (py - y) ** 2) / (0.5 * half) ** 2)
            matrix = np.array(
                [
                    [(weight * gx * gx).sum(), (weight * gx * gy).sum()],
                    [(weight * gx * gy).sum(), (weight * gy * gy).sum()],
                ]
            )
            right = np.array([(weight * gx * (gx * px + gy * py)).sum(), (weight * gy * (gx * px + gy * py)).sum()])
            moved = np.linalg.solve(matrix, right)
            step = math.hypot(*(moved - found[number]))
            found[number] = moved
            if step < 1e-5:
                break
    return found
