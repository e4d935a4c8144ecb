# SPDX-License-Identifier: GPL-3.0-or-later
"""What simulations say of how vertices and points go, where no neighbouring frame could tell: their number may change."""

from __future__ import annotations

import bpy
import numpy as np

#: By what it is known, of meshes and point clouds: Blender units a second, object space.
_NAME = "velocity"


def of(data: bpy.types.ID, seconds: float) -> np.ndarray | None:
    """How far each vertex or point goes in so many seconds, (vertices, 3); None where nothing says so."""
    if not isinstance(data, (bpy.types.Mesh, bpy.types.PointCloud)):
        return None
    attribute = data.attributes.get(_NAME)
    if attribute is None or attribute.domain != "POINT" or attribute.data_type != "FLOAT_VECTOR":
        return None
    way = np.empty((len(attribute.data), 3), np.float32)
    attribute.data.foreach_get("vector", way.reshape(-1))
    return way * np.float32(seconds)


def frame_s(scene: bpy.types.Scene) -> float:
    """How long a frame is, seconds."""
    return scene.render.fps_base / scene.render.fps
