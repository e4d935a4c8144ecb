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


def covered(d: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """The part of a pixel on the far side of an edge whose distance from its middle is `d` along the unit normal."""
    a, b = np.maximum(np.abs(normal), 1e-6)
    ramp = [np.maximum(d + shift, 0.0) ** 2 for shift in ((a + b) / 2, (a - b) / 2, (b - a) / 2, -(a + b) / 2)]
    return (ramp[0] - ramp[1] - ramp[2] + ramp[3]) / (2 * a * b)


def model(p: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Pixels about a corner of black and white: its place, two edges by angle and curvature, and which fields are white."""
    sides = []
    for angle, bend in ((p[2], p[4]), (p[3], p[5])):
        along, normal = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
        way = (x - p[0]) * along[0] + (y - p[1]) * along[1]
        off = (x - p[0]) * normal[0] + (y - p[1]) * normal[1] - 0.5 * bend * way * way
        sides.append(2.0 * covered(off, normal) - 1.0)
    return 0.5 + 0.5 * sides[0] * sides[1]


def refined(picture: np.ndarray, near: np.ndarray, angles: np.ndarray, half: int) -> np.ndarray:
    """Corners in a grey picture, first row at the top, pixels counted from the middle of the first, whose pixels are means over their squares.

    Each is fitted by least squares to the edges within `half` pixels, from a place `near` it and about the `angles` of its two edges. OpenCV's
    `cornerSubPix` takes such sharp edges for smooth ones and is off by some 0.05 pixel, as the corner lies in its pixel.
    """
    found = []
    dy, dx = np.mgrid[-half : half + 1, -half : half + 1]
    for place, (first, second) in zip(near, angles, strict=True):
        column, row = np.round(place).astype(int)
        x, y = column + dx.ravel(), row + dy.ravel()
        seen = picture[row - half : row + half + 1, column - half : column + half + 1].ravel()
        p = np.array([*place, first, second, 0.0, 0.0])
        sign = 1.0 if ((model(p, x, y) - 0.5) * (seen - 0.5)).sum() > 0 else -1.0
        seen = 0.5 + sign * (seen - 0.5)
        for _ in range(12):
            # What a pixel has of both edges is not a product.
            weight = np.hypot(x - p[0], y - p[1]) > 1.6
            now = model(p, x, y)
            steps = np.array([1e-4, 1e-4, 1e-5, 1e-5, 1e-6, 1e-6])
            slopes = np.stack([(model(p + step * np.eye(6)[i], x, y) - now) / step for i, step in enumerate(steps)], 1)
            change, *_ = np.linalg.lstsq(slopes[weight], (seen - now)[weight], rcond=None)
            p = p + change
        found.append(p[:2])
    return np.array(found)
