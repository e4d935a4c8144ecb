# SPDX-License-Identifier: GPL-3.0-or-later
"""The one list of passes. No bpy."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np


class Pass(NamedTuple):
    """A pass, as `RenderEngine.register_pass` takes it."""

    name: str
    channels: int
    channel_names: str
    kind: str
    #: The view layer's switch, and its name in the engine's `Job.data`.
    switch: str = ""
    engine_name: str = ""


COMBINED = Pass("Combined", 4, "RGBA", "COLOR")

#: Blender's own passes of data that the engine can fill. "Depth" was called Z in files before 2.8, and still is inside.
DATA = (
    Pass("Depth", 1, "Z", "VALUE", "use_pass_z", "DEPTH"),
    Pass("Position", 3, "XYZ", "VECTOR", "use_pass_position", "POSITION"),
    Pass("Normal", 3, "XYZ", "VECTOR", "use_pass_normal", "NORMAL"),
    Pass("Vector", 4, "XYZW", "VECTOR", "use_pass_vector", "VECTOR"),
)


class Light(NamedTuple):
    """A pass of light or colour, or another part that the engine keeps (`Job.part`)."""

    #: The names in Blender 5, and before.
    name: str
    old_name: str
    channel_names: str
    kind: str
    switch: str
    engine_name: str
    #: The switch is one of the layer's settings for Cycles.
    is_of_cycles: bool = False


_LOBES = (("Diffuse", "Diff"), ("Glossy", "Gloss"), ("Transmission", "Trans"))
_LIGHTS = (("Direct", "Dir"), ("Indirect", "Ind"), ("Color", "Col"))


def _of_light() -> Iterator[Light]:
    for lobe, short in _LOBES:
        for what, end in _LIGHTS:
            switch = f"use_pass_{lobe}_{what}".lower()
            yield Light(f"{lobe} {what}", short + end, "RGB", "COLOR", switch, f"{lobe}_{what}".upper())
    for what, end in _LIGHTS[:2]:
        switch = f"use_pass_volume_{what}".lower()
        yield Light(f"Volume {what}", f"Volume{end}", "RGB", "COLOR", switch, f"VOLUME_{what}".upper(), True)
    yield Light("Emission", "Emit", "RGB", "COLOR", "use_pass_emit", "EMISSION")
    yield Light("Environment", "Env", "RGB", "COLOR", "use_pass_environment", "ENVIRONMENT")


#: Passes of light, which add up: each kind of lobe's direct and indirect light times its colour, volumes, emission and
#: environment are the picture.
LIGHT = tuple(_of_light())

#: Passes of the first surface.
SURFACE = (
    Light("Mist", "Mist", "Z", "VALUE", "use_pass_mist", "MIST"),
    Light("UV", "UV", "UVA", "VECTOR", "use_pass_uv", "UV"),
    Light("Ambient Occlusion", "AO", "RGB", "COLOR", "use_pass_ambient_occlusion", "AMBIENT_OCCLUSION"),
)

#: The passes that the Denoise node of the compositor wants, all by one switch.
DENOISING = (
    Light("Denoising Albedo", "", "RGB", "COLOR", "denoising_store_passes", "DENOISING_ALBEDO", True),
    Light("Denoising Normal", "", "XYZ", "VECTOR", "denoising_store_passes", "DENOISING_NORMAL", True),
    Light("Denoising Depth", "", "Z", "VALUE", "denoising_store_passes", "DENOISING_DEPTH", True),
)

#: The picture without denoising.
NOISY = Pass("Noisy Image", 4, "RGBA", "COLOR")


def is_denoised(scene: object, view_layer: object) -> bool:
    """True if the picture of a view layer is to be denoised: by the scene's switch and the layer's. Parts that are to be merged are not."""
    cycles, of_layer = getattr(scene, "cycles", None), getattr(view_layer, "cycles", None)
    is_asked = cycles is not None and cycles.use_denoising and getattr(of_layer, "use_denoising", True)
    return bool(is_asked) and not view_layer.petzval.use_pass_mergeable


#: The pass of the light that is left on shadow catchers.
SHADOW = Pass("Shadow Catcher", 3, "RGB", "COLOR", "use_pass_shadow_catcher")


def wants_shadow(view_layer: object) -> bool:
    """True if a view layer asks for the shadow catcher pass."""
    return getattr(getattr(view_layer, "cycles", None), SHADOW.switch, False)


#: Pass indices, for masks.
INDICES = (
    Light("Object Index", "IndexOB", "X", "VALUE", "use_pass_object_index", "OBJECT_INDEX"),
    Light("Material Index", "IndexMA", "X", "VALUE", "use_pass_material_index", "MATERIAL_INDEX"),
)


#: Stray light, each part added to it already: differences, for weighing them anew.
STRAYS = (
    Pass("Ghosts", 3, "RGB", "COLOR", "use_pass_ghosts", "GHOSTS"),
    Pass("Glare", 3, "RGB", "COLOR", "use_pass_glare", "GLARE"),
    Pass("Diffraction", 3, "RGB", "COLOR", "use_pass_diffraction", "DIFFRACTION"),
)


def wanted_strays(view_layer: object) -> tuple[Pass, ...]:
    """The passes of stray light that a view layer asks for."""
    return tuple(one for one in STRAYS if getattr(view_layer.petzval, one.switch, False))


def _named(one: Light, version: tuple[int, ...]) -> Pass:
    name = one.name if version >= (5, 0, 0) or not one.old_name else one.old_name
    return Pass(name, len(one.channel_names), one.channel_names, one.kind, one.switch, one.engine_name)


def _asked(view_layer: object, list_of: tuple[Light, ...], version: tuple[int, ...]) -> tuple[Pass, ...]:
    cycles = getattr(view_layer, "cycles", None)
    asked = (one for one in list_of if getattr(cycles if one.is_of_cycles else view_layer, one.switch, False))
    return tuple(_named(one, version) for one in asked)


def of_aovs(view_layer: object) -> tuple[Pass, ...]:
    """The outputs of shaders that a view layer names, numbered in its order; those whose name is taken are left out."""
    found = []
    for number, one in enumerate(view_layer.aovs):
        channels, kind = ("X", "VALUE") if one.type == "VALUE" else ("RGBA", "COLOR")
        if one.is_valid:
            found.append(Pass(one.name, len(channels), channels, kind, "", f"AOV_{number}"))
    return tuple(found)


def wanted_parts(view_layer: object, version: tuple[int, ...]) -> tuple[Pass, ...]:
    """The passes that the engine keeps by parts of light."""
    return (*_asked(view_layer, (*SURFACE, *LIGHT, *DENOISING), version), *of_aovs(view_layer))


def engine_names(one: Pass) -> tuple[str, ...]:
    """The engine's parts that a pass is made of: three numbers each, a fourth channel is a part of its own."""
    alpha = one.engine_name.replace("AOV_", "AOV_ALPHA_")
    return (one.engine_name, alpha) if one.channels == 4 else (one.engine_name,)


def channels_of(one: Pass, job: object) -> np.ndarray:
    """A pass of a finished job, by its parts."""
    parts = [job.part(name) for name in engine_names(one)]
    return (parts[0] if len(parts) == 1 else np.concatenate(parts, axis=-1))[..., : one.channels]


def wanted_indices(view_layer: object, version: tuple[int, ...]) -> tuple[Pass, ...]:
    """The passes of indices that a view layer asks for."""
    return _asked(view_layer, INDICES, version)


#: Layers of Cryptomatte; each fills one pass for two levels.
MATTES = (
    Pass("CryptoObject", 4, "RGBA", "COLOR", "use_pass_cryptomatte_object", "OBJECT"),
    Pass("CryptoMaterial", 4, "RGBA", "COLOR", "use_pass_cryptomatte_material", "MATERIAL"),
    Pass("CryptoAsset", 4, "RGBA", "COLOR", "use_pass_cryptomatte_asset", "ASSET"),
)


#: The passes that join renders with other samples: the number of samples of a pixel, and the remainders of its sums.
MERGING = (
    Pass("Debug Sample Count", 1, "X", "VALUE", engine_name="SAMPLES"),
    Pass("Remainder", 4, "RGBA", "VECTOR", engine_name="REMAINDER"),
    Pass("Remainder Fine", 4, "RGBA", "VECTOR", engine_name="REMAINDER_FINE"),
)


def for_merging(view_layer: object, *, has_threshold: bool) -> tuple[Pass, ...]:
    """The passes for `petzval merge` that a view layer asks for. Pixels with different counts have no remainder."""
    if view_layer.petzval.use_pass_mergeable:
        return MERGING[:1] if has_threshold else MERGING
    cycles = getattr(view_layer, "cycles", None)
    return MERGING[:1] if getattr(cycles, "pass_debug_sample_count", False) else ()


def of_light_groups(view_layer: object) -> tuple[Pass, ...]:
    """A pass for the light of each group of emitters, named as Cycles names it; in the order of their numbers."""
    return tuple(Pass(f"{COMBINED.name}_{one.name}", 3, "RGB", "COLOR") for one in view_layer.lightgroups)


def wanted_mattes(view_layer: object) -> tuple[Pass, ...]:
    """The layers of Cryptomatte that a view layer asks for."""
    return tuple(one for one in MATTES if getattr(view_layer, one.switch, False))


def matte_levels(view_layer: object) -> int:
    """The number of names that a pixel of a matte holds."""
    return view_layer.pass_cryptomatte_depth


def of_matte(layer: Pass, levels: int) -> tuple[Pass, ...]:
    """The passes of a layer of Cryptomatte."""
    return tuple(layer._replace(name=f"{layer.name}{i:02}") for i in range((levels + 1) // 2))


def wanted(view_layer: object) -> tuple[Pass, ...]:
    """The passes of data that a view layer asks for."""
    return tuple(one for one in DATA if getattr(view_layer, one.switch, False))
