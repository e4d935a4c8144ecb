# SPDX-License-Identifier: GPL-3.0-or-later
"""The buttons of the Focus panel."""

from __future__ import annotations

from math import degrees

import bpy

from petzval.description import OF_LENS_FILE

from ..export import camera as camera_export
from ..queries import autofocus, sharp_points, viewport_camera
from .common import result_of, shown_camera

#: The three settings of a camera that name the objects to be sharp.
SHARP_OBJECTS = ("sharp_object_1", "sharp_object_2", "sharp_object_3")


class LensOperator:
    """A mixin of operators for a camera of this file with a lens."""

    @classmethod
    def poll(cls, context):
        camera = shown_camera(context)
        return camera is not None and not camera.library and camera.petzval.model in OF_LENS_FILE

    def holder(self, context) -> bpy.types.Object | None:
        """The camera's object; complains where there is none."""
        camera = shown_camera(context)
        holder = viewport_camera.camera_object(camera, context.scene)
        if holder is None:
            self.report({"ERROR"}, f"Camera '{camera.name}' is not in this scene: link an object with it")
        return holder


class PETZVAL_OT_focus_here(LensOperator, bpy.types.Operator):
    """Keep what autofocus finds now as a plain focus distance, which no longer changes with the scene"""

    bl_idname = "petzval.focus_here"
    bl_label = "Focus Here"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        holder = self.holder(context)
        if holder is None:
            return {"CANCELLED"}
        found = autofocus.find(holder, context.scene, context.evaluated_depsgraph_get())
        if "error" in found:
            self.report({"ERROR"}, found["error"])
            return {"CANCELLED"}
        self.report({"INFO"}, keep(holder.data, context.scene, found))
        return {"FINISHED"}


def keep(camera: bpy.types.Camera, scene: bpy.types.Scene, found: dict) -> str:
    """Writes the focus found into the settings, and reports their new values."""
    own, distance_mm = camera.petzval, found["focus_scale_mm"]
    if distance_mm is None:
        own.focus_mode = "INFINITY"
        return "Focused at infinity"
    if distance_mm <= 0.0:
        # What is farthest is sharpest with the film a little before the focal plane: no distance says that.
        own.focus_mode, own.film_distance = "FILM", found["film_distance_mm"]
        return f"Film at {found['film_distance_mm']:.3f} mm, a little beyond infinity"
    own.focus_mode = "CAMERA"
    camera.dof.focus_object = None
    camera.dof.focus_distance = distance_mm / camera_export.scale(own, scene)[2]
    return f"Focused at {distance_mm:.0f} mm"


class PETZVAL_OT_sharp_points(LensOperator, bpy.types.Operator):
    """Turn the film and set its distance so that the three objects (their origins) are sharp at once"""

    bl_idname = "petzval.sharp_points"
    bl_label = "Make Sharp"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        if not super().poll(context):
            return False
        own = shown_camera(context).petzval
        if any(getattr(own, name) is None for name in SHARP_OBJECTS):
            cls.poll_message_set("Choose three objects first")
            return False
        return True

    def execute(self, context):
        holder = self.holder(context)
        if holder is None:
            return {"CANCELLED"}
        own, depsgraph = holder.data.petzval, context.evaluated_depsgraph_get()
        objects = [getattr(own, name).evaluated_get(depsgraph) for name in SHARP_OBJECTS]
        points = [one.matrix_world.translation for one in objects]
        film = result_of(self, lambda: sharp_points.solve(holder, context.scene, points))
        if film is None:
            return {"CANCELLED"}
        sharp_points.apply(holder.data, film)
        tilt, swing = degrees(film["tilt_rad"]), degrees(film["swing_rad"])
        self.report({"INFO"}, f"Tilt {tilt:.2f}°, swing {swing:.2f}°; the largest spot is {film['rms_spot_mm']:.3f} mm")
        return {"FINISHED"}


class PETZVAL_OT_sharp_from_selection(LensOperator, bpy.types.Operator):
    """Take the three objects that are selected, other than this camera"""

    bl_idname = "petzval.sharp_from_selection"
    bl_label = "Take Selected"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        camera = shown_camera(context)
        chosen = [one for one in context.selected_objects if one.data is None or one.data != camera]
        if len(chosen) != len(SHARP_OBJECTS):
            self.report({"ERROR"}, f"Select three objects beside the camera; {len(chosen)} are selected")
            return {"CANCELLED"}
        for name, one in zip(SHARP_OBJECTS, chosen, strict=True):
            setattr(camera.petzval, name, one)
        return {"FINISHED"}


CLASSES = (PETZVAL_OT_focus_here, PETZVAL_OT_sharp_points, PETZVAL_OT_sharp_from_selection)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
