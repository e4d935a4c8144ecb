# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of the render settings: Sampling and Light Paths."""

from __future__ import annotations

import bpy

from .. import native
from ..data import denoiser
from ..export import denoising
from ..export import settings as render_settings
from .camera_parts import complain
from .mixin import PetzvalPanel, columns
from .preset_panels import PETZVAL_PT_sampling_presets


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
            row, cycles = layout.row(), getattr(context.scene, "cycles", None)
            row.active = cycles is not None and cycles.use_denoising
            row.prop(settings, "use_threshold_after_denoising")
            layout.prop(settings, "min_samples")
        layout.prop(settings, "time_limit")


class PETZVAL_RENDER_PT_sampling_viewport(_RenderPanel, bpy.types.Panel):
    bl_label = "Viewport"
    bl_parent_id = "PETZVAL_RENDER_PT_sampling"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = columns(self)
        layout.prop(context.scene.petzval, "preview_samples", text="Samples")
        layout.prop(context.scene.petzval, "preview_pixel_size")


class _DenoisePanel(_RenderPanel):
    """Cycles's settings, which a scene has one set of."""

    bl_label = "Denoise"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and hasattr(context.scene, "cycles")


def _denoise_rows(layout, cycles, which: str) -> None:
    """Those of final renders, or of views (`preview_`), as this Blender has them."""
    layout.active = getattr(cycles, f"use_{which}denoising")
    for name, text in (
        ("input_passes", "Passes"),
        ("prefilter", "Prefilter"),
        ("quality", "Quality"),
        ("start_sample", "Start Sample"),
        ("use_gpu", "Use GPU"),
    ):
        if hasattr(cycles, f"{which}denoising_{name}"):
            row = layout.row()
            row.active = name != "use_gpu" or denoising.has_gpu()
            row.prop(cycles, f"{which}denoising_{name}", text=text)


class PETZVAL_RENDER_PT_sampling_viewport_denoise(_DenoisePanel, bpy.types.Panel):
    bl_parent_id = "PETZVAL_RENDER_PT_sampling_viewport"

    def draw_header(self, context):
        self.layout.prop(context.scene.cycles, "use_preview_denoising", text="")

    def draw(self, context):
        layout, cycles = columns(self), context.scene.cycles
        if cycles.use_preview_denoising and denoiser.library() is None:
            complain(context, layout, denoiser.INSTALL)
        _denoise_rows(layout.column(), cycles, "preview_")


class PETZVAL_RENDER_PT_sampling_denoise(_DenoisePanel, bpy.types.Panel):
    bl_parent_id = "PETZVAL_RENDER_PT_sampling"

    def draw_header(self, context):
        self.layout.prop(context.scene.cycles, "use_denoising", text="")

    def draw(self, context):
        layout, cycles = columns(self), context.scene.cycles
        if cycles.use_denoising and denoiser.library() is None:
            complain(context, layout, denoiser.INSTALL)
        _denoise_rows(layout.column(), cycles, "")


class PETZVAL_RENDER_PT_sampling_advanced(_RenderPanel, bpy.types.Panel):
    bl_label = "Advanced"
    bl_parent_id = "PETZVAL_RENDER_PT_sampling"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = columns(self)
        settings = context.scene.petzval
        if render_settings.overrules(context.scene, "seed"):
            layout.prop(settings, "seed")
        else:
            row, cycles = layout.row(align=True), context.scene.cycles
            row.prop(cycles, "seed")
            row.prop(cycles, "use_animated_seed", text="", icon="TIME")
        row = layout.row()
        row.active = not settings.use_noise_threshold and settings.sample_offset == 0 and settings.pipeline != "SCENE"
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
        row = layout.row()
        row.active = is_path and is_lens and settings.pipeline in {"AUTO", "HERO"}
        row.prop(settings, "use_light_tracing")
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
            row.prop(cycles, "blur_glossy", text="Filter Glossy")
        column = layout.column(align=True)
        column.active = is_path
        if cycles is not None:
            column.prop(cycles, "sample_clamp_direct")
        if render_settings.overrules(context.scene, "clamp_indirect"):
            column.prop(settings, "clamp_indirect")
        else:
            column.prop(cycles, "sample_clamp_indirect")


class PETZVAL_RENDER_PT_fast_gi(_RenderPanel, bpy.types.Panel):
    bl_label = "Fast GI Approximation"
    bl_parent_id = "PETZVAL_RENDER_PT_light_paths"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        # Cycles keeps it.
        return super().poll(context) and hasattr(context.scene, "cycles")

    def draw_header(self, context):
        self.layout.active = context.scene.petzval.integrator == "PATH"
        self.layout.prop(context.scene.cycles, "use_fast_gi", text="")

    def draw(self, context):
        layout = columns(self)
        cycles, world = context.scene.cycles, context.scene.world
        layout.active = cycles.use_fast_gi and context.scene.petzval.integrator == "PATH"
        layout.prop(cycles, "fast_gi_method", text="Method")
        if world is not None:
            column = layout.column(align=True)
            column.prop(world.light_settings, "ao_factor", text="AO Factor")
            column.prop(world.light_settings, "distance", text="AO Distance")
        if cycles.fast_gi_method == "REPLACE":
            column = layout.column(align=True)
            column.prop(cycles, "ao_bounces", text="Viewport Bounces")
            column.prop(cycles, "ao_bounces_render", text="Render Bounces")


CLASSES = (
    PETZVAL_RENDER_PT_sampling,
    PETZVAL_RENDER_PT_sampling_viewport,
    PETZVAL_RENDER_PT_sampling_viewport_denoise,
    PETZVAL_RENDER_PT_sampling_denoise,
    PETZVAL_RENDER_PT_sampling_advanced,
    PETZVAL_RENDER_PT_light_paths,
    PETZVAL_RENDER_PT_fast_gi,
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
