# SPDX-License-Identifier: GPL-3.0-or-later
"""Culling, of Simplify: objects that are left out because Blender's own camera does not see them or they are far from it."""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Matrix

Points = np.ndarray


class Culling:
    """Cycles' settings of a scene for that, and the camera that it goes by: Blender's own, whatever lens stands before it."""

    def __init__(self, depsgraph: bpy.types.Depsgraph, camera: bpy.types.Object | None = None) -> None:
        scene = depsgraph.scene_eval
        own, render, camera = getattr(scene, "cycles", None), scene.render, camera or scene.camera
        # As Cycles has it: a panoramic camera sees all.
        acts = (
            own is not None
            and depsgraph.mode == "RENDER"
            and render.use_simplify
            and camera is not None
            and camera.type == "CAMERA"
            and camera.data.type != "PANO"
        )
        self._by_camera = acts and own.use_camera_cull
        self._by_distance = acts and own.use_distance_cull and own.distance_cull_margin > 0.0
        if not (self._by_camera or self._by_distance):
            return
        self._margin, self._distance = own.camera_cull_margin, own.distance_cull_margin
        self._place = np.array(camera.matrix_world.translation)
        # Cycles' camera has no scale.
        location, turn, _ = camera.matrix_world.decompose()
        self._view = np.linalg.inv(np.array(Matrix.LocRotScale(location, turn, None)))
        self._projection = np.array(
            camera.calc_matrix_camera(
                depsgraph,
                x=render.resolution_x,
                y=render.resolution_y,
                scale_x=render.pixel_aspect_x,
                scale_y=render.pixel_aspect_y,
            )
        )
        self._clip = camera.data.clip_start, camera.data.clip_end
        self._is_parallel = camera.data.type == "ORTHO"

    def keeps(self, place: bpy.types.DepsgraphObjectInstance) -> bool:
        """True if an instance is not culled; an instance that asks for both kinds of culling is kept if one of them keeps it."""
        if not (self._by_camera or self._by_distance):
            return True
        own = place.object.cycles
        by_camera, by_distance = self._by_camera and own.use_camera_cull, self._by_distance and own.use_distance_cull
        if not (by_camera or by_distance):
            return True
        corners = np.array(place.object.bound_box) @ np.array(place.matrix_world)[:3, :3].T
        corners += np.array(place.matrix_world.translation)
        return (by_camera and self._is_near_the_frame(corners)) or (by_distance and self._is_near(corners))

    def _is_near(self, corners: Points) -> bool:
        """True if the box about the corners comes within the distance of the camera."""
        nearest = np.clip(self._place, corners.min(0), corners.max(0))
        return bool(np.linalg.norm(nearest - self._place) <= self._distance)

    def _is_near_the_frame(self, corners: Points) -> bool:
        """True if the box about the corners' places in the picture comes within the margin, a part of the picture, of the frame."""
        seen = np.c_[corners, np.ones(8)] @ self._view.T
        projected = seen @ self._projection.T
        # A corner beside the camera itself is far outside the frame, not nowhere.
        w = projected[:, 3:]
        at = 0.5 + 0.5 * projected[:, :2] / np.where(np.abs(w) < 1e-12, 1e-12, w)
        # Depth as Cycles has it, before it is divided.
        near, far = self._clip
        depth = (-seen[:, 2] - near) * (1.0 if self._is_parallel else far) / (far - near)
        at = np.where(depth[:, None] < 0.0, 1.0 - at, at)
        is_before = (depth >= -self._margin).any()
        is_beside = (at.min(0) >= 1.0 + self._margin).any() or (at.max(0) <= -self._margin).any()
        return bool(is_before and not is_beside)
