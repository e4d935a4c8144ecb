# SPDX-License-Identifier: GPL-3.0-or-later
"""How large the scene is for the lens, for the Scale panel: measured by a timer when nothing has changed for a while, remembered,
never while a panel draws.

What is measured are the boxes of what is rendered, and the nearest of what Blender's own rays meet in the camera's view.
"""

from __future__ import annotations

import json
import time
from dataclasses import dataclass, field
from typing import Any

import bpy
from bpy.app.handlers import persistent
from mathutils import Vector

from . import autofocus, lens_info, live_drawing, redraw
from .description import OF_LENS_FILE, Report
from .export import camera as camera_export
from .export.errors import ExportError
from .native import EngineMissing, engine

# So long nothing may have changed, and after so many times as long as it took where that is longer.
_QUIET_S, _QUIET_FOR_SLOW = 0.3, 4.0
# While a render runs, until it is asked again.
_BUSY_S = 1.0
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
    #: What makes no sense, a sentence each.
    warnings: list[str] = field(default_factory=list)
    is_current: bool = True


@dataclass
class _State:
    wanted: tuple | None = None
    revision: int = 0
    changed_at: float = 0.0
    quiet_s: float = _QUIET_S


_state = _State()
#: By scene and camera: what was asked, the revision of the scene, the answer.
_kept: dict[tuple, tuple[tuple, int, Size]] = {}


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
        lens = live_drawing.of_axis(camera)
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
            blur_px = pupil_mm * abs(focal) / near / camera.film_width_mm * width
            if blur_px < _SEEN_PX:
                said.append("All in view is as good as infinitely far: focus and f-number blur nothing")
    return said


def _front_diameter_mm(lens: dict[str, Any]) -> float:
    """Of the foremost glass or mirror."""
    surfaces = lens["surfaces"]
    glass = next((one for one in surfaces if one["points"] and (one["glass_behind"] or one["is_mirror"])), surfaces[0])
    return 2.0 * max((abs(place[1]) for place in glass["points"]), default=0.0)


def for_panel(holder: bpy.types.Object, scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> Size | None:
    """What is known; has it measured soon where that is nothing or out of date."""
    key = (scene.name, holder.name_full)
    kept = _kept.get(key)
    if redraw.is_rendering():
        # As for the lens's data: nothing is asked meanwhile.
        return kept[2] if kept is not None else None
    asked = _asked(holder, scene)
    is_current = kept is not None and kept[:2] == (asked, _state.revision)
    if not is_current:
        library = holder.library.filepath if holder.library else None
        _state.wanted = (scene.name, view_layer.name, (holder.name, library))
        if not bpy.app.timers.is_registered(_look):
            bpy.app.timers.register(_look, first_interval=_state.quiet_s)
    if kept is None:
        return None
    kept[2].is_current = is_current
    return kept[2]


def _asked(holder: bpy.types.Object, scene: bpy.types.Scene) -> tuple:
    """All of the question but the scene's objects."""
    info = lens_info.for_panel(holder, scene)
    return json.dumps(info, sort_keys=True), tuple(camera_export.scale(holder.data.petzval, scene))


def _look() -> float | None:
    """The timer; gives the seconds until it is to be called again."""
    wait = _state.changed_at + _state.quiet_s - time.monotonic()
    if wait > 0.0:
        return wait
    if bpy.app.is_job_running("RENDER"):
        return _BUSY_S
    wanted, _state.wanted = _state.wanted, None
    if wanted is None:
        return None
    # By name: what a timer keeps may have gone meanwhile.
    scene, holder = bpy.data.scenes.get(wanted[0]), bpy.data.objects.get(wanted[2])
    layer = scene.view_layers.get(wanted[1]) if scene is not None else None
    depsgraph = layer.depsgraph if layer is not None else None
    if holder is None or holder.type != "CAMERA" or depsgraph is None:
        return None
    began = time.monotonic()
    while len(_kept) >= 16:
        del _kept[next(iter(_kept))]
    _kept[scene.name, holder.name_full] = (_asked(holder, scene), _state.revision, measure(holder, scene, depsgraph))
    _state.quiet_s = max(_QUIET_S, _QUIET_FOR_SLOW * (time.monotonic() - began))
    redraw.properties()
    return None


@persistent
def _scene_changed(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None) -> None:
    if depsgraph is None or depsgraph.mode == "VIEWPORT":
        _state.revision += 1
        _state.changed_at = time.monotonic()


@persistent
def _file_loaded(_file: str) -> None:
    forget()


def forget() -> None:
    """Drops what is remembered."""
    _kept.clear()
    _state.wanted, _state.quiet_s = None, _QUIET_S


_HANDLERS = (
    ("depsgraph_update_post", _scene_changed),
    ("frame_change_post", _scene_changed),
    ("load_post", _file_loaded),
)


def register() -> None:
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def unregister() -> None:
    if bpy.app.timers.is_registered(_look):
        bpy.app.timers.unregister(_look)
    for name, handler in _HANDLERS:
        handlers = getattr(bpy.app.handlers, name)
        if handler in handlers:
            handlers.remove(handler)
    forget()
