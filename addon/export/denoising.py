# SPDX-License-Identifier: GPL-3.0-or-later
"""How a scene is to be denoised: Cycles keeps that, a scene has one set of it."""

from __future__ import annotations

import bpy

from petzval.description import DenoisingDescription

from ..data import denoiser

#: The passes that guide, by Cycles's names of its choices.
_GUIDES = {"RGB": (False, False), "RGB_ALBEDO": (True, False), "RGB_ALBEDO_NORMAL": (True, True)}


def is_wanted(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> bool:
    """Whether final renders are denoised: the scene's switch, and the layer's."""
    cycles, of_layer = getattr(scene, "cycles", None), getattr(view_layer, "cycles", None)
    return bool(cycles and cycles.use_denoising and getattr(of_layer, "use_denoising", True))


def describe(scene: bpy.types.Scene) -> DenoisingDescription | None:
    """The scene's settings of denoising; None: Open Image Denoise is not there."""
    library = denoiser.library()
    if library is None:
        return None
    cycles = scene.cycles
    by_albedo, by_normal = _GUIDES[cycles.denoising_input_passes]
    return DenoisingDescription(
        library=str(library),
        by_albedo=by_albedo,
        by_normal=by_normal,
        prefilter=cycles.denoising_prefilter,
        # Older Blenders have no choice of quality.
        quality=getattr(cycles, "denoising_quality", "HIGH"),
    )


def guides(how: DenoisingDescription) -> list[str]:
    """The parts that the engine keeps for it, by its names."""
    return [name for name, is_asked in (("DENOISING_ALBEDO", how.by_albedo), ("DENOISING_NORMAL", how.by_normal)) if is_asked]
