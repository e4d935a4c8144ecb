# SPDX-License-Identifier: GPL-3.0-or-later
"""The engine as Blender calls it."""

from __future__ import annotations

import bpy

from . import loop

ENGINE_ID = "PETZVAL"


class PetzvalRenderEngine(bpy.types.RenderEngine):
    """Photographs a scene through a real lens."""

    bl_idname = ENGINE_ID
    bl_label = "Petzval"
    bl_use_preview = False
    bl_use_eevee_viewport = True
    bl_use_shading_nodes_custom = False

    # There is no __init__: Blender's own takes whatever arguments its version has.

    def render(self, depsgraph: bpy.types.Depsgraph) -> None:
        loop.render(self, depsgraph)


def register() -> None:
    bpy.utils.register_class(PetzvalRenderEngine)


def unregister() -> None:
    bpy.utils.unregister_class(PetzvalRenderEngine)
