# SPDX-License-Identifier: GPL-3.0-or-later
"""The view of a 3D view: the scene's camera with its lens, or Blender's own perspective; and the place of its picture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import bpy
from mathutils import Matrix, Vector

from petzval.description import CameraDescription, Perspective

from ..data.tiles import Window
from ..export import aperture_mask, stereo
from ..export import camera as camera_export
from ..export.report import Report

#: The distance before its middle at which an orthographic view begins, as a part of its depth: it shows things behind its middle, too.
_BEFORE = 0.5
#: Width that a picture of our own perspective is given, mm: only its part of the focal length counts.
_WIDTH_MM = 36.0


@dataclass(frozen=True)
class View:
    """One look into the scene."""

    camera: CameraDescription
    #: Pixels of the whole picture.
    size: tuple[int, int]
    #: The place of the picture in the region: left, bottom, width, height; pixels of the screen.
    frame: tuple[float, float, float, float]
    #: The part of the picture that is seen, in its pixels.
    window: Window


def of(context: bpy.types.Context, depsgraph: bpy.types.Depsgraph, pixel_size: float, report: Report) -> View | None:
    """The view of a region; None where nothing of the picture is in it. Raises `ExportError` as the camera's export does."""
    region, space, rv3d = context.region, context.space_data, context.region_data
    if rv3d.view_perspective == "CAMERA":
        holder = space.camera if space.use_local_camera else depsgraph.scene_eval.camera
        if holder is not None and holder.type == "CAMERA":
            return _through_camera(holder.evaluated_get(depsgraph), region, space, rv3d, depsgraph, pixel_size, report)
    width, height = _pixels(region.width, pixel_size), _pixels(region.height, pixel_size)
    camera = _own(space, rv3d, (width, height))
    return View(camera, (width, height), (0.0, 0.0, region.width, region.height), Window(0, 0, width, height))


def _pixels(length: float, pixel_size: float) -> int:
    return max(round(length / pixel_size), 1)


def frame_in(
    holder: bpy.types.Object,
    scene: bpy.types.Scene,
    region: bpy.types.Region,
    rv3d: bpy.types.RegionView3D,
    eye: stereo.Eye | None = None,
) -> tuple[float, float, float, float]:
    """The frame of a view through a camera or its `eye`: left, bottom, width, height; pixels of the region."""
    # Blender's view knows nothing of scale.
    place = (holder.matrix_world if eye is None else eye.matrix).normalized()
    frame = holder.data.view_frame(scene=scene)
    aside = Vector((0.0 if eye is None else _aside(frame, holder.data, eye), 0.0, 0.0))
    places = []
    for corner in frame:
        x, y, _, w = rv3d.perspective_matrix @ (place @ (corner + aside)).to_4d()
        places.append(((x / w * 0.5 + 0.5) * region.width, (y / w * 0.5 + 0.5) * region.height))
    across, up = zip(*places, strict=True)
    return min(across), min(up), max(across) - min(across), max(up) - min(up)


def _aside(frame: Sequence[Vector], camera: bpy.types.Camera, eye: stereo.Eye) -> float:
    """The shift of the corners of a camera's frame by an eye, Blender units."""
    across, up = (max(corner[i] for corner in frame) - min(corner[i] for corner in frame) for i in (0, 1))
    fitted = {"HORIZONTAL": across, "VERTICAL": up}.get(camera.sensor_fit, max(across, up))
    return (eye.shift_x - camera.shift_x) * fitted


def _through_camera(holder, region, space, rv3d, depsgraph, pixel_size, report) -> View | None:
    scene = depsgraph.scene_eval
    eye = stereo.eye_of_3d_view(holder, scene, space, rv3d.view_matrix)
    holder = holder if eye is None else eye.holder
    left, bottom, width, height = frame_in(holder, scene, region, rv3d, eye)
    if not (width >= 1.0 and height >= 1.0 and math.isfinite(width + height)):
        return None
    # The picture's own proportions, which a frame in whole pixels of the screen has only nearly.
    whole = camera_export.resolution(scene.render)
    columns = _pixels(width, pixel_size)
    size = (columns, max(round(columns * whole[1] / whole[0]), 1))
    camera = aperture_mask.added(camera_export.describe(holder, scene, *size, report, eye=eye), holder.data)
    seen = [(0.0, 0.0), (float(region.width), float(region.height))]
    if scene.render.use_border:
        low = (left + scene.render.border_min_x * width, bottom + scene.render.border_min_y * height)
        high = (left + scene.render.border_max_x * width, bottom + scene.render.border_max_y * height)
        seen = [tuple(map(max, seen[0], low)), tuple(map(min, seen[1], high))]
    (x0, y0), (x1, y1) = seen
    begin = [max(math.floor((at - edge) / side * n), 0) for at, edge, side, n in zip((x0, y0), (left, bottom), (width, height), size, strict=True)]  # fmt: skip
    end = [min(math.ceil((at - edge) / side * n), n) for at, edge, side, n in zip((x1, y1), (left, bottom), (width, height), size, strict=True)]  # fmt: skip
    if end[0] <= begin[0] or end[1] <= begin[1]:
        return None
    window = Window(*begin, end[0] - begin[0], end[1] - begin[1])
    return View(camera, size, (left, bottom, width, height), window)


def _own(space: bpy.types.SpaceView3D, rv3d: bpy.types.RegionView3D, size: tuple[int, int]) -> CameraDescription:
    """Blender's view without a camera: all is sharp."""
    across, place = rv3d.window_matrix[0][0], rv3d.view_matrix.inverted_safe()
    if rv3d.is_perspective:
        shift = [0.5 * rv3d.window_matrix[i][2] * size[i] / max(size) for i in (0, 1)]
        return CameraDescription(
            object_name="the view",
            matrix_world=camera_export.rows(place),
            model="PINHOLE",
            perspective=Perspective(0.5 * across * _WIDTH_MM, _WIDTH_MM, tuple(shift)),
            clip=(space.clip_start, space.clip_end),
        )
    before = _BEFORE * space.clip_end
    return CameraDescription(
        object_name="the view",
        matrix_world=camera_export.rows(place @ Matrix.Translation(Vector((0.0, 0.0, before)))),
        model="ORTHOGRAPHIC",
        orthographic_width=2.0 / across,
        clip=(0.0, before + space.clip_end),
    )
