# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of an object, named and ordered as Cycles's."""

from __future__ import annotations

import bpy

from .mixin import PetzvalPanel, columns

_SHAPES = {"MESH", "CURVE", "SURFACE", "FONT", "META", "VOLUME", "POINTCLOUD", "CURVES"}


class _ObjectPanel(PetzvalPanel):
    bl_context = "object"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.object is not None


def _is_seen(one: bpy.types.Object, kinds: set[str]) -> bool:
    return one.type in kinds or (one.instance_type == "COLLECTION" and one.instance_collection is not None)


class PETZVAL_OBJECT_PT_motion_blur(_ObjectPanel, bpy.types.Panel):
    bl_label = "Motion Blur"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        # Cycles keeps it.
        return (
            super().poll(context)
            and _is_seen(context.object, {*_SHAPES, "CAMERA"})
            and hasattr(context.object, "cycles")
        )

    def draw_header(self, context):
        self.layout.active = context.scene.render.use_motion_blur
        self.layout.prop(context.object.cycles, "use_motion_blur", text="")

    def draw(self, context):
        layout, own = columns(self), context.object.cycles
        layout.active = context.scene.render.use_motion_blur and own.use_motion_blur
        column = layout.column()
        column.prop(own, "motion_steps", text="Steps")
        if context.object.type != "CAMERA":
            column.prop(own, "use_deform_motion", text="Deformation")
        if not context.scene.render.use_motion_blur:
            layout.label(text="Motion blur is off in the render's panels", icon="INFO")


class PETZVAL_OBJECT_PT_visibility(_ObjectPanel, bpy.types.Panel):
    bl_label = "Visibility"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, one = columns(self), context.object
        layout.prop(one, "hide_select", text="Selectable", invert_checkbox=True, toggle=False)
        if hasattr(one, "hide_surface_pick"):
            layout.prop(one, "hide_surface_pick", text="Surface Picking", invert_checkbox=True, toggle=False)
        column = layout.column(heading="Show In")
        column.prop(one, "hide_viewport", text="Viewports", invert_checkbox=True, toggle=False)
        column.prop(one, "hide_render", text="Renders", invert_checkbox=True, toggle=False)
        if _is_seen(one, _SHAPES):
            column = layout.column(heading="Mask")
            column.prop(one, "is_shadow_catcher")
            column.prop(one, "is_holdout")


class PETZVAL_OBJECT_PT_ray_visibility(_ObjectPanel, bpy.types.Panel):
    bl_label = "Ray Visibility"
    bl_parent_id = "PETZVAL_OBJECT_PT_visibility"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and _is_seen(context.object, {*_SHAPES, "LIGHT"})

    def draw(self, context):
        layout, one = columns(self), context.object
        layout.use_property_decorate = False
        column = layout.column()
        for name in ("Camera", "Diffuse", "Glossy", "Transmission", "Volume Scatter"):
            column.prop(one, f"visible_{name.lower().replace(' ', '_')}", text=name)
        if one.type != "LIGHT":
            column.prop(one, "visible_shadow", text="Shadow")


class PETZVAL_OBJECT_PT_culling(_ObjectPanel, bpy.types.Panel):
    bl_label = "Culling"
    bl_parent_id = "PETZVAL_OBJECT_PT_visibility"

    @classmethod
    def poll(cls, context):
        # Cycles keeps it.
        return super().poll(context) and _is_seen(context.object, _SHAPES) and hasattr(context.object, "cycles")

    def draw(self, context):
        layout, scene = columns(self), context.scene
        layout.use_property_decorate = False
        for name in ("use_camera_cull", "use_distance_cull"):
            row = layout.row()
            row.active = scene.render.use_simplify and getattr(scene.cycles, name)
            row.prop(context.object.cycles, name)


class PETZVAL_OBJECT_PT_shadow_terminator(_ObjectPanel, bpy.types.Panel):
    """Shadow terminator offsets that Cycles keeps, where Blender has no panel of every engine for them"""

    bl_label = "Shadow Terminator"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        is_shape = super().poll(context) and context.object.type in _SHAPES
        is_of_cycles = is_shape and not hasattr(context.object, "shadow_terminator_geometry_offset")
        return is_of_cycles and hasattr(context.object, "cycles")

    def draw(self, context):
        column, own = columns(self).column(), context.object.cycles
        column.prop(own, "shadow_terminator_geometry_offset", text="Geometry Offset")
        column.prop(own, "shadow_terminator_offset", text="Shading Offset")


class PETZVAL_OBJECT_PT_fast_gi(_ObjectPanel, bpy.types.Panel):
    bl_label = "Fast GI Approximation"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        # Cycles keeps it.
        return super().poll(context) and _is_seen(context.object, _SHAPES) and hasattr(context.object, "cycles")

    def draw(self, context):
        layout, cycles = columns(self), context.scene.cycles
        layout.active = cycles.use_fast_gi and cycles.fast_gi_method == "REPLACE"
        layout.prop(context.object.cycles, "ao_distance", text="AO Distance")


CLASSES = (
    PETZVAL_OBJECT_PT_shadow_terminator,
    PETZVAL_OBJECT_PT_motion_blur,
    PETZVAL_OBJECT_PT_visibility,
    PETZVAL_OBJECT_PT_ray_visibility,
    PETZVAL_OBJECT_PT_culling,
    PETZVAL_OBJECT_PT_fast_gi,
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
