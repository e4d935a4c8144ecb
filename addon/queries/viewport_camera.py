# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps Blender's own camera in step with the lens, so that the camera view shows the frame of the photograph.

Only cameras whose lens was set up are touched, and they are put back as they were while another engine is chosen. Nothing is written
while drawing or rendering.
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


#: The version of the defaults of a camera's settings: 0.1 had others, and no number.
SETTINGS_VERSION = 2

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
    """True while Through the Lens is setting the model."""
    return _switches > 0


def switched(camera: bpy.types.Camera, scene: bpy.types.Scene | None) -> None:
    """Handles a change of Through the Lens by the user: the view stays the same."""
    settings = camera.petzval
    if settings.model in OF_LENS_FILE:
        lens_changed(camera, scene)
    elif scene is not None and not camera.library and settings.match_viewport and settings.focal_mode != "BLENDER":
        holder = camera_object(camera, scene)
        if holder is not None:
            match(holder, scene, settings.lens_model)


def lens_changed(camera: bpy.types.Camera, scene: bpy.types.Scene | None) -> None:
    """A lens setting was changed by the user."""
    mark_set_up(camera.petzval)
    follow(camera, scene)


def mark_set_up(settings: bpy.types.PropertyGroup) -> None:
    """Keeps in the file that the lens was set up, and by which defaults."""
    if not settings.in_step:
        settings.in_step = True
    if settings.version != SETTINGS_VERSION:
        settings.version = SETTINGS_VERSION


def follow(camera: bpy.types.Camera, scene: bpy.types.Scene | None) -> None:
    """Brings Blender's camera in step where that is wanted and possible."""
    settings = camera.petzval
    if scene is None or camera.library or settings.model not in OF_LENS_FILE or not settings.match_viewport:
        return
    if settings.focal_mode == "BLENDER":
        # The lens follows Blender's camera.
        restore(camera)
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
    _keep(camera)
    wanted = {"lens": info["viewport_focal_length_mm"]}
    if camera.petzval.film_mode != "SENSOR":
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


def _keep(camera: bpy.types.Camera) -> None:
    """Remembers Blender's own camera before it follows the lens."""
    settings = camera.petzval
    if not settings.blender_sensor_fit:
        settings.blender_camera = (camera.lens, camera.sensor_width, camera.shift_x, camera.shift_y)
        settings.blender_sensor_fit = camera.sensor_fit


def restore(camera: bpy.types.Camera) -> None:
    """Restores Blender's own camera to its state before it followed the lens."""
    settings = camera.petzval
    if camera.library or not settings.blender_sensor_fit:
        return
    camera.lens, camera.sensor_width, camera.shift_x, camera.shift_y = settings.blender_camera
    camera.sensor_fit = settings.blender_sensor_fit
    settings.blender_sensor_fit = ""


def engine_changed(scene: bpy.types.Scene) -> None:
    """The user has chosen an engine: its cameras follow their lenses under Petzval alone."""
    for camera in {holder.data for holder in scene.objects if holder.type == "CAMERA"}:
        if scene.render.engine != ENGINE:
            restore(camera)
        elif camera.petzval.in_step:
            follow(camera, scene)


def _engine_of_any_scene_changed() -> None:
    for scene in bpy.data.scenes:
        engine_changed(scene)


def camera_object(camera: bpy.types.Camera, scene: bpy.types.Scene) -> bpy.types.Object | None:
    """An object of the scene with this camera: the scene's own camera if it has it."""
    if scene.camera is not None and scene.camera.data == camera:
        return scene.camera
    return next((holder for holder in scene.objects if holder.data == camera), None)


@persistent
def _scene_changed(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None) -> None:
    """Focus objects move, sensors are set in Blender's own panels, frames change."""
    if depsgraph is None or depsgraph.mode != "VIEWPORT":
        return
    holder = scene.camera
    if holder is None or holder.type != "CAMERA" or not holder.data.petzval.in_step:
        return
    if scene.render.engine != ENGINE:
        restore(holder.data)
    else:
        follow(holder.data, scene)


@persistent
def _file_opened(_path: str) -> None:
    """Cameras that versions before 0.2 have set up: theirs was one lens as published, unless another was chosen."""
    for camera in bpy.data.cameras:
        settings = camera.petzval
        if settings.in_step and settings.version < SETTINGS_VERSION:
            settings.version = SETTINGS_VERSION
            if not settings.is_property_set("focal_mode"):
                settings.focal_mode = "PUBLISHED"
            if not settings.is_property_set("lens_file"):
                settings.lens_file = _LENS_OF_0_1
    _listen()


def _listen() -> None:
    """Has Blender tell when the engine is changed; the subscription is lost when a file is opened."""
    bpy.msgbus.clear_by_owner(_OWNER)
    key = (bpy.types.RenderSettings, "engine")
    bpy.msgbus.subscribe_rna(key=key, owner=_OWNER, args=(), notify=_engine_of_any_scene_changed)


_LENS_OF_0_1 = "wide-angle-smith-f3.4.lens"
_OWNER = object()
_HANDLERS = {
    "depsgraph_update_post": _scene_changed,
    "frame_change_post": _scene_changed,
    "load_post": _file_opened,
}


def register() -> None:
    for name, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, name).append(handler)
    _listen()


def unregister() -> None:
    bpy.msgbus.clear_by_owner(_OWNER)
    for name, handler in _HANDLERS.items():
        handlers = getattr(bpy.app.handlers, name)
        if handler in handlers:
            handlers.remove(handler)
    lens_info.forget()
