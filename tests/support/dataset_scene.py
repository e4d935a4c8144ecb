# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene for `petzval dataset` with things that move before a camera that walks, runs of the command, and its files as arrays."""

from __future__ import annotations

import json
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np

from support.places import TESTS

MAKE = """
import os, sys
sys.path.insert(0, {tests!r})
import bpy
import petzval
bpy.ops.wm.read_factory_settings(use_empty=True)
petzval.load_addon().register()
from support import scenes as parts
scene = parts.set_up(48, 32, 1)
parts.mesh_object("Floor", [(-20, -20, -1), (20, -20, -1), (20, 40, -1), (-20, 40, -1)], [(0, 1, 2, 3)], parts.emitter((0.2, 0.5, 0.2)))

def cube(name, at, size, colour):
    bpy.ops.mesh.primitive_cube_add(size=size, location=at)
    made = bpy.context.object
    made.name = name
    made.data.materials.append(parts.emitter(colour))
    return made

one, other = cube("Box.A", (0, 6, 0), 2, (1, 0.2, 0.2)), cube("Box.B", (2.5, 8, 0.3), 1.5, (0.2, 0.2, 1))
other["kind"] = "blue"
camera = scene.camera
camera.data.dof.focus_distance, camera.data.shift_x, camera.data.shift_y = 6.0, 0.03, -0.02
for frame, x in ((1, 0.0), (11, 3.0)):
    one.location.x, one.rotation_euler.z = x, x / 3
    camera.location, camera.rotation_euler = (x / 3, 0.0, 0.5), (1.5, 0.02, x / 30)
    for holder in (one, camera):
        for path in ("location", "rotation_euler"):
            holder.keyframe_insert(path, frame=frame)
group = bpy.data.collections.new("Group")
small = cube("Small", (0, 0, 0), 0.6, (1, 1, 0))
group.objects.link(small)
scene.collection.objects.unlink(small)
for i in range(2):
    placed = bpy.data.objects.new(f"Placed{{i}}", None)
    placed.instance_type, placed.instance_collection = "COLLECTION", group
    placed.location = (-1.6 - 0.8 * i, 7 + i, 0.2)
    scene.collection.objects.link(placed)
bpy.ops.wm.save_as_mainfile(filepath={path!r})
sys.stdout.flush()
os._exit(0)
"""


def save(path: Path) -> None:
    """Saves the scene."""
    script = MAKE.format(tests=str(TESTS), path=str(path))
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False, timeout=60)
    assert path.exists(), done.stdout + done.stderr


def numbers(path: Path, channels: int = 1) -> np.ndarray:
    """A picture as Blender reads it, first row at the top: floats of an EXR, whole numbers of a PNG of 16 bits."""
    from support import scenes

    pixels = np.flipud(scenes.read(path))[..., :channels]
    if path.suffix == ".png":
        assert path.read_bytes()[24] == 16
        # One in 65535 is further apart than the rounding of a float.
        pixels = np.rint(pixels.astype(float) * 65535).astype(int)
    return pixels[..., 0] if channels == 1 else pixels


def flow(path: Path) -> np.ndarray:
    """A .flo file, read by the format's own page: (height, width, 2)."""
    data = path.read_bytes()
    assert struct.unpack_from("<f", data)[0] == 202021.25
    width, height = struct.unpack_from("<2i", data, 4)
    assert len(data) == 12 + 8 * width * height
    return np.frombuffer(data, "<f4", offset=12).reshape(height, width, 2)


def distorted(model: str, p: list[float], points: np.ndarray) -> np.ndarray:
    """Pixels of points in camera space by OpenCV's equations, written anew: of FULL_OPENCV and PINHOLE as COLMAP orders their parameters."""
    fx, fy, cx, cy = p[:4]
    x, y = points[..., 0] / points[..., 2], points[..., 1] / points[..., 2]
    if model == "FULL_OPENCV":
        k1, k2, p1, p2, k3, k4, k5, k6 = p[4:]
        r = x**2 + y**2
        radial = (1 + k1 * r + k2 * r**2 + k3 * r**3) / (1 + k4 * r + k5 * r**2 + k6 * r**3)
        x, y = x * radial + 2 * p1 * x * y + p2 * (r + 2 * x**2), y * radial + p1 * (r + 2 * y**2) + 2 * p2 * x * y
    else:
        assert model == "PINHOLE"
    return np.stack([fx * x + cx, fy * y + cy], axis=-1)


def colmap(folder: Path) -> dict[str, tuple]:
    """COLMAP's text model, read by its page: by picture, (model, parameters, world to camera (3, 4))."""
    cameras = {}
    for line in (folder / "cameras.txt").read_text().splitlines():
        if not line.startswith("#"):
            number, model, _width, _height, *p = line.split()
            cameras[number] = model, [float(one) for one in p]
    found = {}
    lines = [line for line in (folder / "images.txt").read_text().splitlines() if not line.startswith("#")]
    for line in lines[::2]:
        _, *values, camera, name = line.split()
        w, x, y, z, *t = map(float, values)
        assert abs(w * w + x * x + y * y + z * z - 1) < 1e-6
        v = np.array([x, y, z])
        turn = (w * w - v @ v) * np.eye(3) + 2 * np.outer(v, v) + 2 * w * np.cross(np.eye(3), v)
        found[name] = (*cameras[camera], np.concatenate([turn, np.array(t)[:, None]], axis=1))
    return found


def pixels(height: int, width: int) -> np.ndarray:
    """The middle of each pixel, right and down from the upper left corner: (height, width, 2)."""
    rows, columns = np.indices((height, width))
    return np.stack([columns + 0.5, rows + 0.5], axis=-1)


def records(folder: Path) -> list[dict]:
    return json.loads((folder / "cameras.json").read_text())
