# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the effects of the lens without a render: the Effects panel's button."""

from __future__ import annotations

import json

import bpy

from .. import redraw
from ..data import effects
from ..export import camera as camera_export
from ..export import settings as render_settings
from ..export.report import Report
from ..native import engine
from ..render import planning, staging
from .common import result_of


def plan(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> dict:
    """The plan of a scene as the viewport holds it; raises the errors of a render. What the lens does while the shutter is
    open is measured at a render alone."""
    native = engine()
    report = Report()
    width, height = camera_export.resolution(scene.render)
    camera = staging.camera(scene, width, height, report)
    settings = render_settings.describe(scene, width, height)
    builder = native.SceneBuilder()
    staging.fill(builder, depsgraph, camera, (width, height), report)
    stage = builder.build(staging.place(camera), settings.threads, None)
    if camera.focus.autofocus is not None:
        camera, _ = staging.focus(native, stage, camera, width, height)
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
        found = result_of(self, lambda: plan(context.scene, context.evaluated_depsgraph_get()))
        if found is None:
            return {"CANCELLED"}
        planning.keep(context.scene.name, found)
        redraw.properties()
        return {"FINISHED"}


def register() -> None:
    bpy.utils.register_class(PETZVAL_OT_plan_effects)


def unregister() -> None:
    bpy.utils.unregister_class(PETZVAL_OT_plan_effects)
