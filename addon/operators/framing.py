# SPDX-License-Identifier: GPL-3.0-or-later
"""The lens set to the frame of Blender's own camera: the inverse of "Match Viewport Camera"."""

from __future__ import annotations

import json
from math import degrees

import bpy
from bpy.props import EnumProperty

from ..export import camera as camera_export
from ..export.report import Report
from ..native import engine
from .common import result_of
from .focus import LensOperator

_WHAT_IS_SET = ("match_viewport", "focus_mode", "focal_mode", "focal_length", "film_mode", "film_width", "film_height", "shift_x", "shift_y")  # fmt: skip


class PETZVAL_OT_frame_like_blender(LensOperator, bpy.types.Operator):
    """Set the lens so that it frames what Blender's camera frames: by the exact rays of the picture's edges, focused as Blender's
    camera is"""

    bl_idname = "petzval.frame_like_blender"
    bl_label = "Match Lens to Blender's Camera"
    bl_options = {"REGISTER", "UNDO"}

    by: EnumProperty(
        name="Change",
        items=(
            ("FOCAL_LENGTH", "Focal Length", "Scale the lens, or zoom it; the film becomes Blender's sensor"),
            ("FILM", "Film Size", "Keep the lens and take a film that sees as much"),
        ),
    )

    def execute(self, context):
        holder = self.holder(context)
        if holder is None:
            return {"CANCELLED"}
        own = holder.data.petzval
        before = {name: getattr(own, name) for name in _WHAT_IS_SET}
        # Blender's camera is what is followed now: it must stay as it is.
        own.match_viewport = False
        own.focus_mode = "CAMERA"
        if self.by == "FILM" and own.focal_mode == "BLENDER":
            # The film is to be changed, not the lens.
            own.focal_mode = "PUBLISHED"
        size = camera_export.resolution(context.scene.render)

        def ask() -> dict:
            camera = camera_export.describe(holder, context.scene, *size, Report())
            return json.loads(engine().framing_json(camera, *size, self.by))

        found = result_of(self, ask)
        if found is None:
            for name, value in before.items():
                setattr(own, name, value)
            return {"CANCELLED"}
        if found["focal_length_mm"] is not None:
            own.focal_mode, own.focal_length, own.film_mode = "LENGTH", found["focal_length_mm"], "SENSOR"
        else:
            own.film_mode = "SIZE"
            own.film_width, own.film_height = found["film_width_mm"], found["film_height_mm"]
        own.shift_x, own.shift_y = found["shift_mm"]
        self.report(*_words(found))
        return {"FINISHED"}


def _words(found: dict) -> tuple[set[str], str]:
    angle = f"{degrees(found['angle_rad']):.2f}°"
    if found["focal_length_mm"] is not None:
        said = f"Focal length {found['focal_length_mm']:.2f} mm sees {angle} as Blender's camera does"
    else:
        said = f"A film of {found['film_width_mm']:.2f} x {found['film_height_mm']:.2f} mm sees {angle} as Blender's camera does"
    if found["reaches_edges"]:
        return {"INFO"}, said
    return {"WARNING"}, f"{said}; the lens is not made for so much, its picture is dim or dark towards the edges"


def register() -> None:
    bpy.utils.register_class(PETZVAL_OT_frame_like_blender)


def unregister() -> None:
    bpy.utils.unregister_class(PETZVAL_OT_frame_like_blender)
