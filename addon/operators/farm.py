# SPDX-License-Identifier: GPL-3.0-or-later
"""Render > Render on Farm: plans a job of the file, hands it to the farm, and shows the picture as it grows."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import bpy

from ..engine import ENGINE
from ..render.farming import Asked, FarmError, FarmRun

_STEP_S = 0.25
_ENGINES = (
    ("LOCAL", "This Machine", "Several parts at a time on this machine"),
    ("SLURM", "Slurm", "Sends an array job by sbatch"),
    (
        "FLAMENCO",
        "Flamenco",
        "Hands the job to the Manager, which has the job type petzval-farm.js in its folder scripts",
    ),
    ("DASK", "Dask", "On the workers of a Dask cluster"),
    ("OPENJD", "OpenJD", "Writes a template for Deadline Cloud or OpenCue, and shows parts as they come"),
    ("SHELL", "Shell", "By the script run.sh of the job's folder"),
)


def _show(picture: Path) -> None:
    """Shows a merged picture in the image editors that show none of another file."""
    path = str(picture)
    image = next((one for one in bpy.data.images if bpy.path.abspath(one.filepath) == path), None)
    if image is None:
        image = bpy.data.images.load(path)
    else:
        image.reload()
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "IMAGE_EDITOR":
                space = area.spaces.active
                if space.image is None or space.image == image or space.image.type == "RENDER_RESULT":
                    space.image = image
                area.tag_redraw()


class PETZVAL_OT_render_on_farm(bpy.types.Operator):
    """Render this file on several machines, to the bits of one. Esc stops; the same folder goes on from there"""

    bl_idname = "petzval.render_on_farm"
    bl_label = "Render on Farm"

    engine: bpy.props.EnumProperty(name="Farm", items=_ENGINES)
    folder: bpy.props.StringProperty(
        name="Job Folder",
        description="A new folder, which all machines see; one with a job goes on",
        subtype="DIR_PATH",
        default="//farm",
    )
    parts: bpy.props.IntProperty(name="Parts", description="Of each picture", default=8, min=1, max=100_000)
    is_animation: bpy.props.BoolProperty(name="Animation", description="All frames of the scene's range")
    at_a_time: bpy.props.IntProperty(name="At a Time", description="Parts on this machine", default=2, min=1, max=256)
    address: bpy.props.StringProperty(
        name="Address",
        description="Of Flamenco's Manager, http://manager:8080, or of Dask's scheduler, tcp://host:8786",
    )

    @classmethod
    def poll(cls, context):
        return context.scene.render.engine == ENGINE

    def invoke(self, context, event):
        return context.window_manager.invoke_props_dialog(self)

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        for name in ("engine", "folder", "parts", "is_animation"):
            layout.prop(self, name)
        if self.engine in ("LOCAL", "SHELL"):
            layout.prop(self, "at_a_time")
        if self.engine in ("FLAMENCO", "DASK"):
            layout.prop(self, "address")
        if bpy.data.is_dirty:
            layout.label(text="The file is saved first", icon="INFO")

    def execute(self, context):
        if not bpy.data.filepath:
            self.report({"ERROR"}, "The file was never saved: save it first, a farm renders what is on the disk")
            return {"CANCELLED"}
        if bpy.data.is_dirty:
            bpy.ops.wm.save_mainfile()
        self._run = FarmRun(self._asked(context.scene), _show)
        if bpy.app.background:
            return self._wait()
        self._timer = context.window_manager.event_timer_add(_STEP_S, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self._run.stop()
            self._end(context)
            self.report({"INFO"}, f"Stopped; {self._run.asked.folder} goes on where it was")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        try:
            self._run.advance()
        except FarmError as error:
            self._end(context)
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        context.workspace.status_text_set(f"Farm: {self._run.status}. Esc stops")
        if not self._run.is_done:
            return {"PASS_THROUGH"}
        self._end(context)
        self.report({"INFO"}, f"Rendered: {self._run.asked.folder / 'pictures'}")
        return {"FINISHED"}

    def _wait(self):
        """Goes on to the end, where there is no window."""
        try:
            while not self._run.is_done:
                self._run.advance()
                time.sleep(_STEP_S)
        except FarmError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}

    def _end(self, context) -> None:
        context.window_manager.event_timer_remove(self._timer)
        context.workspace.status_text_set(None)

    def _asked(self, scene: bpy.types.Scene) -> Asked:
        import petzval

        path = [str(Path(petzval.__file__).resolve().parent.parent), os.environ.get("PYTHONPATH", "")]
        program = bpy.app.binary_path
        return Asked(
            command=[sys.executable, "-m", "petzval"],
            environment={"PYTHONPATH": os.pathsep.join(filter(None, path))},
            blender=["--blender", program] if program else [],
            scene=bpy.data.filepath,
            folder=Path(bpy.path.abspath(self.folder)).absolute(),
            engine=self.engine,
            parts=self.parts,
            frames=f"{scene.frame_start}-{scene.frame_end},{scene.frame_step}" if self.is_animation else "",
            at_a_time=self.at_a_time,
            address=self.address,
        )


def _draw_menu(menu, context) -> None:
    if context.scene.render.engine == ENGINE:
        menu.layout.separator()
        menu.layout.operator(PETZVAL_OT_render_on_farm.bl_idname, icon="NETWORK_DRIVE")


def register() -> None:
    bpy.utils.register_class(PETZVAL_OT_render_on_farm)
    bpy.types.TOPBAR_MT_render.append(_draw_menu)


def unregister() -> None:
    bpy.types.TOPBAR_MT_render.remove(_draw_menu)
    bpy.utils.unregister_class(PETZVAL_OT_render_on_farm)
