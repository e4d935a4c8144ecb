# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of a material, named and ordered as Cycles's."""

from __future__ import annotations

import bpy

from .mixin import PetzvalPanel, columns
from .nodes import draw_nodes


class _MaterialPanel(PetzvalPanel):
    bl_context = "material"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.material is not None and context.material.grease_pencil is None


class PETZVAL_MATERIAL_PT_surface(_MaterialPanel, bpy.types.Panel):
    bl_label = "Surface"

    def draw(self, context):
        layout, material = columns(self), context.material
        if not draw_nodes(layout, material, "Surface"):
            layout.prop(material, "diffuse_color", text="Base Color")
            layout.prop(material, "metallic")
            layout.prop(material, "specular_intensity", text="Specular")
            layout.prop(material, "roughness")


class _WithNodes(_MaterialPanel):
    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.material.node_tree is not None


class PETZVAL_MATERIAL_PT_volume(_WithNodes, bpy.types.Panel):
    bl_label = "Volume"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        draw_nodes(columns(self), context.material, "Volume")


class PETZVAL_MATERIAL_PT_displacement(_WithNodes, bpy.types.Panel):
    bl_label = "Displacement"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        draw_nodes(columns(self), context.material, "Displacement")


class PETZVAL_MATERIAL_PT_settings(_MaterialPanel, bpy.types.Panel):
    bl_label = "Settings"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = columns(self)
        layout.use_property_decorate = False
        layout.prop(context.material, "pass_index")
        layout.prop(context.material, "displacement_method", text="Displacement")
        if hasattr(context.material, "use_transparent_shadow"):
            layout.prop(context.material, "use_transparent_shadow", text="Transparent Shadows")
        if hasattr(context.material, "cycles"):
            layout.prop(context.material.cycles, "use_bump_map_correction")


CLASSES = (
    PETZVAL_MATERIAL_PT_surface,
    PETZVAL_MATERIAL_PT_volume,
    PETZVAL_MATERIAL_PT_displacement,
    PETZVAL_MATERIAL_PT_settings,
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
