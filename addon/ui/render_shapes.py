# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of the render for how shapes are taken: Subdivision, Curves, Simplify, and Motion Blur with the shutter."""

from __future__ import annotations

import bpy

from .mixin import PetzvalPanel, columns

#: Blender's shapes of the shutter's curve and their icons, as its own panels have them.
_SHAPES = (
    ("SMOOTH", "SMOOTHCURVE"),
    ("ROUND", "SPHERECURVE"),
    ("ROOT", "ROOTCURVE"),
    ("SHARP", "SHARPCURVE"),
    ("LINE", "LINCURVE"),
    ("MAX", "NOCURVE"),
)


class _RenderPanel(PetzvalPanel):
    bl_context = "render"


class PETZVAL_RENDER_PT_subdivision(_RenderPanel, bpy.types.Panel):
    bl_label = "Subdivision"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        # Cycles keeps it.
        return super().poll(context) and hasattr(context.scene, "cycles")

    def draw(self, context):
        layout, own = columns(self), context.scene.cycles
        layout.use_property_decorate = False
        # Before Blender 5 it is one of Cycles' experimental features.
        layout.active = bpy.app.version >= (5, 0) or own.feature_set == "EXPERIMENTAL"
        column = layout.column(align=True)
        column.prop(own, "dicing_rate", text="Dicing Rate Render")
        column.prop(own, "preview_dicing_rate", text="Viewport")
        column = layout.column()
        column.prop(own, "offscreen_dicing_scale", text="Offscreen Scale")
        column.prop(own, "max_subdivisions")
        column.prop(own, "dicing_camera")


class PETZVAL_RENDER_PT_curves(_RenderPanel, bpy.types.Panel):
    bl_label = "Curves"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        # Cycles keeps them.
        return super().poll(context) and hasattr(context.scene, "cycles_curves")

    def draw(self, context):
        layout, own = columns(self), context.scene.cycles_curves
        layout.use_property_decorate = False
        layout.prop(own, "shape", text="Shape")
        row = layout.row()
        row.active = own.shape == "RIBBONS"
        row.prop(own, "subdivisions", text="Curve Subdivisions")


class PETZVAL_RENDER_PT_simplify(_RenderPanel, bpy.types.Panel):
    """Blender itself does this, whatever the engine"""

    bl_label = "Simplify"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context):
        self.layout.prop(context.scene.render, "use_simplify", text="")

    def draw(self, context):
        pass


class _SimplifyPart(_RenderPanel):
    bl_parent_id = PETZVAL_RENDER_PT_simplify.__name__
    names = ()

    def draw(self, context):
        layout, render = columns(self), context.scene.render
        layout.use_property_decorate = False
        layout.active = render.use_simplify
        column = layout.column()
        cycles = getattr(context.scene, "cycles", None)
        for name, text in self.names:
            # Cycles keeps those of textures.
            holder = render if hasattr(render, name) else cycles
            if hasattr(holder, name):
                column.prop(holder, name, text=text)


class PETZVAL_RENDER_PT_simplify_viewport(_SimplifyPart, bpy.types.Panel):
    bl_label = "Viewport"
    names = (
        ("simplify_subdivision", "Max Subdivision"),
        ("simplify_child_particles", "Child Particles"),
        ("simplify_volumes", "Volume Resolution"),
        ("texture_limit", "Texture Limit"),
        ("texture_resolution", "Texture Resolution"),
        ("use_simplify_normals", "Normals"),
    )


class PETZVAL_RENDER_PT_simplify_render(_SimplifyPart, bpy.types.Panel):
    bl_label = "Render"
    names = (
        ("simplify_subdivision_render", "Max Subdivision"),
        ("simplify_child_particles_render", "Child Particles"),
        ("texture_limit_render", "Texture Limit"),
        ("texture_resolution_render", "Texture Resolution"),
    )


class PETZVAL_RENDER_PT_simplify_culling(_SimplifyPart, bpy.types.Panel):
    """Of what Blender's own camera does not see, whatever lens stands before it"""

    bl_label = "Culling"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        # Cycles keeps it.
        return super().poll(context) and hasattr(context.scene, "cycles")

    def draw(self, context):
        layout, own = columns(self), context.scene.cycles
        layout.use_property_decorate = False
        layout.active = context.scene.render.use_simplify
        for which in ("camera", "distance"):
            row = layout.row(heading=f"{which.title()} Culling")
            row.prop(own, f"use_{which}_cull", text="")
            part = row.column()
            part.active = getattr(own, f"use_{which}_cull")
            part.prop(own, f"{which}_cull_margin", text="")


class PETZVAL_RENDER_PT_motion_blur(_RenderPanel, bpy.types.Panel):
    bl_label = "Motion Blur"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context):
        self.layout.prop(context.scene.render, "use_motion_blur", text="")

    def draw(self, context):
        layout, scene = columns(self), context.scene
        layout.use_property_decorate = False
        render, cycles = scene.render, getattr(scene, "cycles", None)
        layout.active = render.use_motion_blur
        if render.use_motion_blur and scene.petzval.effects.motion_blur == "OFF":
            layout.label(text="Taken out in the Effects panel", icon="INFO")
        column = layout.column()
        holder = render if hasattr(render, "motion_blur_position") else cycles
        if holder is not None:
            column.prop(holder, "motion_blur_position", text="Position")
        column.prop(render, "motion_blur_shutter")
        if cycles is None:
            return
        column.separator()
        part = column.column()
        part.active = scene.petzval.integrator == "PATH"
        part.prop(cycles, "rolling_shutter_type", text="Rolling Shutter")
        row = part.row()
        row.active = cycles.rolling_shutter_type != "NONE"
        row.prop(cycles, "rolling_shutter_duration")
        if cycles.rolling_shutter_type != "NONE" and scene.petzval.integrator != "PATH":
            layout.label(text="Bidirectional paths know of no rolling shutter", icon="INFO")


class PETZVAL_RENDER_PT_shutter_curve(_RenderPanel, bpy.types.Panel):
    bl_label = "Shutter Curve"
    bl_parent_id = "PETZVAL_RENDER_PT_motion_blur"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, render = columns(self), context.scene.render
        layout.active = render.use_motion_blur
        layout.template_curve_mapping(render, "motion_blur_shutter_curve")
        row = layout.row(align=True)
        for shape, icon in _SHAPES:
            row.operator("render.shutter_curve_preset", icon=icon, text="").shape = shape


CLASSES = (
    PETZVAL_RENDER_PT_subdivision,
    PETZVAL_RENDER_PT_curves,
    PETZVAL_RENDER_PT_simplify,
    PETZVAL_RENDER_PT_simplify_viewport,
    PETZVAL_RENDER_PT_simplify_render,
    PETZVAL_RENDER_PT_simplify_culling,
    PETZVAL_RENDER_PT_motion_blur,
    PETZVAL_RENDER_PT_shutter_curve,
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
