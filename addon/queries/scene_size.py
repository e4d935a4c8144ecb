# SPDX-License-Identifier: GPL-3.0-or-later
"""The size of the scene for the lens, for the Scale panel: measured by a timer when nothing has changed for a while, remembered,
never while a panel draws.
// The measurement covers the boxes of everything that is rendered, and the nearest hit of Blender's own rays in the camera's view.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import Any

import bpy
from mathutils import Vector

from petzval.description import OF_LENS_FILE, CameraDescription

from ..export import camera as camera_export
from ..export.errors import ExportError
from ..export.report import Report
from ..native import EngineMissing, engine
from . import autofocus, lens_info
from .lookout import Lookout

# Rays over the picture's width and height.
_LOOKS = (12, 8)
# A forest has millions: the box of so many says enough.
_MOST_INSTANCES = 50_000
_KINDS = {"MESH", "CURVE", "SURFACE", "META", "FONT", "CURVES", "POINTCLOUD", "VOLUME"}
# 1000 km.
_HUGE_MM = 1e9
# A smaller blur is not seen.
_SEEN_PX = 0.5


@dataclass
class Size:
    """Lengths in Blender units and, for the lens, in millimetres; None where nothing is there."""

    span: float | None = None
    span_mm: float | None = None
    nearest: float | None = None
    nearest_mm: float | None = None
    nearest_name: str = ""
    #: The warnings, a sentence each.
    warnings: list[str] = field(default_factory=list)
    is_current: bool = True


def measure(holder: bpy.types.Object, scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> Size:
    """Looks now."""
    found = Size()
    scale = camera_export.scale(holder.data.petzval, scene)
    low, high = _box(depsgraph)
    if low is not None:
        # Along the camera's axes each has a scale of its own; boxes turn, so the largest counts.
        found.span = (high - low).length
        found.span_mm = found.span * max(scale)
    found.nearest, found.nearest_name = _nearest(holder, scene, depsgraph)
    if found.nearest is not None:
        found.nearest_mm = found.nearest * scale[2]
    found.warnings = _warnings(found, holder, scene)
    return found


def _box(depsgraph: bpy.types.Depsgraph) -> tuple[Vector | None, Vector | None]:
    low = high = None
    for number, one in enumerate(depsgraph.object_instances):
        if number >= _MOST_INSTANCES:
            break
        what = one.object
        if what.type not in _KINDS or not one.show_self or what.hide_render:
            continue
        for corner in what.bound_box:
            place = one.matrix_world @ Vector(corner)
            low = place.copy() if low is None else Vector(map(min, low, place))
            high = place.copy() if high is None else Vector(map(max, high, place))
    return low, high


def _nearest(
    holder: bpy.types.Object, scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph
) -> tuple[float | None, str]:
    """Depth of the nearest thing that Blender's camera sees, along its axis."""
    matrix = holder.matrix_world.normalized()
    corners = holder.data.view_frame(scene=scene)
    left, right = min(c.x for c in corners), max(c.x for c in corners)
    low, high = min(c.y for c in corners), max(c.y for c in corners)
    depth = corners[0].z
    best, name = None, ""
    for row in range(_LOOKS[1]):
        for column in range(_LOOKS[0]):
            x = left + (right - left) * (column + 0.5) / _LOOKS[0]
            y = low + (high - low) * (row + 0.5) / _LOOKS[1]
            towards = Vector((x, y, depth)).normalized()
            distance, met = autofocus.nearest(scene, depsgraph, matrix.translation, matrix.to_3x3() @ towards)
            if distance is not None and (best is None or distance * -towards.z < best):
                best, name = distance * -towards.z, met
    return best, name


def _warnings(found: Size, holder: bpy.types.Object, scene: bpy.types.Scene) -> list[str]:
    if found.span_mm is None or holder.data.petzval.model not in OF_LENS_FILE:
        return []
    width, height = camera_export.resolution(scene.render)
    try:
        camera = camera_export.describe(holder, scene, width, height, Report())
        lens = _of_axis(camera)
    except (ExportError, EngineMissing, engine().PetzvalError):
        # The panel of the lens says why.
        return []
    said = []
    front = _front_diameter_mm(lens)
    if found.span_mm < front:
        said.append(
            f"The whole scene would fit into the front of the lens, {front:.0f} mm: more millimetres to a unit would make sense"
        )
    elif found.span_mm > _HUGE_MM:
        said.append("The scene is larger than 1000 km: fewer millimetres to a unit would make sense")
    near, focal = found.nearest_mm, lens["efl_mm"]
    if near is not None and focal is not None:
        pupil_mm = lens["entrance_pupil"]["diameter_mm"]
        if near < 0.5 * abs(focal):
            said.append(f"'{found.nearest_name}' is nearer than half the focal length: no film can have it sharp")
        elif pupil_mm is not None:
            # Of a point at the nearest depth, with the film at the focal plane.
            blur_px = pupil_mm * abs(focal) / near / camera.film.width_mm * width
            if blur_px < _SEEN_PX:
                said.append("All in view is as good as infinitely far: focus and f-number blur nothing")
    return said


def _of_axis(camera: CameraDescription) -> dict[str, Any]:
    """The engine's `lens_drawing_json` of the lens focused at infinity with one ray: it asks for no focus that there may not be."""
    native = engine()
    return json.loads(native.lens_drawing_json(native.Lens(camera.lens_path), camera.lens, [0.0], 1))


def _front_diameter_mm(lens: dict[str, Any]) -> float:
    """The diameter of the foremost glass or mirror, mm."""
    surfaces = lens["surfaces"]
    glass = next((one for one in surfaces if one["points"] and (one["glass_behind"] or one["is_mirror"])), surfaces[0])
    return 2.0 * max((abs(place[1]) for place in glass["points"]), default=0.0)


def for_panel(holder: bpy.types.Object, scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> Size | None:
    """The measurement that is known; measures again soon where there is none or it is out of date."""
    known = LOOKOUT.for_panel(holder, scene, view_layer)
    if known is None:
        return None
    size, size.is_current = known
    return size


def _asked(holder: bpy.types.Object, scene: bpy.types.Scene) -> tuple:
    """All of the question but the scene's objects."""
    info = lens_info.for_panel(holder, scene)
    return json.dumps(info, sort_keys=True), tuple(camera_export.scale(holder.data.petzval, scene))


LOOKOUT = Lookout(measure, _asked)


def forget() -> None:
    """Drops the remembered sizes."""
    LOOKOUT.forget()


def register() -> None:
    LOOKOUT.register()


def unregister() -> None:
    LOOKOUT.unregister()
