# SPDX-License-Identifier: GPL-3.0-or-later
"""The autofocus of panels: asked with Blender's own rays, remembered, never while a panel draws.

A render asks the engine's own scene; here Blender's ray casting stands for it, so that nothing has to be exported: it sees
the viewport's state of the scene.
"""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import Any

import bpy
from mathutils import Vector

from ..export import aperture_mask
from ..export import camera as camera_export
from ..export.errors import ExportError
from ..export.report import Report
from ..native import EngineMissing, engine
from .lookout import Lookout

# Past something that a render does not show, and how often; the step in parts of the way to it.
_STEP = 1e-5
_MOST_SKIPPED = 64


@dataclass
class Finding:
    """The answer of autofocus for a camera, and whether the scene is still as it was then."""

    #: The engine's `autofocus_by_json`, with the hit: `object_name`, and `subject_mm` from the camera along its axis.
    #: Where it fails only `error`, one line.
    answer: dict[str, Any]
    is_current: bool


def find(
    holder: bpy.types.Object,
    scene: bpy.types.Scene,
    depsgraph: bpy.types.Depsgraph,
    *,
    point: tuple[float, float] | None = None,
    place: Vector | None = None,
) -> dict[str, Any]:
    """Looks now; takes about a tenth of a second. At the camera's own point of the picture, or another; `place`, of the world, is taken
    for the target."""
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
        camera = aperture_mask.added(camera_export.describe(holder, scene, width, height, Report()), holder.data)
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
    """The distance to the first object that a camera ray hits in the render, and the object's name; None and empty without a hit."""
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
    """The answer that is known of the camera; looks at the scene soon where there is none or it is out of date."""
    known = LOOKOUT.for_panel(holder, scene, view_layer)
    return None if known is None else Finding(*known)


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


LOOKOUT = Lookout(find, _asked)


def forget() -> None:
    """Drops the remembered answers."""
    LOOKOUT.forget()


def register() -> None:
    LOOKOUT.register()


def unregister() -> None:
    LOOKOUT.unregister()
