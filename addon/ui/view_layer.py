# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of the view layer."""

from __future__ import annotations

import bpy

from ..data import passes
from .mixin import PetzvalPanel, columns


class PETZVAL_VIEW_LAYER_PT_passes(PetzvalPanel, bpy.types.Panel):
    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context):
        pass


class _Passes(PetzvalPanel):
    """A group of passes."""

    bl_context = "view_layer"
    bl_parent_id = "PETZVAL_VIEW_LAYER_PT_passes"


def _switches(column, view_layer, some: tuple[passes.Light, ...]) -> None:
    """A row for each pass that this Blender has a switch for."""
    cycles = getattr(view_layer, "cycles", None)
    for one in some:
        holder = cycles if one.is_of_cycles else view_layer
        if hasattr(holder, one.switch):
            column.prop(holder, one.switch, text=one.name.partition(" ")[2] or one.name)


class PETZVAL_VIEW_LAYER_PT_data(_Passes, bpy.types.Panel):
    bl_label = "Data"

    def draw(self, context):
        layout, layer = columns(self), context.view_layer
        column = layout.column(heading="Include")
        for one in passes.DATA:
            column.prop(layer, one.switch, text=one.name)
        for one in passes.SURFACE:
            column.prop(layer, one.switch, text=one.name)
        column = layout.column(heading="Indexes")
        for one in passes.INDICES:
            column.prop(layer, one.switch, text=one.name.partition(" ")[0])
        cycles = getattr(layer, "cycles", None)
        if cycles is not None:
            layout.column(heading="Denoising").prop(cycles, "denoising_store_passes", text="Data for Denoise Node")
            layout.column(heading="Debug").prop(cycles, "pass_debug_sample_count", text="Sample Count")
        layout.column(heading="Files").prop(layer.petzval, "use_pass_mergeable")


class PETZVAL_VIEW_LAYER_PT_light(_Passes, bpy.types.Panel):
    bl_label = "Light"

    def draw(self, context):
        layout = columns(self)
        for first in dict.fromkeys(one.name.partition(" ")[0] for one in passes.LIGHT):
            some = tuple(one for one in passes.LIGHT if one.name.partition(" ")[0] == first)
            heading = first if len(some) > 1 else "Other" if first == "Emission" else ""
            _switches(layout.column(heading=heading, align=True), context.view_layer, some)
        column = layout.column(heading="Stray", align=True)
        for one in passes.STRAYS:
            column.prop(context.view_layer.petzval, one.switch)
        cycles = getattr(context.view_layer, "cycles", None)
        if cycles is not None:
            layout.column().prop(cycles, passes.SHADOW.switch, text=passes.SHADOW.name)


class PETZVAL_VIEW_LAYER_PT_cryptomatte(_Passes, bpy.types.Panel):
    bl_label = "Cryptomatte"

    def draw(self, context):
        layout = columns(self)
        column = layout.column(heading="Include")
        for one in passes.MATTES:
            column.prop(context.view_layer, one.switch, text=one.name.removeprefix("Crypto"))
        layout.prop(context.view_layer, "pass_cryptomatte_depth", text="Levels")


class PETZVAL_VIEW_LAYER_PT_aovs(_Passes, bpy.types.Panel):
    bl_label = "Shader AOV"

    def draw(self, context):
        row, layer = self.layout.row(), context.view_layer
        row.template_list("VIEWLAYER_UL_aov", "aovs", layer, "aovs", layer, "active_aov_index", rows=3)
        column = row.column(align=True)
        column.operator("scene.view_layer_add_aov", icon="ADD", text="")
        column.operator("scene.view_layer_remove_aov", icon="REMOVE", text="")
        if layer.active_aov is not None and not layer.active_aov.is_valid:
            self.layout.label(text="Another pass has this name", icon="ERROR")


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


class PETZVAL_VIEW_LAYER_PT_filter(PetzvalPanel, bpy.types.Panel):
    bl_label = "Filter"
    bl_context = "view_layer"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, layer = columns(self), context.view_layer
        layout.use_property_decorate = False
        column = layout.column(heading="Include")
        column.prop(layer, "use_sky", text="Environment")
        column.prop(layer, "use_solid", text="Surfaces")
        column.prop(layer, "use_strand", text="Curves")
        column.prop(layer, "use_volumes", text="Volumes")
        column = layout.column(heading="Use")
        if hasattr(layer, "use_motion_blur"):
            row = column.row()
            row.active = context.scene.render.use_motion_blur
            row.prop(layer, "use_motion_blur", text="Motion Blur")
        cycles, of_layer = getattr(context.scene, "cycles", None), getattr(layer, "cycles", None)
        if cycles is not None and hasattr(of_layer, "use_denoising"):
            row = column.row()
            row.active = cycles.use_denoising
            row.prop(of_layer, "use_denoising", text="Denoising")


class PETZVAL_VIEW_LAYER_PT_override(PetzvalPanel, bpy.types.Panel):
    bl_label = "Override"
    bl_context = "view_layer"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, layer = columns(self), context.view_layer
        layout.use_property_decorate = False
        layout.prop(layer, "material_override")
        if hasattr(layer, "world_override"):
            layout.prop(layer, "world_override")
        cycles = getattr(context.scene, "cycles", None)
        if cycles is None:
            return
        layout.prop(layer, "samples")
        row = layout.row()
        row.active = layer.samples > 0
        row.prop(cycles, "use_layer_samples", text="In All Layers")
        if layer.samples > 0 and cycles.use_layer_samples == "IGNORE":
            layout.label(text="The layers' samples are ignored", icon="INFO")


class PETZVAL_OBJECT_PT_light_group(_Membership, bpy.types.Panel):
    bl_context = "object"


class PETZVAL_WORLD_PT_light_group(_Membership, bpy.types.Panel):
    bl_context = "world"


CLASSES = (
    PETZVAL_VIEW_LAYER_PT_passes,
    PETZVAL_VIEW_LAYER_PT_data,
    PETZVAL_VIEW_LAYER_PT_light,
    PETZVAL_VIEW_LAYER_PT_cryptomatte,
    PETZVAL_VIEW_LAYER_PT_aovs,
    PETZVAL_VIEW_LAYER_PT_light_groups,
    PETZVAL_VIEW_LAYER_PT_filter,
    PETZVAL_VIEW_LAYER_PT_override,
    PETZVAL_OBJECT_PT_light_group,
    PETZVAL_WORLD_PT_light_group,
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
