# SPDX-License-Identifier: GPL-3.0-or-later
"""What this engine's panels have in common."""

from __future__ import annotations

ENGINE_ID = "PETZVAL"


class EnginePanel:
    """Shown only while Petzval is the render engine."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    COMPAT_ENGINES = {ENGINE_ID}

    @classmethod
    def poll(cls, context):
        return context.engine == ENGINE_ID


def settle(layout) -> None:
    """Blender's usual two columns."""
    layout.use_property_split = True
    layout.use_property_decorate = True
