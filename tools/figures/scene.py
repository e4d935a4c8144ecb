# SPDX-License-Identifier: GPL-3.0-or-later
"""The places of a scene's objects, as its camera has them. Needs bpy."""

from __future__ import annotations

from pathlib import Path

import numpy as np

#: Millimetres of one Blender unit in the gallery.
SCALE_MM = 1000.0


def places_mm(blend: Path, words: str, lift: float = 0.0) -> dict[str, np.ndarray]:
    """Origins of the objects whose names begin so, or places that much above them: mm to the right of the camera, above it, and before
    it."""
    import bpy
    from mathutils import Vector

    bpy.ops.wm.open_mainfile(filepath=str(blend), load_ui=False)
    scene = bpy.context.scene
    towards = scene.camera.matrix_world.inverted()
    found = {}
    for one in scene.objects:
        if one.name.startswith(words):
            x, y, z = towards @ (one.matrix_world.translation + Vector((0.0, 0.0, lift)))
            found[one.name] = SCALE_MM * np.array([x, y, -z])
    return found


def in_lens_space(place_mm: np.ndarray, pupil_z_mm: float) -> np.ndarray:
    """The point in lens space of a place before the camera, which stands in the middle of the entrance pupil."""
    x, y, depth = place_mm
    return np.array([x, y, pupil_z_mm - depth])


def corners_mm(blend: Path, name: str) -> np.ndarray:
    """The corners of the bounding box of the object whose name begins so, (8, 3): mm to the right of the camera, above it, and before
    it."""
    import bpy
    from mathutils import Vector

    bpy.ops.wm.open_mainfile(filepath=str(blend), load_ui=False)
    scene = bpy.context.scene
    one = next(each for each in scene.objects if each.name.startswith(name))
    to_camera = scene.camera.matrix_world.inverted() @ one.matrix_world
    corners = np.array([tuple(to_camera @ Vector(corner)) for corner in one.bound_box])
    return SCALE_MM * corners * [1.0, 1.0, -1.0]


def box_px(
    blend: Path, name: str, focal_mm: float, film_mm: tuple[float, float], size: tuple[int, int], part: float = 0.7
) -> tuple[slice, slice]:
    """Rows and columns that hold the middle part of an object's bounding box, as a pinhole of that focal length has it."""
    corners = corners_mm(blend, name)
    x, y = (focal_mm * corners[:, k] / corners[:, 2] / film_mm[k] for k in (0, 1))
    found = []
    for values, count in (((0.5 - y) * size[1], size[1]), ((x + 0.5) * size[0], size[0])):
        middle, half = 0.5 * (values.min() + values.max()), 0.5 * part * (values.max() - values.min())
        found.append(slice(max(round(middle - half), 0), min(round(middle + half) + 1, count)))
    return found[0], found[1]
