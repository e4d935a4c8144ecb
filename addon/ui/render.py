# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of the render settings."""

from __future__ import annotations

import bpy

from .. import messages, native, statistics
from .camera_parts import lines_of
from .mixin import PetzvalPanel, columns
from .preset_panels import PETZVAL_PT_sampling_presets

# More would fill the panel.
_MOST_MESSAGES = 24
#: By what a message is about.
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


class PETZVAL_RENDER_PT_sampling(_RenderPanel, bpy.types.Panel):
    bl_label = "Sampling"

    def draw_header_preset(self, context):
        PETZVAL_PT_sampling_presets.draw_panel_header(self.layout)

    def draw(self, context):
        layout = columns(self)
        complaint = native.missing()
        if complaint:
            row = layout.row()
            row.alert = True
            row.label(text=complaint, icon="ERROR")
        settings = context.scene.petzval
        heading = layout.column(heading="Noise Threshold", align=True)
        row = heading.row(align=True)
        row.prop(settings, "use_noise_threshold", text="")
        part = row.row()
        part.active = settings.use_noise_threshold
        part.prop(settings, "noise_threshold", text="")
        layout.prop(settings, "samples", text="Max Samples" if settings.use_noise_threshold else "Samples")
        if settings.use_noise_threshold:
            layout.prop(settings, "min_samples")
        layout.prop(settings, "time_limit")


class PETZVAL_RENDER_PT_sampling_advanced(_RenderPanel, bpy.types.Panel):
    bl_label = "Advanced"
    bl_parent_id = "PETZVAL_RENDER_PT_sampling"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = columns(self)
        settings = context.scene.petzval
        layout.prop(settings, "seed")
        row = layout.row()
        row.active = not settings.use_noise_threshold
        row.prop(settings, "use_blue_noise")
        layout.prop(settings, "sample_offset", text="Sample Offset")


class PETZVAL_RENDER_PT_light_paths(_RenderPanel, bpy.types.Panel):
    bl_label = "Light Paths"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = columns(self)
        settings = context.scene.petzval
        holder = context.scene.camera
        is_lens = holder is not None and holder.type == "CAMERA" and holder.data.petzval.model == "LENS"
        is_path = settings.integrator == "PATH"
        layout.prop(settings, "integrator")
        if not is_path and holder is not None and not is_lens:
            layout.label(text="The camera's model must be Lens", icon="ERROR")
        row = layout.row()
        row.active = is_path and is_lens
        row.prop(settings, "pipeline")
        cycles = getattr(context.scene, "cycles", None)
        own = cycles is None or settings.is_property_set("max_bounces")
        column = layout.column(align=True)
        column.prop(settings if own else cycles, "max_bounces", text="Bounces")
        if cycles is not None:
            # Blender keeps these in Cycles's settings: a scene has one set of them.
            for kind in ("diffuse", "glossy", "transmission", "volume"):
                column.prop(cycles, f"{kind}_bounces", text=kind.capitalize())
            column.prop(cycles, "transparent_max_bounces", text="Transparent")
            row = layout.row(heading="Caustics", align=True)
            row.active = is_path
            row.prop(cycles, "caustics_reflective", text="Reflective", toggle=True)
            row.prop(cycles, "caustics_refractive", text="Refractive", toggle=True)
        row = layout.row()
        row.active = is_path
        row.prop(settings, "clamp_indirect")


class PETZVAL_RENDER_PT_film(_RenderPanel, bpy.types.Panel):
    bl_label = "Film"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = columns(self)
        layout.prop(context.scene.petzval, "filter_width")
        cycles = getattr(context.scene, "cycles", None)
        if cycles is not None:
            layout.prop(cycles, "film_exposure")
        layout.prop(context.scene.render, "film_transparent", text="Transparent")


class PETZVAL_RENDER_PT_threads(_RenderPanel, bpy.types.Panel):
    bl_label = "Performance"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = columns(self)
        render = context.scene.render
        layout.prop(render, "threads_mode", text="Threads")
        row = layout.row()
        row.enabled = render.threads_mode == "FIXED"
        row.prop(render, "threads", text="Number")
        layout.prop(render, "use_persistent_data", text="Persistent Data")
        layout.prop(context.scene.petzval, "use_checkpoints")
        layout.prop(context.scene.petzval, "memory_limit", text="Memory Limit (GB)")


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
        return super().poll(context) and bool(messages.all_of(context.scene.name))

    def draw(self, context):
        found = messages.all_of(context.scene.name)
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


CLASSES = (
    PETZVAL_RENDER_PT_sampling,
    PETZVAL_RENDER_PT_sampling_advanced,
    PETZVAL_RENDER_PT_light_paths,
    PETZVAL_RENDER_PT_film,
    PETZVAL_RENDER_PT_threads,
    PETZVAL_RENDER_PT_last,
    PETZVAL_RENDER_PT_messages,
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
