# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings of a scene for its render."""

from __future__ import annotations

import dataclasses

import bpy

from petzval.description import Approximations, SettingsDescription

from . import sampling, visibility
from .stereo import View

#: The distance of the seeds of two frames: a prime.
_SEEDS_APART = 15_485_863
#: The distance of the seeds of two views, likewise.
_VIEWS_APART = 32_452_843


def describe(
    scene: bpy.types.Scene, width: int, height: int, with_data: bool = False, is_viewport: bool = False
) -> SettingsDescription:
    """The settings of a scene for a picture of that many pixels."""
    own, render = scene.petzval, scene.render
    wanted = sampling.of_view(scene) if is_viewport else sampling.of_render(scene)
    return SettingsDescription(
        width=width,
        height=height,
        samples=wanted.samples,
        noise_threshold=wanted.noise_threshold,
        min_samples=wanted.min_samples,
        seed=seed(scene),
        blue_noise=own.use_blue_noise,
        # Cycles keeps the film's exposure; a picture must not change with the engine.
        film_exposure=getattr(getattr(scene, "cycles", None), "film_exposure", 1.0),
        sample_offset=wanted.sample_offset,
        threads=render.threads if render.threads_mode == "FIXED" else 0,
        max_bounces=visibility.most_bounces(scene),
        kinds=visibility.bounces(scene),
        clamp_direct=getattr(getattr(scene, "cycles", None), "sample_clamp_direct", 0.0),
        clamp_indirect=own.clamp_indirect if overrules(scene, "clamp_indirect") else scene.cycles.sample_clamp_indirect,
        filter=_filter(scene),
        approximations=Approximations(
            # Cycles keeps the filter of glossy light, as it keeps the kinds of bounces.
            filter_glossy=getattr(getattr(scene, "cycles", None), "blur_glossy", 0.0),
            widening=_widening(scene),
            fast_gi=_fast_gi(scene, is_viewport),
        ),
        pipeline=own.pipeline,
        with_data=with_data,
        integrator=own.integrator,
        light_tracing=own.use_light_tracing,
        transparent_film=render.film_transparent,
        transparent_glass=_transparent_glass(scene),
    )


def _transparent_glass(scene: bpy.types.Scene) -> float | None:
    """The most roughness of glass that a transparent film is seen through, as Cycles keeps it; None: of none."""
    cycles = getattr(scene, "cycles", None)
    return cycles.film_transparent_roughness if getattr(cycles, "film_transparent_glass", False) else None


def overrules(scene: bpy.types.Scene, name: str) -> bool:
    """True if Petzval's own setting counts, and not Cycles's in its place: where it was set, or Cycles is absent."""
    return scene.petzval.is_property_set(name) or not hasattr(scene, "cycles")


def seed(scene: bpy.types.Scene) -> int:
    """Petzval's own seed, or Cycles's where Petzval's was never set: another one in each frame if that is asked for."""
    if overrules(scene, "seed"):
        return scene.petzval.seed
    of_frame = scene.frame_current if scene.cycles.use_animated_seed else 0
    # Neighbouring seeds of an artist's own choice are not those of neighbouring frames.
    return (scene.cycles.seed + _SEEDS_APART * of_frame) % 2**31


def _filter(scene: bpy.types.Scene) -> str | dict[str, float]:
    """The pixel filter, as the engine takes it."""
    if overrules(scene, "filter_width"):
        width = scene.petzval.filter_width
        return {"BLACKMAN_HARRIS": width} if width > 0.0 else "BOX"
    kind = scene.cycles.pixel_filter_type
    return kind if kind == "BOX" else {kind: scene.cycles.filter_width}


def _widening(scene: bpy.types.Scene) -> float:
    """The growth of footprints after a diffuse scattering; Cycles has it from 5.2 on."""
    if bpy.app.version < (5, 2, 0):
        return 0.0
    return min(1.0, getattr(getattr(scene, "cycles", None), "blur_glossy", 0.0))


def _fast_gi(scene: bpy.types.Scene, is_viewport: bool) -> str | dict[str, dict[str, float]]:
    """Cycles's Fast GI Approximation, as the engine takes it. Without a world there is none, as in Cycles."""
    cycles, world = getattr(scene, "cycles", None), scene.world
    if cycles is None or world is None or not cycles.use_fast_gi:
        return "OFF"
    light = {"distance": world.light_settings.distance, "factor": world.light_settings.ao_factor}
    if cycles.fast_gi_method == "REPLACE":
        light["bounces"] = cycles.ao_bounces if is_viewport else cycles.ao_bounces_render
    return {cycles.fast_gi_method: light}


def of_view(settings: SettingsDescription, view: View) -> SettingsDescription:
    """The settings with noise of its own for each view: noise that both eyes see alike would lie in a plane of its own."""
    return dataclasses.replace(settings, seed=(settings.seed + _VIEWS_APART * view.index) % 2**31)


def of_layer(
    settings: SettingsDescription, scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer
) -> SettingsDescription:
    """The settings with a view layer's own number of samples, by Cycles's setting for that; parts of a picture have independent pixels."""
    if view_layer.petzval.use_pass_mergeable:
        settings = dataclasses.replace(settings, blue_noise=False)
    return dataclasses.replace(settings, samples=sampling.of_layer(settings.samples, scene, view_layer))
