# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the effects of the lens without a render: the Effects panel's button."""

from __future__ import annotations

import json

import bpy

from . import effects, export, planning, render_settings
from .description import Report, focused
from .export import aperture_mask, viewport
from .export import camera as camera_export
from .export.errors import ExportError
from .native import EngineMissing, engine


def plan(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> dict:
    """The plan of a scene as the viewport holds it; raises what a render would report. What the lens does while the shutter is
    open is measured at a render alone."""
    native = engine()
    report = Report()
    width, height = camera_export.resolution(scene.render)
    camera = camera_export.describe(scene.camera, scene, width, height, report)
    camera.aperture_mask = aperture_mask.read(scene.camera.data)
    settings = render_settings.describe(scene, width, height)
    builder = native.SceneBuilder()
    export.send_scene(depsgraph, builder, report, lambda: None, None)
    viewport.send(builder, camera, width, height)
    stage = builder.build(tuple(row[3] for row in camera.matrix_world[:3]), settings.threads, None)
    if camera.autofocus is not None:
        found = json.loads(native.autofocus_json(stage, camera, width, height, camera.autofocus))
        for name, value in focused(camera, found).items():
            setattr(camera, name, value)
    found = native.Plan(stage, camera, settings, [], **effects.wishes(scene.petzval))
    return json.loads(found.forecast(stage, camera, settings))


class PETZVAL_OT_plan_effects(bpy.types.Operator):
    """Measure what each effect of the lens would change in this picture, and decide what is simulated"""

    bl_idname = "petzval.plan_effects"
    bl_label = "Measure Effects"

    @classmethod
    def poll(cls, context):
        return context.scene.camera is not None and context.scene.camera.type == "CAMERA"

    def execute(self, context):
        try:
            found = plan(context.scene, context.evaluated_depsgraph_get())
        except (ExportError, EngineMissing) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        except engine().PetzvalError as error:
            self.report({"ERROR"}, " ".join(str(error).split()))
            return {"CANCELLED"}
        planning.keep(context.scene.name, found)
        for area in context.screen.areas if context.screen else ():
            if area.type == "PROPERTIES":
                area.tag_redraw()
        return {"FINISHED"}


def register() -> None:
    bpy.utils.register_class(PETZVAL_OT_plan_effects)


def unregister() -> None:
    bpy.utils.unregister_class(PETZVAL_OT_plan_effects)
