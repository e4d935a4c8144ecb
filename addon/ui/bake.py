# SPDX-License-Identifier: GPL-3.0-or-later
"""The Bake panel, as Cycles' own: the type, the parts of light, the source objects, and the target. Blender keeps all but the type."""

from __future__ import annotations

import bpy

from .mixin import PetzvalPanel, columns

#: Types that depend on the place from which the surface is seen.
_SEEN = {"COMBINED", "SHADOW", "EMIT", "DIFFUSE", "GLOSSY", "TRANSMISSION"}
#: Types of one kind of lobe.
_OF_LOBES = {"DIFFUSE", "GLOSSY", "TRANSMISSION"}
#: Settings of bakes from multiresolution data, which Blender makes itself: since 5.0 with the others, before apart.
_OLD_NAMES = {
    "use_multires": "use_bake_multires",
    "type": "bake_type",
    "use_clear": "use_bake_clear",
    "use_lores_mesh": "use_bake_lores_mesh",
    "margin": "bake_margin",
    "margin_type": "bake_margin_type",
}


def _multires(render: bpy.types.RenderSettings, name: str) -> tuple[bpy.types.bpy_struct, str]:
    """The place where Blender keeps a setting of multiresolution baking: a struct and the setting's name."""
    return (render.bake, name) if hasattr(render.bake, "use_multires") else (render, _OLD_NAMES[name])


def _is_multires(render: bpy.types.RenderSettings) -> bool:
    return getattr(*_multires(render, "use_multires"))


def _rows(panel) -> object:
    """The panel's layout: bakes are not animated."""
    layout = columns(panel)
    layout.use_property_decorate = False
    return layout


class _BakePanel(PetzvalPanel):
    bl_context = "render"


class PETZVAL_RENDER_PT_bake(_BakePanel, bpy.types.Panel):
    bl_label = "Bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, scene = _rows(self), context.scene
        if _is_multires(scene.render):
            layout.operator("object.bake_image", icon="RENDER_STILL")
            layout.prop(*_multires(scene.render, "use_multires"))
            layout.prop(*_multires(scene.render, "type"))
            return
        kind = scene.petzval.bake_type
        layout.operator("object.bake", icon="RENDER_STILL").type = kind
        layout.prop(*_multires(scene.render, "use_multires"))
        layout.prop(scene.petzval, "bake_type")
        if kind in _SEEN:
            row = layout.row()
            row.active = scene.camera is not None
            row.prop(scene.render.bake, "view_from")


class PETZVAL_RENDER_PT_bake_influence(_BakePanel, bpy.types.Panel):
    bl_label = "Influence"
    bl_parent_id = "PETZVAL_RENDER_PT_bake"

    @classmethod
    def poll(cls, context):
        kinds = {"NORMAL", "COMBINED"} | _OF_LOBES
        return (
            super().poll(context)
            and not _is_multires(context.scene.render)
            and context.scene.petzval.bake_type in kinds
        )

    def draw(self, context):
        layout = _rows(self)
        bake, kind = context.scene.render.bake, context.scene.petzval.bake_type
        if kind == "NORMAL":
            layout.prop(bake, "normal_space", text="Space")
            column = layout.column(align=True)
            for name, text in (("normal_r", "Swizzle R"), ("normal_g", "G"), ("normal_b", "B")):
                column.prop(bake, name, text=text)
            return
        column = layout.column(heading="Lighting" if kind == "COMBINED" else "Contributions", align=True)
        column.prop(bake, "use_pass_direct")
        column.prop(bake, "use_pass_indirect")
        if kind in _OF_LOBES:
            column.prop(bake, "use_pass_color")
            return
        column = layout.column(heading="Contributions", align=True)
        column.active = bake.use_pass_direct or bake.use_pass_indirect
        for name in ("use_pass_diffuse", "use_pass_glossy", "use_pass_transmission", "use_pass_emit"):
            column.prop(bake, name)


class PETZVAL_RENDER_PT_bake_selected_to_active(_BakePanel, bpy.types.Panel):
    bl_label = "Selected to Active"
    bl_parent_id = "PETZVAL_RENDER_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and not _is_multires(context.scene.render)

    def draw_header(self, context):
        self.layout.prop(context.scene.render.bake, "use_selected_to_active", text="")

    def draw(self, context):
        layout, bake = _rows(self), context.scene.render.bake
        layout.active = bake.use_selected_to_active
        layout.prop(bake, "use_cage", text="Cage")
        column = layout.column()
        if bake.use_cage:
            layout.prop(bake, "cage_object")
            column = layout.column()
            column.active = bake.cage_object is None
        column.prop(bake, "cage_extrusion", text="Cage Extrusion" if bake.use_cage else "Extrusion")
        layout.prop(bake, "max_ray_distance")


class PETZVAL_RENDER_PT_bake_output(_BakePanel, bpy.types.Panel):
    bl_label = "Output"
    bl_parent_id = "PETZVAL_RENDER_PT_bake"

    def draw(self, context):
        layout, render = _rows(self), context.scene.render
        if not _is_multires(render):
            layout.prop(render.bake, "target")
            if render.bake.target == "IMAGE_TEXTURES":
                layout.prop(render.bake, "use_clear", text="Clear Image")
            return
        layout.prop(*_multires(render, "use_clear"), text="Clear Image")
        kind = getattr(*_multires(render, "type"))
        if kind in {"DISPLACEMENT", "VECTOR_DISPLACEMENT"}:
            layout.prop(*_multires(render, "use_lores_mesh"))
        if kind == "VECTOR_DISPLACEMENT":
            layout.prop(render.bake, "displacement_space", text="Space")


class PETZVAL_RENDER_PT_bake_output_margin(_BakePanel, bpy.types.Panel):
    bl_label = "Margin"
    bl_parent_id = "PETZVAL_RENDER_PT_bake_output"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.scene.render.bake.target == "IMAGE_TEXTURES"

    def draw(self, context):
        layout, render = _rows(self), context.scene.render
        kind, is_multires = context.scene.petzval.bake_type, _is_multires(render)
        # Blender extends tangents and texture coordinates by one rule alone.
        has_type = is_multires or not (kind == "UV" or (kind == "NORMAL" and render.bake.normal_space == "TANGENT"))
        for name, text in (("margin_type", "Type"), ("margin", "Size")):
            if name == "margin" or has_type:
                holder, own = _multires(render, name) if is_multires else (render.bake, name)
                layout.prop(holder, own, text=text)


CLASSES = (
    PETZVAL_RENDER_PT_bake,
    PETZVAL_RENDER_PT_bake_influence,
    PETZVAL_RENDER_PT_bake_selected_to_active,
    PETZVAL_RENDER_PT_bake_output,
    PETZVAL_RENDER_PT_bake_output_margin,
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
