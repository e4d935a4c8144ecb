# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of the render settings: Film and Performance."""

from __future__ import annotations

import bpy

from ..export import settings as render_settings
from .mixin import PetzvalPanel, columns


class _RenderPanel(PetzvalPanel):
    bl_context = "render"


class PETZVAL_RENDER_PT_film(_RenderPanel, bpy.types.Panel):
    bl_label = "Film"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = columns(self)
        scene = context.scene
        cycles = getattr(scene, "cycles", None)
        if render_settings.overrules(scene, "filter_width"):
            layout.prop(scene.petzval, "filter_width")
        else:
            layout.prop(cycles, "pixel_filter_type")
            row = layout.row()
            row.active = cycles.pixel_filter_type != "BOX"
            row.prop(cycles, "filter_width")
        if cycles is not None:
            layout.prop(cycles, "film_exposure")
        layout.prop(scene.render, "film_transparent", text="Transparent")
        if cycles is not None and scene.render.film_transparent:
            layout.prop(cycles, "film_transparent_glass", text="Transparent Glass")
            row = layout.row()
            row.active = cycles.film_transparent_glass
            row.prop(cycles, "film_transparent_roughness", text="Roughness Threshold")


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


CLASSES = (PETZVAL_RENDER_PT_film, PETZVAL_RENDER_PT_threads)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
