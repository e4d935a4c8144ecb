# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of the world, named and ordered as Cycles's."""

from __future__ import annotations

import bpy

from .mixin import PetzvalPanel, columns
from .nodes import draw_nodes


class _WorldPanel(PetzvalPanel):
    bl_context = "world"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.world is not None


class PETZVAL_WORLD_PT_surface(_WorldPanel, bpy.types.Panel):
    bl_label = "Surface"

    def draw(self, context):
        layout = columns(self)
        if not draw_nodes(layout, context.world, "Surface"):
            layout.prop(context.world, "color")


class PETZVAL_WORLD_PT_volume(_WorldPanel, bpy.types.Panel):
    bl_label = "Volume"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.world.node_tree is not None

    def draw(self, context):
        draw_nodes(columns(self), context.world, "Volume")


class PETZVAL_WORLD_PT_mist(_WorldPanel, bpy.types.Panel):
    bl_label = "Mist Pass"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and any(layer.use_pass_mist for layer in context.scene.view_layers)

    def draw(self, context):
        layout, mist = columns(self), context.world.mist_settings
        column = layout.column(align=True)
        column.prop(mist, "start")
        column.prop(mist, "depth")
        layout.prop(mist, "falloff")


class PETZVAL_WORLD_PT_settings(_WorldPanel, bpy.types.Panel):
    bl_label = "Settings"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        # Cycles keeps them.
        return super().poll(context) and hasattr(context.world, "cycles")

    def draw(self, context):
        layout, cycles = columns(self), context.world.cycles
        layout.use_property_decorate = False
        # Of how the world is sampled as a light it counts alone whether it is, as in Cycles.
        layout.prop(cycles, "sampling_method", text="Sampling")
        column = layout.column()
        column.active = cycles.sampling_method != "NONE"
        column.prop(cycles, "max_bounces")
        # From 5.2 on.
        if hasattr(cycles, "use_shadows"):
            column.prop(cycles, "use_shadows")


class PETZVAL_WORLD_PT_ray_visibility(_WorldPanel, bpy.types.Panel):
    bl_label = "Ray Visibility"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        # Cycles keeps it.
        return super().poll(context) and hasattr(context.world, "cycles_visibility")

    def draw(self, context):
        layout = columns(self)
        layout.use_property_decorate = False
        column = layout.column()
        for name in ("camera", "diffuse", "glossy", "transmission", "scatter"):
            column.prop(context.world.cycles_visibility, name)


CLASSES = (
    PETZVAL_WORLD_PT_surface,
    PETZVAL_WORLD_PT_volume,
    PETZVAL_WORLD_PT_mist,
    PETZVAL_WORLD_PT_settings,
    PETZVAL_WORLD_PT_ray_visibility,
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
