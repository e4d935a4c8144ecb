# SPDX-License-Identifier: GPL-3.0-or-later
"""The one check of the engine that every panel shares."""

from __future__ import annotations

from ..engine import ENGINE

ENGINES = {ENGINE}


class PetzvalPanel:
    """A mixin of panels that show while Petzval is the engine."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    COMPAT_ENGINES = ENGINES

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES


def columns(panel) -> object:
    """The panel's layout as Blender's own property panels have it."""
    layout = panel.layout
    layout.use_property_split = True
    layout.use_property_decorate = True
    return layout
