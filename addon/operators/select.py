# SPDX-License-Identifier: GPL-3.0-or-later
"""Selects the object of a message."""

from __future__ import annotations

import bpy
from bpy.props import StringProperty

#: Kinds of data that objects have, by the word in a message.
_DATA = {"mesh", "curves", "curve", "light", "lamp", "camera", "volume", "points"}


def objects_of(scene: bpy.types.Scene, kind: str, name: str) -> list[bpy.types.Object]:
    """The scene's objects that a message on this is about."""
    if kind == "material":
        return [
            one
            for one in scene.objects
            if any(slot.material and slot.material.name == name for slot in one.material_slots)
        ]
    found = scene.objects.get(name)
    if found is not None:
        return [found]
    if kind in _DATA:
        return [one for one in scene.objects if one.data is not None and one.data.name == name]
    return []


class PETZVAL_OT_select_named(bpy.types.Operator):
    """Select the objects that this message is about"""

    bl_idname = "petzval.select_named"
    bl_label = "Select"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    kind: StringProperty(name="Kind", description="What it is: object, material, light", options={"SKIP_SAVE"})
    name: StringProperty(name="Name", description="What it is called", options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT"

    def execute(self, context):
        layer = context.view_layer
        found = [one for one in objects_of(context.scene, self.kind, self.name) if one.name in layer.objects]
        if not found:
            self.report({"WARNING"}, f"Nothing in this view layer is or has '{self.name}'")
            return {"CANCELLED"}
        for one in list(context.selected_objects):
            one.select_set(False)
        for one in found:
            one.select_set(True)
        layer.objects.active = found[0]
        if self.kind == "material":
            slots = [slot.material.name if slot.material else "" for slot in found[0].material_slots]
            found[0].active_material_index = slots.index(self.name)
        hidden = sum(not one.visible_get() for one in found)
        if hidden:
            self.report({"INFO"}, f"{hidden} of {len(found)} are hidden in the viewport")
        return {"FINISHED"}


def register() -> None:
    bpy.utils.register_class(PETZVAL_OT_select_named)


def unregister() -> None:
    bpy.utils.unregister_class(PETZVAL_OT_select_named)
