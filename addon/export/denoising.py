# SPDX-License-Identifier: GPL-3.0-or-later
"""The denoising settings of a scene. Cycles keeps them; a scene has one set of them."""

from __future__ import annotations

import dataclasses

import bpy

from petzval.description import DenoisingDescription

from ..data import denoiser, process_memory
from ..native import engine

#: Megabytes that the filter may take: in tiles it needs a little longer, for a picture at once it takes 700 bytes a pixel.
MOST_MB = 2000
#: The passes that guide, by Cycles's names of its choices.
_GUIDES = {"RGB": (False, False), "RGB_ALBEDO": (True, False), "RGB_ALBEDO_NORMAL": (True, True)}


def of_render(scene: bpy.types.Scene) -> DenoisingDescription | None:
    """The settings for final renders; None: Open Image Denoise is not there."""
    how = _described(scene.cycles, "")
    if how is not None and scene.petzval.integrator == "BIDIRECTIONAL":
        # Bidirectional paths leave the guides black.
        return dataclasses.replace(how, by_albedo=False, by_normal=False)
    return how


def of_view(scene: bpy.types.Scene) -> DenoisingDescription | None:
    """The settings for 3D views; None: these are not denoised, or Open Image Denoise is not there."""
    cycles = getattr(scene, "cycles", None)
    return _described(cycles, "preview_") if cycles is not None and cycles.use_preview_denoising else None


def _described(cycles: bpy.types.bpy_struct, which: str) -> DenoisingDescription | None:
    library = denoiser.library()
    if library is None:
        return None

    def setting(name: str, otherwise: object) -> object:
        # Older Blenders have no choice of quality.
        return getattr(cycles, f"{which}denoising_{name}", otherwise)

    by_albedo, by_normal = _GUIDES[setting("input_passes", "RGB_ALBEDO_NORMAL")]
    return DenoisingDescription(
        library=str(library),
        by_albedo=by_albedo,
        by_normal=by_normal,
        prefilter=setting("prefilter", "ACCURATE"),
        quality=setting("quality", "BALANCED" if which else "HIGH"),
        use_gpu=bool(setting("use_gpu", False)) and has_gpu(),
        memory_mb=MOST_MB,
    )


def has_gpu() -> bool:
    """True if a graphics card that is chosen in the preferences can denoise; Cycles asks the same."""
    cycles = bpy.context.preferences.addons.get("cycles")
    asked = getattr(cycles and cycles.preferences, "has_oidn_gpu_devices", None)
    return bool(asked and asked())


def within_memory(how: DenoisingDescription, limit_gb: float) -> DenoisingDescription:
    """The denoising settings within the memory that is left now; `limit_gb` is the user's, 0 for the machine's free memory."""
    free, used = engine().free_memory_bytes(), process_memory.used_bytes()
    left = limit_gb * 1e9 - used if limit_gb and used is not None else free
    # By how much is left tiles differ, and with them the last bits: always the same where there is enough.
    return how if left is None else dataclasses.replace(how, memory_mb=min(max(int(left / 1e6), 1), how.memory_mb))


def guides(how: DenoisingDescription) -> list[str]:
    """The parts that the engine keeps for it, by its names."""
    return [
        name
        for name, is_asked in (("DENOISING_ALBEDO", how.by_albedo), ("DENOISING_NORMAL", how.by_normal))
        if is_asked
    ]
