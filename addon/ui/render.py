# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of the render settings: Sampling and Light Paths."""

from __future__ import annotations

import bpy

from .. import native
from ..data import denoiser
from ..export import denoising, sampling
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
        is_own = not sampling.follows_cycles(context.scene, sampling.OF_RENDER)
        (_own_rows if is_own else _cycles_rows)(layout, context.scene)
        _whose(layout, context.scene, "RENDER", is_own)


def _own_rows(layout, scene) -> None:
    """Petzval's own settings of final renders."""
    settings = scene.petzval
    _threshold(layout, settings, "use_noise_threshold", "noise_threshold")
    layout.prop(settings, "samples", text="Max Samples" if settings.use_noise_threshold else "Samples")
    if settings.use_noise_threshold:
        row, cycles = layout.row(), getattr(scene, "cycles", None)
        row.active = cycles is not None and cycles.use_denoising
        row.prop(settings, "use_threshold_after_denoising")
        layout.prop(settings, "min_samples")
    layout.prop(settings, "time_limit")


def _cycles_rows(layout, scene, which: str = "") -> None:
    """The rows of Cycles' samples, of final renders or of views (`preview_`)."""
    cycles, use = scene.cycles, f"use_{which}adaptive_sampling"
    _threshold(layout, cycles, use, f"{which}adaptive_threshold")
    layout.prop(cycles, f"{which}samples", text="Max Samples" if getattr(cycles, use) else "Samples")
    if getattr(cycles, use):
        layout.prop(cycles, f"{which}adaptive_min_samples", text="Min Samples")
    if not which:
        layout.prop(cycles, "time_limit")


def _threshold(layout, settings, use: str, threshold: str) -> None:
    """A noise threshold behind its switch."""
    row = layout.column(heading="Noise Threshold", align=True).row(align=True)
    row.prop(settings, use, text="")
    part = row.row()
    part.active = getattr(settings, use)
    part.prop(settings, threshold, text="")


def _whose(layout, scene, of: str, is_own: bool) -> None:
    """The row that shows whose settings count, and the button for the others."""
    if not hasattr(scene, "cycles"):
        return
    row = layout.row()
    if is_own:
        row.operator("petzval.cycles_sampling", text="As Set for Cycles", icon="LOOP_BACK").of = of
    else:
        row.label(text="As set for Cycles")
        row.operator("petzval.own_sampling", text="Set Petzval's Own").of = of


class PETZVAL_RENDER_PT_sampling_viewport(_RenderPanel, bpy.types.Panel):
    bl_label = "Viewport"
    bl_parent_id = "PETZVAL_RENDER_PT_sampling"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, scene = columns(self), context.scene
        is_own = not sampling.follows_cycles(scene, sampling.OF_VIEW)
        if is_own:
            layout.prop(scene.petzval, "preview_samples", text="Samples")
        else:
            _cycles_rows(layout, scene, "preview_")
        _whose(layout, scene, "VIEW", is_own)
        has_own_size = scene.petzval.is_property_set("preview_pixel_size")
        layout.prop(scene.petzval if has_own_size else scene.render, "preview_pixel_size")


class _DenoisePanel(_RenderPanel):
    """Cycles's settings, which a scene has one set of."""

    bl_label = "Denoise"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and hasattr(context.scene, "cycles")


def _denoise_rows(layout, cycles, which: str) -> None:
    """The rows of denoising, of final renders or of views (`preview_`), as this Blender has them."""
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
        wanted, row = sampling.of_render(context.scene), layout.row()
        row.active = not wanted.noise_threshold and wanted.sample_offset == 0 and settings.pipeline != "SCENE"
        row.prop(settings, "use_blue_noise")
        if not wanted.is_of_cycles:
            layout.prop(settings, "sample_offset", text="Sample Offset")
            return
        cycles = context.scene.cycles
        if not hasattr(cycles, "use_sample_subset"):
            # Before Blender 4.5.
            layout.prop(cycles, "sample_offset", text="Sample Offset")
            return
        layout.prop(cycles, "use_sample_subset", text="Sample Subset")
        column = layout.column(align=True)
        column.active = cycles.use_sample_subset
        column.prop(cycles, "sample_offset", text="Offset")
        column.prop(cycles, "sample_subset_length", text="Length")


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
