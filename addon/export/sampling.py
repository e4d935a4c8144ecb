# SPDX-License-Identifier: GPL-3.0-or-later
"""The samples of a picture: by Petzval's own settings, or by Cycles' as long as none of Petzval's was set.

The settings of a final render belong together, and so do those of 3D views: one of Petzval's own that is set makes all of them count.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import bpy

#: Petzval's own settings that count together, of final renders and of 3D views.
OF_RENDER = ("samples", "use_noise_threshold", "noise_threshold", "min_samples", "time_limit", "sample_offset")
OF_VIEW = ("preview_samples",)
#: Petzval's noise threshold of the same noise over Cycles'. Cycles compares a pixel with five times its number
#: (intern/cycles/scene/integrator.cpp, get_adaptive_sampling), but all pixels about it, too: docs/design/adaptive-sampling.md.
CYCLES_THRESHOLD = 3.0
#: A view that goes on without end.
_ENDLESS = 1 << 16


@dataclass(frozen=True)
class Sampling:
    """The samples of a picture."""

    #: The samples of a pixel; with a noise threshold, at most.
    samples: int
    #: The noise threshold in Petzval's unit; 0: all pixels get the same number.
    noise_threshold: float
    min_samples: int
    time_limit_s: float
    #: Number of the first.
    sample_offset: int
    #: The threshold is for the noise that denoising leaves.
    is_after_denoising: bool
    is_of_cycles: bool

    def in_a_line(self) -> str:
        """A line for the panel: Cycles' values, named as Cycles'; empty where they are Petzval's own."""
        if not self.is_of_cycles:
            return ""
        count = f"{self.samples} samples" if self.samples < _ENDLESS else "samples without end"
        limits = [f"at most {count}" if self.noise_threshold else count]
        if self.noise_threshold:
            limits.append(f"noise threshold {self.noise_threshold / CYCLES_THRESHOLD:.4g}")
        if self.time_limit_s:
            limits.append(f"{self.time_limit_s:.4g} s")
        if self.sample_offset:
            limits.append(f"from sample {self.sample_offset} on")
        return f"sampling as set for Cycles: {', '.join(limits)}"


def follows_cycles(scene: bpy.types.Scene, names: tuple[str, ...]) -> bool:
    """True if Cycles' settings count in the place of these: where Cycles is there, and none of these was set."""
    return hasattr(scene, "cycles") and not any(scene.petzval.is_property_set(name) for name in names)


def of_render(scene: bpy.types.Scene) -> Sampling:
    """The sampling of final renders."""
    own = scene.petzval
    if follows_cycles(scene, OF_RENDER):
        cycles = scene.cycles
        offset, most = 0, cycles.samples
        if not hasattr(cycles, "use_sample_subset"):
            # Before Blender 4.5 there is no end of a subset: so many samples are taken from the offset on.
            offset = cycles.sample_offset
        elif cycles.use_sample_subset:
            offset = min(cycles.sample_offset, most - 1)
            most = min(most - offset, cycles.sample_subset_length)
        return _of_cycles(cycles, "", most, cycles.time_limit, offset)
    return Sampling(
        samples=own.samples,
        noise_threshold=own.noise_threshold if own.use_noise_threshold else 0.0,
        min_samples=own.min_samples,
        time_limit_s=own.time_limit,
        sample_offset=own.sample_offset,
        is_after_denoising=own.use_threshold_after_denoising,
        is_of_cycles=False,
    )


def of_view(scene: bpy.types.Scene) -> Sampling:
    """The sampling of 3D views."""
    if follows_cycles(scene, OF_VIEW):
        return _of_cycles(scene.cycles, "preview_", scene.cycles.preview_samples or _ENDLESS)
    return Sampling(scene.petzval.preview_samples or _ENDLESS, 0.0, 0, 0.0, 0, False, False)


def of_layer(samples: int, scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> int:
    """The samples of a view layer, as Cycles' setting for that has it."""
    use = getattr(getattr(scene, "cycles", None), "use_layer_samples", "IGNORE")
    if use == "IGNORE" or view_layer.samples <= 0:
        return samples
    return min(samples, view_layer.samples) if use == "BOUNDED" else view_layer.samples


def make_own(scene: bpy.types.Scene, names: tuple[str, ...]) -> None:
    """Copies Cycles' values into Petzval's own settings, where Cycles' count: from then on Petzval's count."""
    if not follows_cycles(scene, names):
        return
    own, now = scene.petzval, of_render(scene) if names == OF_RENDER else of_view(scene)
    if names == OF_VIEW:
        own.preview_samples = now.samples if now.samples < _ENDLESS else 0
        return
    own.samples, own.min_samples, own.time_limit = now.samples, now.min_samples, now.time_limit_s
    own.sample_offset = now.sample_offset
    own.use_noise_threshold = now.noise_threshold > 0.0
    if now.noise_threshold:
        own.noise_threshold = now.noise_threshold


def follow_cycles(scene: bpy.types.Scene, names: tuple[str, ...]) -> None:
    """Unsets Petzval's own settings, so that Cycles' count."""
    for name in names:
        scene.petzval.property_unset(name)
    # Blender takes no notice of that by itself.
    scene.update_tag()


def _of_cycles(cycles: object, which: str, samples: int, time_limit_s: float = 0.0, offset: int = 0) -> Sampling:
    """The sampling by Cycles' own settings of final renders, or of views (`preview_`)."""
    threshold, least = 0.0, 0
    if getattr(cycles, f"use_{which}adaptive_sampling"):
        # Cycles' own rules for zeros, intern/cycles/scene/integrator.cpp.
        threshold = getattr(cycles, f"{which}adaptive_threshold") or max(0.001, 1.0 / samples)
        least = getattr(cycles, f"{which}adaptive_min_samples") or ceil(16.0 / threshold**0.3)
        least = max(least, 4)
    return Sampling(samples, threshold * CYCLES_THRESHOLD, least, time_limit_s, offset, False, True)
