# SPDX-License-Identifier: GPL-3.0-or-later
"""The velocities of vertices, points and keys of curves by simulations: their number may change, so that no neighbouring frame could tell."""

from __future__ import annotations

import bpy
import numpy as np

#: The name of the attribute of meshes, curves and point clouds: Blender units a second, object space.
_NAME = "velocity"


def of(data: bpy.types.ID, seconds: float) -> np.ndarray | None:
    """The way of each vertex, point or key in so many seconds, (vertices, 3), Blender units; None without a velocity attribute."""
    if not isinstance(data, (bpy.types.Mesh, bpy.types.Curves, bpy.types.PointCloud)):
        return None
    attribute = data.attributes.get(_NAME)
    if attribute is None or attribute.domain != "POINT" or attribute.data_type != "FLOAT_VECTOR":
        return None
    way = np.empty((len(attribute.data), 3), np.float32)
    attribute.data.foreach_get("vector", way.reshape(-1))
    return way * np.float32(seconds)


def frame_s(scene: bpy.types.Scene) -> float:
    """The length of a frame, s."""
    return scene.render.fps_base / scene.render.fps
