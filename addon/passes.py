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


COMBINED = Pass("Combined", 4, "RGBA", "COLOR")

#: Every pass that the engine fills.
PASSES = (COMBINED,)
