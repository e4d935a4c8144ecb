# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of the view layer."""

from __future__ import annotations

import bpy

from .. import passes
from .mixin import PetzvalPanel, columns


class PETZVAL_VIEW_LAYER_PT_passes(PetzvalPanel, bpy.types.Panel):
    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context):
        layout = columns(self)
        column = layout.column(heading="Data")
        for one in passes.DATA:
            column.prop(context.view_layer, one.switch, text=one.name)
        cycles = getattr(context.view_layer, "cycles", None)
        if cycles is not None:
            column.prop(cycles, "pass_debug_sample_count", text="Sample Count")
        column.prop(context.view_layer.petzval, "use_pass_mergeable")
        column = layout.column(heading="Cryptomatte")
        for one in passes.MATTES:
            column.prop(context.view_layer, one.switch, text=one.name.removeprefix("Crypto"))
        column.prop(context.view_layer, "pass_cryptomatte_depth", text="Levels")


class PETZVAL_VIEW_LAYER_PT_light_groups(PetzvalPanel, bpy.types.Panel):
    bl_label = "Light Groups"
    bl_context = "view_layer"
    bl_parent_id = "PETZVAL_VIEW_LAYER_PT_passes"

    def draw(self, context):
        row, layer = self.layout.row(), context.view_layer
        row.template_list("UI_UL_list", "lightgroups", layer, "lightgroups", layer, "active_lightgroup_index", rows=3)
        column = row.column(align=True)
        column.operator("scene.view_layer_add_lightgroup", icon="ADD", text="")
        column.operator("scene.view_layer_remove_lightgroup", icon="REMOVE", text="")
        column.separator()
        column.menu("VIEWLAYER_MT_lightgroup_sync", icon="DOWNARROW_HLT", text="")


class _Membership(PetzvalPanel):
    """The light group that something is in; Cycles's own panels of it are not shared."""

    bl_label = "Light Group"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and getattr(context, cls.bl_context) is not None

    def draw(self, context):
        holder = getattr(context, self.bl_context)
        columns(self).prop_search(
            holder, "lightgroup", context.view_layer, "lightgroups", text="Light Group", results_are_suggestions=True
        )


class PETZVAL_OBJECT_PT_light_group(_Membership, bpy.types.Panel):
    bl_context = "object"


class PETZVAL_WORLD_PT_light_group(_Membership, bpy.types.Panel):
    bl_context = "world"


CLASSES = (
    PETZVAL_VIEW_LAYER_PT_passes,
    PETZVAL_VIEW_LAYER_PT_light_groups,
    PETZVAL_OBJECT_PT_light_group,
    PETZVAL_WORLD_PT_light_group,
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
