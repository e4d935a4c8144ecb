# SPDX-License-Identifier: GPL-3.0-or-later
"""The helpers of the Lens panel's buttons."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import bpy
from bpy.props import EnumProperty

from petzval.description import OF_LENS_FILE

from ..data import film_formats, lens_files
from ..export.errors import ExportError
from ..native import EngineMissing, engine
from ..queries import viewport_camera

Result = TypeVar("Result")

# Blender does not keep the strings of enum items that are made on demand.
_items: list[tuple[str, str, str]] = []
_film_list: list[tuple[str, str, str]] = []


def _shipped_items(_operator: bpy.types.Operator, _context: bpy.types.Context) -> list[tuple[str, str, str]]:
    if not _items:
        try:
            entries = lens_files.shipped()
        except EngineMissing:
            return _items
        first = [entry for entry in entries if entry["is_first_choice"]]
        for entry in [*first, *(entry for entry in entries if not entry["is_first_choice"])]:
            # The search looks at names alone.
            name = f"{entry['name']}  ·  {lens_files.in_short(entry)}"
            _items.append((lens_files.file_name(entry), name, lens_files.description(entry)))
    return _items


def _film_items(_operator: bpy.types.Operator, _context: bpy.types.Context) -> list[tuple[str, str, str]]:
    if not _film_list:
        _film_list.extend(film_formats.items())
    return _film_list


def shown_camera(context: bpy.types.Context) -> bpy.types.Camera | None:
    """The camera that is shown in the properties editor, else the scene's."""
    shown = getattr(context, "camera", None)
    if shown is not None:
        return shown
    holder = context.scene.camera
    return holder.data if holder is not None and holder.type == "CAMERA" else None


def result_of(operator: bpy.types.Operator, work: Callable[[], Result]) -> Result | None:
    """The result of the work; None where the engine or the export refused it: the operator has then reported that."""
    try:
        return work()
    except (ExportError, EngineMissing) as error:
        complaint = str(error)
    except engine().PetzvalError as error:
        complaint = " ".join(str(error).split())
    operator.report({"ERROR"}, complaint)
    return None


class PETZVAL_OT_choose_lens(bpy.types.Operator):
    """Choose one of the lenses that come with Petzval"""

    bl_idname = "petzval.choose_lens"
    bl_label = "Choose Lens"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}
    bl_property = "lens"

    lens: EnumProperty(name="Lens", items=_shipped_items)

    @classmethod
    def poll(cls, context):
        return shown_camera(context) is not None

    def invoke(self, context, _event):
        context.window_manager.invoke_search_popup(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        shown_camera(context).petzval.lens_file = self.lens
        return {"FINISHED"}


class PETZVAL_OT_choose_film(bpy.types.Operator):
    """Give the film the size of a real format"""

    bl_idname = "petzval.choose_film"
    bl_label = "Choose Film Format"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    film: EnumProperty(name="Format", items=_film_items)

    @classmethod
    def poll(cls, context):
        camera = shown_camera(context)
        return camera is not None and not camera.library

    def execute(self, context):
        settings = shown_camera(context).petzval
        settings.film_mode = "SIZE"
        settings.film_width, settings.film_height = film_formats.size_mm(self.film)
        return {"FINISHED"}


class PETZVAL_OT_match_viewport(bpy.types.Operator):
    """Set Blender's own camera so that its view frames what the lens will photograph"""

    bl_idname = "petzval.match_viewport"
    bl_label = "Match Viewport Camera"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        camera = shown_camera(context)
        return camera is not None and not camera.library and camera.petzval.model in OF_LENS_FILE

    def execute(self, context):
        camera = shown_camera(context)
        holder = viewport_camera.camera_object(camera, context.scene)
        if holder is None:
            self.report({"ERROR"}, f"Camera '{camera.name}' is not in this scene: link an object with it")
            return {"CANCELLED"}
        complaint = viewport_camera.match(holder, context.scene)
        if complaint:
            self.report({"ERROR"}, complaint)
            return {"CANCELLED"}
        viewport_camera.mark_set_up(camera.petzval)
        return {"FINISHED"}


CLASSES = (PETZVAL_OT_choose_lens, PETZVAL_OT_choose_film, PETZVAL_OT_match_viewport)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
    _items.clear()
    _film_list.clear()
