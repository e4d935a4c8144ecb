# SPDX-License-Identifier: GPL-3.0-or-later
"""What autofocus would find, for the panels: asked with Blender's own rays, remembered, never while a panel draws.

A render asks the engine's own scene; here Blender's ray casting stands for it, so that nothing has to be exported: it sees
what the viewport holds.
"""

from __future__ import annotations

import json
import os
import time
from dataclasses import dataclass
from typing import Any

import bpy
from bpy.app.handlers import persistent
from mathutils import Vector

from . import redraw
from .description import Report
from .export import aperture_mask
from .export import camera as camera_export
from .export.errors import ExportError
from .native import EngineMissing, engine

# So long nothing may have changed before it is looked again: less, and a slider that is dragged would stutter.
_QUIET_S = 0.3
# A scene that takes long to look at is looked at after so many times as long.
_QUIET_FOR_SLOW = 4.0
# While a render runs, until it is asked again.
_BUSY_S = 1.0
# Past something that a render does not show, and how often; the step in parts of the way to it.
_STEP = 1e-5
_MOST_SKIPPED = 64
# One for each camera that was shown.
_REMEMBERED = 16


@dataclass
class Finding:
    """What was found for a camera, and whether the scene is still as it was then."""

    #: The engine's `autofocus_by_json`, with what was met: `object_name`, and `subject_mm` from the camera along its axis.
    #: Where it fails only `error`, one line.
    answer: dict[str, Any]
    is_current: bool


@dataclass
class _Kept:
    answer: dict[str, Any]
    asked: tuple
    revision: int


@dataclass
class _Lookout:
    """What is to be looked at next, and since when nothing has changed."""

    wanted: tuple[str, str, tuple[str, str | None]] | None = None
    revision: int = 0
    changed_at: float = 0.0
    quiet_s: float = _QUIET_S


_kept: dict[tuple, _Kept] = {}
_lookout = _Lookout()


def find(
    holder: bpy.types.Object,
    scene: bpy.types.Scene,
    depsgraph: bpy.types.Depsgraph,
    *,
    point: tuple[float, float] | None = None,
    place: Vector | None = None,
) -> dict[str, Any]:
    """Looks now; takes about a tenth of a second. At the camera's own point of the picture, or another; `place`, of the world, is taken
    for what is there."""
    width, height = camera_export.resolution(scene.render)
    met: list[str] = []

    def distance_to(origin: tuple, direction: tuple) -> float | None:
        if place is not None:
            met[:] = [""]
            distance = (place - Vector(origin)).dot(Vector(direction))
            return distance if distance > 0.0 else None
        distance, name = nearest(scene, depsgraph, Vector(origin), Vector(direction))
        met[:] = [name]
        return distance

    try:
        camera = camera_export.describe(holder, scene, width, height, Report())
        camera.aperture_mask = aperture_mask.read(holder.data)
        at = tuple(holder.data.petzval.autofocus_point) if point is None else point
        native = engine()
    except (ExportError, EngineMissing) as error:
        return {"error": str(error)}
    try:
        answer = json.loads(native.autofocus_by_json(camera, width, height, at, distance_to))
    except native.PetzvalError as error:
        return {"error": " ".join(str(error).split())}
    subject = answer["subject_world"]
    if subject is None:
        return answer | {"object_name": "", "subject_mm": None}
    along = (holder.matrix_world.inverted_safe() @ Vector(subject)).z * holder.matrix_world.to_scale().z
    return answer | {"object_name": met[0], "subject_mm": -along * camera.scale_mm_per_unit[2]}


def nearest(
    scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph, origin: Vector, direction: Vector
) -> tuple[float | None, str]:
    """How far it is to what a camera ray meets in the render, and its name."""
    start = origin
    for _ in range(_MOST_SKIPPED):
        is_hit, place, _normal, _index, what, _matrix = scene.ray_cast(depsgraph, start, direction)
        if not is_hit:
            break
        distance = (place - origin).dot(direction)
        if what.visible_camera and not what.hide_render:
            return distance, what.name
        start = origin + direction * (distance * (1.0 + _STEP))
    return None, ""


def for_panel(holder: bpy.types.Object, scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> Finding | None:
    """What is known of the camera; has it looked at soon where that is nothing or out of date."""
    kept = _kept.get(_key(holder, scene))
    if redraw.is_rendering():
        # As for the lens's data: nothing is asked meanwhile.
        return None if kept is None else Finding(kept.answer, is_current=False)
    is_current = kept is not None and kept.revision == _lookout.revision and kept.asked == _asked(holder, scene)
    if not is_current:
        library = holder.library.filepath if holder.library else None
        _lookout.wanted = (scene.name, view_layer.name, (holder.name, library))
        if not bpy.app.timers.is_registered(_look):
            bpy.app.timers.register(_look, first_interval=_lookout.quiet_s)
    return None if kept is None else Finding(kept.answer, is_current)


def _key(holder: bpy.types.Object, scene: bpy.types.Scene) -> tuple:
    return scene.name, holder.name_full


def _asked(holder: bpy.types.Object, scene: bpy.types.Scene) -> tuple:
    """All of the question but the scene's objects."""
    width, height = camera_export.resolution(scene.render)
    mask = holder.data.petzval.aperture_mask
    try:
        camera = camera_export.describe(holder, scene, width, height, Report())
        changed = os.stat(camera.lens_path).st_mtime_ns
    except (ExportError, OSError) as error:
        return (str(error),)
    return repr(camera), width, height, changed, mask.name_full if mask else ""


def _look() -> float | None:
    """The timer: looks once nothing has changed for a while; gives the seconds until it is to be called again."""
    wait = _lookout.changed_at + _lookout.quiet_s - time.monotonic()
    if wait > 0.0:
        return wait
    if bpy.app.is_job_running("RENDER"):
        return _BUSY_S
    wanted, _lookout.wanted = _lookout.wanted, None
    if wanted is not None:
        _look_at(*wanted)
    return None


def _look_at(scene_name: str, layer_name: str, holder_name: tuple[str, str | None]) -> None:
    # By name: what a timer keeps may have gone meanwhile.
    scene, holder = bpy.data.scenes.get(scene_name), bpy.data.objects.get(holder_name)
    layer = scene.view_layers.get(layer_name) if scene is not None else None
    depsgraph = layer.depsgraph if layer is not None else None
    if holder is None or holder.type != "CAMERA" or depsgraph is None:
        return
    began = time.monotonic()
    while len(_kept) >= _REMEMBERED:
        del _kept[next(iter(_kept))]
    _kept[_key(holder, scene)] = _Kept(find(holder, scene, depsgraph), _asked(holder, scene), _lookout.revision)
    _lookout.quiet_s = max(_QUIET_S, _QUIET_FOR_SLOW * (time.monotonic() - began))
    redraw.properties()


@persistent
def _scene_changed(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None) -> None:
    if depsgraph is None or depsgraph.mode == "VIEWPORT":
        _lookout.revision += 1
        _lookout.changed_at = time.monotonic()


@persistent
def _file_loaded(_file: str) -> None:
    forget()


def forget() -> None:
    """Drops what is remembered."""
    _kept.clear()
    _lookout.wanted = None
    _lookout.quiet_s = _QUIET_S


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
