# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the cost of accuracy in this scene, as `petzval cost` does, beside Blender: its window stays alive meanwhile."""

from __future__ import annotations

import threading
import time
from typing import Any

import bpy
from bpy.props import FloatProperty, IntProperty

from .. import redraw
from ..data import effects
from ..drawing import shown_pictures
from ..drawing.lettering import Letters
from ..export import camera as camera_export
from ..export import settings as render_settings
from ..export.report import Report
from ..native import engine
from ..render import loop, staging
from .common import result_of

# How often the window is told how far it is.
_TELL_S = 0.2
_STATUS = "What accuracy costs: {text}, {part:.0%}    Esc: enough"

#: The last results, by the scene's name.
_last: dict[str, dict[str, Any]] = {}


def last(scene_name: str) -> dict[str, Any] | None:
    """The last measurement of a scene in this session."""
    return _last.get(scene_name)


def subject(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph, width: int) -> loop.Subject:
    """The scene as the viewport holds it, in a picture so many pixels wide. Objects that move while the shutter is open stand still."""
    native, report, began = engine(), Report(), time.perf_counter()
    whole = camera_export.resolution(scene.render)
    size = width, max(round(width * whole[1] / whole[0]), 1)
    camera = staging.camera(scene, *size, report)
    settings = render_settings.describe(scene, *size)
    builder = native.SceneBuilder()
    staging.fill(builder, depsgraph, camera, size, report)
    stage = builder.build(staging.place(camera), settings.threads, None)
    if camera.focus.autofocus is not None:
        camera, _ = staging.focus(native, stage, camera, *size)
    wishes = effects.wishes(scene.petzval)
    return loop.Subject(stage, camera, settings, [], wishes, None, time.perf_counter() - began)


class _Task:
    """The study in a thread of its own; nothing in it knows Blender."""

    def __init__(self, scene: bpy.types.Scene, of: loop.Subject, seconds: float) -> None:
        from petzval.cost.runs import Study

        self.scene_name = scene.name
        self.watch = loop.Watch()
        self.part, self.text, self.error = 0.0, "", ""
        self.watch.on_progress = self._told
        options = {"rounds": 0, "seconds": seconds, "exposure_stops": scene.view_settings.exposure}
        self.study = Study(options, self.watch)
        self.thread = threading.Thread(target=self._run, args=(of,), name="petzval cost", daemon=True)

    def _told(self, part: float, text: str) -> None:
        self.part, self.text = part, text

    def _run(self, of: loop.Subject) -> None:
        try:
            self.study(of)
        except Exception as error:  # said by the operator
            self.error = " ".join(str(error).split()) or type(error).__name__


class PETZVAL_OT_measure_costs(bpy.types.Operator):
    """Photograph this scene with every camera model, small, and show what each takes and how near it comes to the truth"""

    bl_idname = "petzval.measure_costs"
    bl_label = "Measure What Accuracy Costs"

    width: IntProperty(
        name="Width",
        description="Of the small picture that is taken",
        default=240,
        min=16,
        soft_max=1920,
        subtype="PIXEL",
    )
    seconds: FloatProperty(
        name="Time", description="At most, about", default=60.0, min=1.0, soft_max=600.0, subtype="TIME_ABSOLUTE"
    )

    @classmethod
    def poll(cls, context):
        holder = context.scene.camera
        if holder is None or holder.type != "CAMERA" or holder.data.petzval.model != "LENS":
            cls.poll_message_set("The scene's camera needs the model Lens")
            return False
        return True

    def invoke(self, context, _event):
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context):
        scene = context.scene
        of = result_of(self, lambda: subject(scene, context.evaluated_depsgraph_get(), self.width))
        if of is None:
            return {"CANCELLED"}
        self._task = _Task(scene, of, self.seconds)
        self._task.thread.start()
        if bpy.app.background or context.window is None:
            self._task.thread.join()
            return self._end(context)
        self._timer = context.window_manager.event_timer_add(_TELL_S, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        task = self._task
        if event.type == "ESC":
            task.watch.stop.set()
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        if task.thread.is_alive():
            context.workspace.status_text_set(_STATUS.format(text=task.text, part=task.part))
            return {"PASS_THROUGH"}
        context.window_manager.event_timer_remove(self._timer)
        context.workspace.status_text_set(None)
        return self._end(context)

    def cancel(self, _context) -> None:
        self._task.watch.stop.set()

    def _end(self, context) -> set[str]:
        task = self._task
        if task.error or task.study.found is None:
            self.report({"ERROR"} if task.error else {"INFO"}, task.error or "Stopped before anything was known")
            return {"CANCELLED"}
        found = {"scene": task.scene_name} | task.study.found
        _last[task.scene_name] = found
        from petzval.cost import page

        with Letters() as letters:
            pixels = page.picture(found, letters)
        image = shown_pictures.keep("What Accuracy Costs", pixels)
        shown_pictures.show(context, image)
        redraw.properties()
        self.report({"INFO"}, f"{len(page.cameras(found))} cameras measured: see the image '{image.name}'")
        return {"FINISHED"}


def register() -> None:
    bpy.utils.register_class(PETZVAL_OT_measure_costs)


def unregister() -> None:
    bpy.utils.unregister_class(PETZVAL_OT_measure_costs)
    _last.clear()
