# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of a light, named and ordered as Cycles's."""

from __future__ import annotations

import bpy

from .mixin import PetzvalPanel, columns
from .nodes import draw_nodes


class _LightPanel(PetzvalPanel):
    bl_context = "data"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.light is not None


class PETZVAL_LIGHT_PT_light(_LightPanel, bpy.types.Panel):
    bl_label = "Light"

    def draw(self, context):
        light = context.light
        self.layout.row().prop(light, "type", expand=True)
        layout = columns(self)
        column = layout.column()
        # Temperature, exposure and normalize came with 4.5.
        if hasattr(light, "use_temperature"):
            heading = column.column(align=True, heading="Temperature")
            row = heading.row(align=True)
            row.use_property_decorate = False
            row.prop(light, "use_temperature", text="")
            part = row.row()
            part.active = light.use_temperature
            part.prop(light, "temperature", text="")
            row.prop_decorator(light, "temperature")
        column.prop(light, "color", text="Tint" if getattr(light, "use_temperature", False) else "Color")
        layout.separator()
        column = layout.column()
        column.prop(light, "energy")
        for name in ("exposure", "normalize"):
            if hasattr(light, name):
                column.prop(light, name)
        layout.separator()
        column = layout.column()
        if light.type in {"POINT", "SPOT"}:
            column.prop(light, "shadow_soft_size", text="Radius")
            column.prop(light, "use_soft_falloff")
        elif light.type == "SUN":
            column.prop(light, "angle")
        else:
            column.prop(light, "shape")
            part = column.column(align=True)
            if light.shape in {"SQUARE", "DISK"}:
                part.prop(light, "size")
            else:
                part.prop(light, "size", text="Size X")
                part.prop(light, "size_y", text="Y")


class PETZVAL_LIGHT_PT_beam_shape(_LightPanel, bpy.types.Panel):
    bl_label = "Beam Shape"
    bl_parent_id = "PETZVAL_LIGHT_PT_light"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.light.type in {"SPOT", "AREA"}

    def draw(self, context):
        column, light = columns(self).column(), context.light
        if light.type == "AREA":
            column.prop(light, "spread", text="Spread")
            return
        column.prop(light, "spot_size", text="Angle")
        column.prop(light, "spot_blend", text="Blend", slider=True)
        column.prop(light, "show_cone")


class PETZVAL_LIGHT_PT_settings(_LightPanel, bpy.types.Panel):
    bl_label = "Settings"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        column, light = columns(self).column(), context.light
        cycles = getattr(light, "cycles", None)
        if cycles is not None:
            column.prop(cycles, "max_bounces")
        column.prop(light, "use_shadow", text="Cast Shadow")
        if light.type == "AREA" and cycles is not None:
            column.prop(cycles, "is_portal", text="Portal")
            if cycles.is_portal:
                column.label(text="A portal gives no light, and does nothing here", icon="INFO")


class PETZVAL_LIGHT_PT_nodes(_LightPanel, bpy.types.Panel):
    bl_label = "Nodes"

    def draw(self, context):
        draw_nodes(columns(self), context.light, "Surface")


CLASSES = (
    PETZVAL_LIGHT_PT_light,
    PETZVAL_LIGHT_PT_beam_shape,
    PETZVAL_LIGHT_PT_settings,
    PETZVAL_LIGHT_PT_nodes,
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
