# SPDX-License-Identifier: GPL-3.0-or-later
"""The overlay of a lens in 3D views: the surface of sharp focus with its limits, and the entrance pupil."""

from __future__ import annotations

import json
import math
from typing import Any

import bpy
import gpu
from gpu_extras.batch import batch_for_shader
from mathutils import Matrix, Vector

from petzval.description import OF_LENS_FILE, changed, focused

from ..engine import ENGINE
from ..export import camera as camera_export
from ..export.errors import ExportError
from ..export.report import Report
from ..native import EngineMissing, engine

#: Points over the picture's width and height: a surface of focus is smooth.
COLUMNS, ROWS = 13, 9
#: Colours with their opacity.
_SHARP, _NEAR, _FAR, _PUPIL = (0.2, 0.85, 0.35), (0.25, 0.6, 1.0), (1.0, 0.55, 0.2), (0.85, 0.4, 0.95)
_FILL, _LINE, _FAINT = 0.12, 0.9, 0.35
_SEGMENTS = 48
#: Blender units: farther parts are not drawn.
_FARTHEST = 1e5

_known: dict[str, tuple[Any, dict[str, Any]]] = {}
_handle: Any = None


def of_camera(holder: bpy.types.Object, scene: bpy.types.Scene) -> dict[str, Any] | None:
    """The engine's `sharpness_json` of a camera; None where there is none. Remembered until the camera is another."""
    size = camera_export.resolution(scene.render)
    try:
        camera = camera_export.describe(holder, scene, *size, Report())
        if camera.focus.autofocus is not None:
            found = _autofocus(holder, scene)
            if found is None:
                return None
            camera = changed(focused(camera, found), {"focus.autofocus": None})
        key = (camera, size, holder.data.petzval.confusion)
        known = _known.get(holder.name_full)
        if known is None or known[0] != key:
            confusion_mm = holder.data.petzval.confusion or None
            native = engine()
            try:
                answer = json.loads(native.sharpness_json(camera, *size, COLUMNS, ROWS, confusion_mm))
            except native.PetzvalError:
                answer = None
            _known[holder.name_full] = key, answer
        return _known[holder.name_full][1]
    except (ExportError, EngineMissing):
        return None


def _autofocus(holder: bpy.types.Object, scene: bpy.types.Scene) -> dict | None:
    """The answer of autofocus that the panel holds, so that overlay and panel look once for both."""
    from ..queries import autofocus

    found = autofocus.for_panel(holder, scene, bpy.context.view_layer)
    return None if found is None or "error" in found.answer else found.answer


def surface(answer: dict[str, Any], which: str) -> list[Vector | None]:
    """The places of a surface ("sharp", "near" or "far") by grid point, world space; None where it is nowhere, or infinitely far."""
    points: list[Vector | None] = []
    for one in answer["points"]:
        distance = None if one is None else one[which]
        if distance is None or not 0.0 <= distance < _FARTHEST:
            points.append(None)
        else:
            points.append(Vector(one["from"]) + distance * Vector(one["towards"]))
    return points


def _cells() -> list[tuple[int, int, int, int]]:
    corners = ((x, y) for y in range(ROWS - 1) for x in range(COLUMNS - 1))
    return [
        (y * COLUMNS + x, y * COLUMNS + x + 1, (y + 1) * COLUMNS + x + 1, (y + 1) * COLUMNS + x) for x, y in corners
    ]


def _outline() -> list[tuple[int, int]]:
    """The picture's edges, as pairs of grid points."""
    last = (ROWS - 1) * COLUMNS
    across = [(i, i + 1) for row in (0, last) for i in range(row, row + COLUMNS - 1)]
    up = [(i, i + COLUMNS) for column in (0, COLUMNS - 1) for i in range(column, last + column, COLUMNS)]
    return across + up


def _middle() -> list[tuple[int, int]]:
    """A cross through the middle."""
    row, column = (ROWS // 2) * COLUMNS, COLUMNS // 2
    across = [(i, i + 1) for i in range(row, row + COLUMNS - 1)]
    return across + [(i, i + COLUMNS) for i in range(column, column + (ROWS - 1) * COLUMNS, COLUMNS)]


def _lines(points: list[Vector | None], pairs: list[tuple[int, int]]) -> list[Vector]:
    return [points[i] for pair in pairs if all(points[j] is not None for j in pair) for i in pair]


def _triangles(points: list[Vector | None]) -> list[Vector]:
    found = []
    for a, b, c, d in _cells():
        if all(points[i] is not None for i in (a, b, c, d)):
            found += [points[i] for i in (a, b, c, a, c, d)]
    return found


def pupil(answer: dict[str, Any], holder: bpy.types.Object) -> list[Vector]:
    """The rim of the entrance pupil, pairs of points in the world; none where it is at infinity."""
    if answer["pupil"] is None:
        return []
    place = Matrix.LocRotScale(Vector(answer["pupil"]), holder.matrix_world.to_quaternion(), None)
    across, up = answer["pupil_radii"]
    turns = [math.tau * i / _SEGMENTS for i in range(_SEGMENTS)]
    rim = [place @ Vector((across * math.cos(turn), up * math.sin(turn), 0.0)) for turn in turns]
    return [point for i in range(_SEGMENTS) for point in (rim[i - 1], rim[i])]


def shown(context: bpy.types.Context) -> bpy.types.Object | None:
    """The camera whose focus is drawn in this view: the scene's."""
    scene, space = context.scene, context.space_data
    if scene.render.engine != ENGINE or not space.overlay.show_overlays:
        return None
    holder = space.camera if space.use_local_camera else scene.camera
    if holder is None or holder.type != "CAMERA" or not holder.visible_get():
        return None
    own = holder.data.petzval
    return holder if own.show_focus and own.model in OF_LENS_FILE and holder.data.type != "ORTHO" else None


def _draw() -> None:
    context = bpy.context
    holder = shown(context)
    answer = of_camera(holder, context.scene) if holder is not None else None
    if answer is None:
        return
    sharp, near, far = (surface(answer, which) for which in ("sharp", "near", "far"))
    gpu.state.blend_set("ALPHA")
    # As Blender's own overlays: what is behind something shows faintly.
    for test, strength in (("LESS_EQUAL", 1.0), ("GREATER", _FAINT)):
        gpu.state.depth_test_set(test)
        _fill(_triangles(sharp), (*_SHARP, _FILL * strength))
        _stroke(_lines(sharp, _outline() + _middle()), (*_SHARP, _LINE * strength), 1.5)
        _stroke(_lines(near, _outline()), (*_NEAR, _LINE * strength), 1.0)
        _stroke(_lines(far, _outline()), (*_FAR, _LINE * strength), 1.0)
        _stroke(pupil(answer, holder), (*_PUPIL, _LINE * strength), 2.0)
    gpu.state.depth_test_set("NONE")
    gpu.state.blend_set("NONE")


def _fill(points: list[Vector], color: tuple[float, ...]) -> None:
    if points:
        shader = gpu.shader.from_builtin("UNIFORM_COLOR")
        batch = batch_for_shader(shader, "TRIS", {"pos": points})
        shader.uniform_float("color", color)
        batch.draw(shader)


def _stroke(points: list[Vector], color: tuple[float, ...], width: float) -> None:
    if points:
        shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
        batch = batch_for_shader(shader, "LINES", {"pos": points})
        shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
        shader.uniform_float("lineWidth", width * bpy.context.preferences.system.ui_scale)
        shader.uniform_float("color", color)
        batch.draw(shader)


def register() -> None:
    global _handle
    if not bpy.app.background:
        _handle = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW")


def unregister() -> None:
    global _handle
    if _handle is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_handle, "WINDOW")
        _handle = None
    _known.clear()
