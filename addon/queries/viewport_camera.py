# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps Blender's own camera in step with the lens, so that the camera view frames what will be photographed.

Only cameras whose lens was set up are touched: choosing the engine alone changes nothing. Nothing is written while
drawing or rendering.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

import bpy
from bpy.app.handlers import persistent

from petzval.description import OF_LENS_FILE

from ..engine import ENGINE
from ..export import camera as camera_export
from . import lens_info

# Writing a value that is there already would only mark the file as changed.
_SAME = 1e-5


_switches = 0


@contextlib.contextmanager
def switching() -> Iterator[None]:
    """While Through the Lens sets the model, which then is nobody's choice."""
    global _switches
    _switches += 1
    try:
        yield
    finally:
        _switches -= 1


def is_switching() -> bool:
    """Whether the model is being set by Through the Lens."""
    return _switches > 0


def switched(camera: bpy.types.Camera, scene: bpy.types.Scene | None) -> None:
    """The user has turned Through the Lens: what is seen stays what it was."""
    settings = camera.petzval
    if settings.model in OF_LENS_FILE:
        lens_changed(camera, scene)
    elif scene is not None and not camera.library and settings.match_viewport:
        holder = camera_object(camera, scene)
        if holder is not None:
            match(holder, scene, settings.lens_model)


def lens_changed(camera: bpy.types.Camera, scene: bpy.types.Scene | None) -> None:
    """A lens setting was changed by the user."""
    if not camera.petzval.in_step:
        camera.petzval.in_step = True
    follow(camera, scene)


def follow(camera: bpy.types.Camera, scene: bpy.types.Scene | None) -> None:
    """Brings Blender's camera in step where that is wanted and possible."""
    settings = camera.petzval
    if scene is None or camera.library or settings.model not in OF_LENS_FILE or not settings.match_viewport:
        return
    holder = camera_object(camera, scene)
    if holder is not None:
        match(holder, scene)


def match(holder: bpy.types.Object, scene: bpy.types.Scene, model: str | None = None) -> str:
    """Sets the camera so that it frames the lens's picture; returns the engine's complaint where it cannot. `model`: instead of
    the camera's own."""
    info = lens_info.of_camera(holder, scene, model=model)
    if "error" in info:
        return info["error"]
    camera = holder.data
    wanted = {"lens": info["viewport_focal_length_mm"]}
    if camera.petzval.film_mode == "SIZE":
        if camera.sensor_fit != "HORIZONTAL":
            camera.sensor_fit = "HORIZONTAL"
        wanted["sensor_width"] = info["picture_width_mm"]
    # After the sensor's fit is as it will be.
    size = camera_export.resolution(scene.render)
    shift = camera_export.blender_shift(info["viewport_shift"], camera, scene.render, *size)
    wanted["shift_x"], wanted["shift_y"] = shift
    for name, value in wanted.items():
        if abs(getattr(camera, name) - value) > _SAME * max(abs(value), _SAME):
            setattr(camera, name, value)
    return ""


def camera_object(camera: bpy.types.Camera, scene: bpy.types.Scene) -> bpy.types.Object | None:
    """An object of the scene with this camera: the scene's own camera if it has it."""
    if scene.camera is not None and scene.camera.data == camera:
        return scene.camera
    return next((holder for holder in scene.objects if holder.data == camera), None)


@persistent
def _scene_changed(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None) -> None:
    """Focus objects move, sensors are set in Blender's own panels, frames change."""
    if depsgraph is None or depsgraph.mode != "VIEWPORT" or scene.render.engine != ENGINE:
        return
    holder = scene.camera
    if holder is None or holder.type != "CAMERA" or not holder.data.petzval.in_step:
        return
    follow(holder.data, scene)


_HANDLERS = ("depsgraph_update_post", "frame_change_post")


def register() -> None:
    for name in _HANDLERS:
        getattr(bpy.app.handlers, name).append(_scene_changed)


def unregister() -> None:
    for name in _HANDLERS:
        handlers = getattr(bpy.app.handlers, name)
        if _scene_changed in handlers:
            handlers.remove(_scene_changed)
    lens_info.forget()
