# SPDX-License-Identifier: GPL-3.0-or-later
"""The lens report: the effects of the camera's lens, as a picture."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty

from petzval.description import OF_LENS_FILE

from ..drawing import lens_report, shown_pictures
from ..queries import viewport_camera
from .common import result_of, shown_camera


class PETZVAL_OT_lens_report(bpy.types.Operator):
    """Draw what the lens does as the camera is set: focal length, diaphragm, focus and film"""

    bl_idname = "petzval.lens_report"
    bl_label = "Lens Report"
    bl_options = {"REGISTER"}

    kind: EnumProperty(name="Report", items=lens_report.KINDS)

    @classmethod
    def poll(cls, context):
        camera = shown_camera(context)
        return camera is not None and camera.petzval.model in OF_LENS_FILE

    @classmethod
    def description(cls, _context, properties):
        return next(words for kind, _, words in lens_report.KINDS if kind == properties.kind)

    def execute(self, context):
        camera = shown_camera(context)
        holder = viewport_camera.camera_object(camera, context.scene)
        if holder is None:
            self.report({"ERROR"}, f"Camera '{camera.name}' is not in this scene: link an object with it")
            return {"CANCELLED"}
        pixels = result_of(self, lambda: lens_report.picture(holder, context.scene, self.kind))
        if pixels is None:
            return {"CANCELLED"}
        title = next(name for kind, name, _ in lens_report.KINDS if kind == self.kind)
        image = shown_pictures.keep(f"Lens Report: {title}", pixels)
        if not shown_pictures.show(context, image):
            self.report({"INFO"}, f"Drawn as the image '{image.name}'")
        return {"FINISHED"}


def register() -> None:
    bpy.utils.register_class(PETZVAL_OT_lens_report)


def unregister() -> None:
    bpy.utils.unregister_class(PETZVAL_OT_lens_report)
