# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene that all programs render, as plain data: one .npz a size, with its description in scene.json beside it.

Metres, z up. The camera stands at (0, 0, 1.2) and looks along +y over five rows of bodies, each row farther away, on a
ground before a wall. 24 small lamps hang between them under a sky that is lighter at the horizon.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

#: Meridians and rings of a body: twenty bodies of 2 n^2 triangles.
SIZES = {"small": 22, "large": 158, "empty": 0}
EYE = (0.0, 0.0, 1.2)
CAMERA = {"eye": EYE, "focal_length_mm": 50.0, "film_width_mm": 36.0, "f_number": 2.0, "focus_m": 2.0, "bounces": 8}
ROWS_M = (0.8, 2.0, 5.0, 12.0, 30.0)
IN_A_ROW = 4
LAMP_ROWS_M = (1.1, 6.0, 9.0, 16.0, 24.0, 34.0)
LAMPS = 24
LAMP_RADIANCE = 60.0
SKY_ROWS = 128

MATERIALS = {
    "ground": {"kind": "diffuse", "rgb": (0.32, 0.30, 0.28)},
    "wall": {"kind": "diffuse", "rgb": (0.45, 0.42, 0.38)},
    "red": {"kind": "diffuse", "rgb": (0.65, 0.12, 0.09)},
    "green": {"kind": "diffuse", "rgb": (0.14, 0.50, 0.16)},
    "white": {"kind": "diffuse", "rgb": (0.75, 0.75, 0.72)},
    "gold": {"kind": "metal", "rgb": (0.95, 0.72, 0.32), "alpha": 0.09},
    "steel": {"kind": "metal", "rgb": (0.70, 0.71, 0.73), "alpha": 0.16},
    "glass": {"kind": "glass", "ior": 1.5},
}
#: Materials of the bodies, over and over.
BODY_MATERIALS = ("red", "gold", "white", "green", "steel", "glass", "white", "red", "gold", "green")


def bumpy_ball(n: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A unit sphere with dents and bumps: vertices and outward triangles, 2 n^2 of them."""
    dice = np.random.default_rng(seed)
    polar, around = np.pi * np.arange(1, n + 1) / (n + 1), 2.0 * np.pi * np.arange(n) / n
    ring = np.stack(
        [
            np.outer(np.sin(polar), np.cos(around)),
            np.outer(np.sin(polar), np.sin(around)),
            np.outer(np.cos(polar), np.ones(n)),
        ],
        -1,
    ).reshape(-1, 3)
    directions = np.concatenate([ring, [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0)]])
    # Waves in twelve directions, the short ones the lower.
    waves = dice.normal(size=(12, 3)) * dice.uniform(2.0, 9.0, size=(12, 1))
    heights = 0.23 / (2.0 + np.linalg.norm(waves, axis=1))
    radius = 1.0 + np.sin(directions @ waves.T + dice.uniform(0.0, 2.0 * np.pi, 12)) @ heights
    this, below = np.arange(n - 1)[:, None] * n, np.arange(1, n)[:, None] * n
    here, beside = np.arange(n), (np.arange(n) + 1) % n
    band = [(this + here, below + here, below + beside), (this + here, below + beside, this + beside)]
    top, bottom, last = n * n, n * n + 1, (n - 1) * n
    caps = [(np.full(n, top), here, beside), (np.full(n, bottom), last + beside, last + here)]
    triangles = [np.stack([np.ravel(corner) for corner in corners], -1) for corners in (*band, *caps)]
    return directions * radius[:, None], np.concatenate(triangles).astype(np.int32)


def bumpy_ring(n: int, phase: float) -> tuple[np.ndarray, np.ndarray]:
    """A torus about y with knobs, as large as the ball: vertices and outward triangles, 2 n^2 of them."""
    turn, tube = np.meshgrid(*[2.0 * np.pi * np.arange(n) / n] * 2, indexing="ij")
    thickness = 0.36 + 0.09 * np.sin(5.0 * turn + phase) * np.cos(3.0 * tube)
    out = 0.64 + thickness * np.cos(tube)
    vertices = np.stack([out * np.cos(turn), thickness * np.sin(tube), out * np.sin(turn)], -1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    k, m = (i + 1) % n, (j + 1) % n
    corner = [(a * n + b).ravel() for a, b in ((i, j), (i, m), (k, m), (k, j))]
    triangles = np.concatenate([np.stack(corner[:3], -1), np.stack([corner[0], corner[2], corner[3]], -1)])
    return vertices, triangles.astype(np.int32)


def icosahedron() -> tuple[np.ndarray, np.ndarray]:
    """Radius 1, outward triangles."""
    golden = 0.5 * (1.0 + 5.0**0.5)
    signs = ((-1, -1), (-1, 1), (1, -1), (1, 1))
    points = [np.roll((0.0, a, b * golden), shift) for shift in range(3) for a, b in signs]
    vertices = np.array(points) / np.hypot(1.0, golden)
    # Edges are the nearest pairs; a triangle is three vertices that are all near each other.
    near = np.linalg.norm(vertices[:, None] - vertices[None], axis=2) < 1.2
    found = [
        (a, b, c) for a in range(12) for b in range(a) for c in range(b) if near[a, b] and near[b, c] and near[a, c]
    ]
    outward = [(a, b, c) if np.linalg.det(vertices[[a, b, c]]) > 0.0 else (a, c, b) for a, b, c in found]
    return vertices, np.array(outward, np.int32)


def smooth_normals(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """The mean of the triangles' normals at each vertex, weighted by their angles there, as Blender has it."""
    corners = vertices[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    total = np.zeros_like(vertices)
    for k in range(3):
        one = corners[:, (k + 1) % 3] - corners[:, k]
        other = corners[:, (k + 2) % 3] - corners[:, k]
        lengths = np.linalg.norm(one, axis=1) * np.linalg.norm(other, axis=1)
        angle = np.arccos(np.clip((one * other).sum(1) / np.maximum(lengths, 1e-30), -1.0, 1.0))
        np.add.at(total, triangles[:, k], normal * angle[:, None])
    return total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-30)


def sky() -> np.ndarray:
    """Radiance over the whole sphere, equirectangular, zenith first: (rows, columns, 3)."""
    height = np.cos((np.arange(SKY_ROWS) + 0.5) / SKY_ROWS * np.pi)[:, None]
    horizon, zenith, below = np.array((0.9, 0.8, 0.7)), np.array((0.25, 0.4, 0.8)), np.array((0.10, 0.09, 0.08))
    rows = np.where(height >= 0.0, horizon + (zenith - horizon) * height, below)
    return np.repeat(rows[:, None, :], 2 * SKY_ROWS, 1).astype(np.float32)


def objects(n: int) -> list[dict]:
    """Each with name, vertices, triangles, and a material's name or an emitted radiance."""
    made: list[dict] = []

    def add(name, vertices, triangles, material=None, emits=None):
        made.append(
            {
                "name": name,
                "vertices": np.asarray(vertices, float),
                "triangles": np.asarray(triangles, np.int32),
                "material": material,
                "emits": emits,
            }
        )

    square = [(0, 1, 2), (0, 2, 3)]
    if n == 0:
        # Behind the camera, so that there is something to trace against.
        add("speck", [(0, -50, 0), (0.01, -50, 0), (0.01, -50, 0.01), (0, -50, 0.01)], square, "ground")
        return made
    add("ground", [(-60, -10, 0), (60, -10, 0), (60, 60, 0), (-60, 60, 0)], square, "ground")
    add("wall", [(-25, 40, 0), (25, 40, 0), (25, 40, 9), (-25, 40, 9)], square, "wall")
    dice = np.random.default_rng(2011)
    for row, distance in enumerate(ROWS_M):
        for place in range(IN_A_ROW):
            i = row * IN_A_ROW + place
            # Rows rise through the picture, and stand a little beside each other.
            right = -0.29 + 0.18 * place + 0.035 * (row % 3) + dice.uniform(-0.015, 0.015)
            up = -0.13 + 0.062 * row + dice.uniform(-0.012, 0.012)
            centre = np.array([right * distance, distance * (1.0 + 0.07 * place), EYE[2] + up * distance])
            # On the ground at least.
            centre[2] = max(centre[2], 0.06 * distance)
            shape, triangles = bumpy_ring(n, float(i)) if i % 3 == 2 else bumpy_ball(n, 100 + i)
            add(f"body{i:02d}", shape * (0.058 * distance) + centre, triangles, BODY_MATERIALS[i % len(BODY_MATERIALS)])
    shape, triangles = icosahedron()
    for i in range(LAMPS):
        distance = LAMP_ROWS_M[i % len(LAMP_ROWS_M)]
        right, up = dice.uniform(-0.33, 0.33), dice.uniform(-0.08, 0.19)
        colour = np.array([1.0, dice.uniform(0.5, 1.0), dice.uniform(0.2, 1.0)])
        centre = np.array([right * distance, distance, max(0.1, EYE[2] + up * distance)])
        add(f"lamp{i:02d}", shape * (0.0035 * distance) + centre, triangles, emits=(LAMP_RADIANCE * colour).tolist())
    return made


def write(folder: Path) -> None:
    """Writes all sizes, unless they are there."""
    for name, n in SIZES.items():
        target = Path(folder) / name
        if (target / "scene.json").exists():
            continue
        target.mkdir(parents=True, exist_ok=True)
        made = objects(n)
        arrays, listed = {"sky": sky()}, []
        for one in made:
            vertices, triangles = one["vertices"], one["triangles"]
            arrays[one["name"] + ".vertices"] = vertices.astype(np.float32)
            arrays[one["name"] + ".triangles"] = triangles
            arrays[one["name"] + ".normals"] = smooth_normals(vertices, triangles).astype(np.float32)
            listed.append({key: one[key] for key in ("name", "material", "emits")})
        np.savez(target / "scene.npz", **arrays)
        about = {
            "triangles": sum(len(one["triangles"]) for one in made),
            "materials": MATERIALS,
            "objects": listed,
            "camera": CAMERA,
        }
        (target / "scene.json").write_text(json.dumps(about, indent=1) + "\n")


def read(folder: Path) -> tuple[dict, dict[str, np.ndarray]]:
    """The files that `write` has written for one size: the description and the arrays."""
    folder = Path(folder)
    with np.load(folder / "scene.npz") as arrays:
        return json.loads((folder / "scene.json").read_text()), dict(arrays)
