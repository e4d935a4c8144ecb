# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of a render's results: Last Render, and Messages with their subjects."""

from __future__ import annotations

import bpy

from petzval.description import OF_LENS_FILE

from ..queries import lens_info
from ..render import messages, statistics
from .camera_parts import lines_of
from .mixin import PetzvalPanel

# More would fill the panel.
_MOST_MESSAGES = 24
#: The icons by the kind of a message's subject.
_ICONS = {
    "object": "OBJECT_DATA",
    "material": "MATERIAL",
    "light": "LIGHT",
    "lamp": "LIGHT",
    "camera": "CAMERA_DATA",
    "image": "IMAGE_DATA",
    "world": "WORLD",
    "mesh": "MESH_DATA",
    "scene": "SCENE_DATA",
}
_SELECTED = {"object", "material", "light", "lamp", "camera", "mesh", "curves", "volume", "points"}


class _RenderPanel(PetzvalPanel):
    bl_context = "render"


class PETZVAL_RENDER_PT_last(_RenderPanel, bpy.types.Panel):
    bl_label = "Last Render"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and statistics.last(context.scene.name) is not None

    def draw(self, context):
        render = statistics.last(context.scene.name)
        for line in render.lines():
            self.layout.label(text=line)


class PETZVAL_RENDER_PT_messages(_RenderPanel, bpy.types.Panel):
    bl_label = "Messages"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and bool(_messages(context))

    def draw(self, context):
        found = _messages(context)
        for message in found[:_MOST_MESSAGES]:
            row = self.layout.row()
            column = row.column(align=True)
            for number, line in enumerate(lines_of(context, message.text)):
                column.label(text=line, icon="BLANK1" if number else _ICONS.get(message.kind, "INFO"))
            if message.kind in _SELECTED:
                choose = row.operator("petzval.select_named", text="", icon="RESTRICT_SELECT_OFF", emboss=False)
                choose.kind, choose.name = message.kind, message.name
        if len(found) > _MOST_MESSAGES:
            self.layout.label(text=f"{len(found) - _MOST_MESSAGES} more", icon="BLANK1")


def _messages(context) -> list[messages.Message]:
    """The messages of the scene, and the notes on its camera's lens that no render has told."""
    found = messages.all_of(context.scene.name)
    told = {message.text for message in found}
    return found + [messages.of_text(note) for note in _notes_on_lens(context) if note not in told]


def _notes_on_lens(context) -> list[str]:
    """The notes on the lens: rows of its file that could not be used, and glasses that are not known for all light."""
    holder = context.scene.camera
    if holder is None or holder.type != "CAMERA" or holder.data.petzval.model not in OF_LENS_FILE:
        return []
    info = lens_info.for_panel(holder, context.scene)
    return [*info.get("remarks", []), *info.get("beyond_range", [])]


CLASSES = (PETZVAL_RENDER_PT_last, PETZVAL_RENDER_PT_messages)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
