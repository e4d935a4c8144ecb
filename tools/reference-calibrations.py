#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes tests/reference/calibrations/points.json: where OpenCV and COLMAP see points of the scene, by each of their camera models.

    PYTHONPATH=DIR python tools/reference-calibrations.py

DIR has numpy, opencv-python-headless and pycolmap; the versions stand in the file. Numbers are those of the programs, in their own
conventions: OpenCV counts pixels from the middle of the first, COLMAP from its corner.
"""

from __future__ import annotations

import json
import sys
from importlib.metadata import version
from pathlib import Path

import cv2
import numpy as np
import pycolmap

OUT = Path(__file__).resolve().parent.parent / "tests" / "reference" / "calibrations" / "points.json"
POINTS = 24
SIZE = (1280, 960)

#: fx fy cx cy, then OpenCV's distortion coefficients: 0, 4, 5, 8, 12, 14.
OPENCV = [
    [1000.5, 1001.25, 645.3, 470.1],
    [900.0, 905.0, 640.2, 481.7, -0.31, 0.12, 0.0011, -0.0007],
    [900.0, 905.0, 640.2, 481.7, -0.28, 0.09, -0.0004, 0.0009, -0.014],
    [650.0, 652.0, 600.0, 500.0, 1.2, 0.4, 0.0003, -0.0002, 0.01, 1.5, 0.6, 0.05],
    [800.0, 790.0, 620.0, 470.0, -0.2, 0.05, 0.001, 0.002, 0.0, 0.0, 0.0, 0.0, 0.003, -0.001, -0.002, 0.0005],
    [
        800.0,
        790.0,
        620.0,
        470.0,
        -0.2,
        0.05,
        0.001,
        0.002,
        0.01,
        0.02,
        0.0,
        0.0,
        0.003,
        -0.001,
        -0.002,
        0.0005,
        0.06,
        -0.04,
    ],
]
#: fx fy cx cy k1 k2 k3 k4 alpha
FISHEYE = [
    [420.0, 421.0, 641.0, 479.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [380.0, 382.0, 637.5, 483.2, -0.012, 0.0093, -0.0061, 0.0011, 0.0],
    [400.0, 395.0, 630.0, 470.0, 0.05, -0.01, 0.003, -0.0004, 0.002],
]
#: Numbers behind the focal lengths and principal point.
COLMAP = {
    "SIMPLE_PINHOLE": [],
    "PINHOLE": [],
    "SIMPLE_RADIAL": [-0.11],
    "RADIAL": [-0.15, 0.03],
    "OPENCV": [-0.2, 0.05, 0.001, -0.0015],
    "FULL_OPENCV": [0.9, 0.3, 0.0007, -0.0004, 0.02, 1.1, 0.4, 0.03],
    "FOV": [0.92],
    "DIVISION": [-0.13],
    "SIMPLE_DIVISION": [0.08],
    "EUCM": [0.61, 1.12],
    "SIMPLE_FISHEYE": [],
    "FISHEYE": [],
    "SIMPLE_RADIAL_FISHEYE": [-0.02],
    "RADIAL_FISHEYE": [-0.03, 0.004],
    "OPENCV_FISHEYE": [-0.02, 0.011, -0.004, 0.0006],
    "THIN_PRISM_FISHEYE": [-0.02, 0.01, 0.0007, -0.0011, -0.003, 0.0004, 0.0012, -0.0008],
    "RAD_TAN_THIN_PRISM_FISHEYE": [-0.02, 0.01, -0.003, 0.0004, 0.0002, -0.0001, 0.0007, -0.0011, 0.0012, -0.0008, 0.0004, 0.0003],
    "EQUIRECTANGULAR": [],
}  # fmt: skip


def scene(rng: np.random.Generator, largest_deg: float) -> np.ndarray:
    """Points at all angles from the axis up to the largest."""
    angle = np.radians(largest_deg) * np.sqrt(np.linspace(0.0, 1.0, POINTS))
    around = rng.uniform(0.0, 2.0 * np.pi, POINTS)
    distance = rng.uniform(0.5, 20.0, POINTS)
    return (
        np.stack([np.sin(angle) * np.cos(around), np.sin(angle) * np.sin(around), np.cos(angle)], 1) * distance[:, None]
    )


def opencv(rng: np.random.Generator, p: list[float]) -> dict:
    points = scene(rng, 33.0)
    k = np.array([[p[0], 0, p[2]], [0, p[1], p[3]], [0, 0, 1.0]])
    seen, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), k, np.array(p[4:] or [0.0] * 4))
    return {
        "program": "OpenCV",
        "model": "projectPoints",
        "parameters": p,
        "scene": points,
        "seen": seen.reshape(-1, 2),
    }


def fisheye(rng: np.random.Generator, p: list[float]) -> dict:
    points = scene(rng, 80.0)
    k = np.array([[p[0], 0, p[2]], [0, p[1], p[3]], [0, 0, 1.0]])
    zero = np.zeros((1, 1, 3))
    seen, _ = cv2.fisheye.projectPoints(points.reshape(-1, 1, 3), zero, zero, k, np.array(p[4:8]), alpha=p[8])
    return {"program": "OpenCV", "model": "fisheye", "parameters": p, "scene": points, "seen": seen.reshape(-1, 2)}


def colmap(rng: np.random.Generator, name: str, more: list[float]) -> dict:
    camera = pycolmap.Camera.create_from_model_name(1, name, 500.0, *SIZE)
    names = [word.strip() for word in camera.params_info.split(",")]
    first = {"f": 510.0, "fx": 510.0, "fy": 514.0, "cx": 643.0, "cy": 477.0, "w": SIZE[0], "h": SIZE[1]}
    own = [first[word] for word in names if word in first]
    camera.params = own + more
    is_wide = "FISHEYE" in name or name == "EQUIRECTANGULAR"
    points = scene(
        rng, 100.0 if is_wide and "OPENCV" not in name else 60.0 if name in {"EUCM", "FOV"} or is_wide else 38.0
    )
    seen = np.array(camera.img_from_cam(points))
    keep = np.isfinite(seen).all(1)
    return {"program": "COLMAP", "model": name, "parameters": own + more, "scene": points[keep], "seen": seen[keep]}


def main() -> int:
    rng = np.random.default_rng(41)
    cases = [opencv(rng, p) for p in OPENCV] + [fisheye(rng, p) for p in FISHEYE]
    cases += [colmap(rng, name, more) for name, more in COLMAP.items()]
    for case in cases:
        case["size"] = SIZE
        for key in ("scene", "seen"):
            case[key] = [[float(x) for x in row] for row in case[key]]
        print(case["program"], case["model"], len(case["seen"]))
    versions = {name: version(name) for name in ("opencv-python-headless", "pycolmap", "numpy")}
    rows = ",\n".join(json.dumps(case) for case in cases)
    OUT.write_text(f'{{"made_by": {json.dumps(versions)},\n"cases": [\n{rows}\n]}}\n', encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
