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
)


def wanted(view_layer: object) -> tuple[Pass, ...]:
    """The passes of data that a view layer asks for."""
    return tuple(one for one in DATA if getattr(view_layer, one.switch, False))
