# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene says of how it is to be rendered."""

from __future__ import annotations

import dataclasses

import bpy

from .description import SettingsDescription
from .export import visibility


def describe(
    scene: bpy.types.Scene, width: int, height: int, with_data: bool = False, is_viewport: bool = False
) -> SettingsDescription:
    """The settings of a scene for a picture of that many pixels."""
    own, render = scene.petzval, scene.render
    return SettingsDescription(
        width=width,
        height=height,
        samples=own.samples,
        noise_threshold=own.noise_threshold if own.use_noise_threshold else 0.0,
        min_samples=own.min_samples,
        seed=own.seed,
        blue_noise=own.use_blue_noise,
        # Cycles keeps the film's exposure; a picture must not change with the engine.
        film_exposure=getattr(getattr(scene, "cycles", None), "film_exposure", 1.0),
        sample_offset=own.sample_offset,
        threads=render.threads if render.threads_mode == "FIXED" else 0,
        max_bounces=visibility.most_bounces(scene),
        **visibility.bounces(scene),
        clamp_direct=getattr(getattr(scene, "cycles", None), "sample_clamp_direct", 0.0),
        clamp_indirect=own.clamp_indirect,
        **_filter(scene),
        # Cycles keeps the filter of glossy light, as it keeps the kinds of bounces.
        filter_glossy=getattr(getattr(scene, "cycles", None), "blur_glossy", 0.0),
        **_fast_gi(scene, is_viewport),
        pipeline=own.pipeline,
        with_data=with_data,
        integrator=own.integrator,
        transparent_film=render.film_transparent,
    )


def overrules_filter(scene: bpy.types.Scene) -> bool:
    """Whether Petzval's own filter width counts, and not Cycles's pixel filter: where it was set, or Cycles is absent."""
    return scene.petzval.is_property_set("filter_width") or not hasattr(scene, "cycles")


def _filter(scene: bpy.types.Scene) -> dict[str, str | float]:
    """The pixel filter, by the name of the engine's setting."""
    if overrules_filter(scene):
        width = scene.petzval.filter_width
        return {"filter": "BLACKMAN_HARRIS" if width > 0.0 else "BOX", "filter_width_px": width}
    return {"filter": scene.cycles.pixel_filter_type, "filter_width_px": scene.cycles.filter_width}


def _fast_gi(scene: bpy.types.Scene, is_viewport: bool) -> dict[str, str | int | float]:
    """Cycles's Fast GI Approximation, by the names of the engine's settings. Without a world there is none, as in Cycles."""
    cycles, world = getattr(scene, "cycles", None), scene.world
    if cycles is None or world is None or not cycles.use_fast_gi:
        return {}
    return {
        "fast_gi": cycles.fast_gi_method,
        "fast_gi_bounces": cycles.ao_bounces if is_viewport else cycles.ao_bounces_render,
        "fast_gi_distance": world.light_settings.distance,
        "fast_gi_factor": world.light_settings.ao_factor,
    }


def of_layer(
    settings: SettingsDescription, scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer
) -> SettingsDescription:
    """The same with a view layer's own number of samples, as Cycles's setting for that has it."""
    use = getattr(getattr(scene, "cycles", None), "use_layer_samples", "IGNORE")
    if use == "IGNORE" or view_layer.samples <= 0:
        return settings
    own = min(settings.samples, view_layer.samples) if use == "BOUNDED" else view_layer.samples
    return dataclasses.replace(settings, samples=own)
