# SPDX-License-Identifier: GPL-3.0-or-later
"""The one list of passes. No bpy."""

from __future__ import annotations

from typing import NamedTuple


class Pass(NamedTuple):
    """As `RenderEngine.register_pass` takes it."""

    name: str
    channels: int
    channel_names: str
    kind: str
    #: The view layer's switch, and what the engine's `Job.data` calls it.
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


#: Layers of Cryptomatte; each fills one pass for two levels.
MATTES = (
    Pass("CryptoObject", 4, "RGBA", "COLOR", "use_pass_cryptomatte_object", "OBJECT"),
    Pass("CryptoMaterial", 4, "RGBA", "COLOR", "use_pass_cryptomatte_material", "MATERIAL"),
    Pass("CryptoAsset", 4, "RGBA", "COLOR", "use_pass_cryptomatte_asset", "ASSET"),
)


#: What joins renders with other samples: how many samples a pixel has, and what its numbers leave out of their sums.
MERGING = (
    Pass("Debug Sample Count", 1, "X", "VALUE", engine_name="SAMPLES"),
    Pass("Remainder", 4, "RGBA", "VECTOR", engine_name="REMAINDER"),
    Pass("Remainder Fine", 4, "RGBA", "VECTOR", engine_name="REMAINDER_FINE"),
)


def for_merging(view_layer: object, settings: object) -> tuple[Pass, ...]:
    """The passes for `petzval merge` that a view layer asks for. Pixels with different counts have no remainder."""
    if view_layer.petzval.use_pass_mergeable:
        return MERGING[:1] if settings.use_noise_threshold else MERGING
    cycles = getattr(view_layer, "cycles", None)
    return MERGING[:1] if getattr(cycles, "pass_debug_sample_count", False) else ()


def of_light_groups(view_layer: object) -> tuple[Pass, ...]:
    """A pass for the light of each group of emitters, named as Cycles names it; in the order of their numbers."""
    return tuple(Pass(f"{COMBINED.name}_{one.name}", 3, "RGB", "COLOR") for one in view_layer.lightgroups)


def wanted_mattes(view_layer: object) -> tuple[Pass, ...]:
    """The layers of Cryptomatte that a view layer asks for."""
    return tuple(one for one in MATTES if getattr(view_layer, one.switch, False))


def matte_levels(view_layer: object) -> int:
    """How many names a pixel of a matte holds."""
    return view_layer.pass_cryptomatte_depth


def of_matte(layer: Pass, levels: int) -> tuple[Pass, ...]:
    """The passes of a layer of Cryptomatte."""
    return tuple(layer._replace(name=f"{layer.name}{i:02}") for i in range((levels + 1) // 2))


def wanted(view_layer: object) -> tuple[Pass, ...]:
    """The passes of data that a view layer asks for."""
    return tuple(one for one in DATA if getattr(view_layer, one.switch, False))
