# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own panels that stay visible while Petzval is the engine."""

from __future__ import annotations

import bpy

from .mixin import ENGINES

#: Panels of every engine that this one has a better place for, or does not do.
LEFT_OUT = {
    "DATA_PT_camera",
    "DATA_PT_camera_dof",
    "DATA_PT_lens",
    "DATA_PT_light",
    "DATA_PT_spot",
    "OBJECT_PT_visibility",
    "RENDER_PT_freestyle",
    "RENDER_PT_gpencil",
    "RENDER_PT_grease_pencil",
    "RENDER_PT_grease_pencil_render",
    "RENDER_PT_grease_pencil_viewport",
    "RENDER_PT_simplify",
    "RENDER_PT_simplify_greasepencil",
    "RENDER_PT_simplify_render",
    "RENDER_PT_simplify_viewport",
    "TEXTURE_PT_preview",
    "VIEWLAYER_PT_filter",
    "VIEWLAYER_PT_freestyle",
    "VIEWLAYER_PT_freestyle_edge_detection",
    "VIEWLAYER_PT_freestyle_edge_detection_options",
    "VIEWLAYER_PT_freestyle_style_modules",
    "VIEWLAYER_PT_freestyle_lineset",
    "VIEWLAYER_PT_layer_passes",
}
#: EEVEE's panels of settings that are the same here: material slots, previews, shadow terminators.
TAKEN_FROM_EEVEE = {
    "EEVEE_MATERIAL_PT_context_material",
    "MATERIAL_PT_preview",
    "OBJECT_PT_shadow_terminator",
}


def panels() -> list[type]:
    """The panel classes that are shared."""
    found = []
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", None)
        if not isinstance(engines, set):
            continue
        # The node editor's copy of a panel has the same set of engines.
        name = panel.__name__.removeprefix("NODE_")
        if name in TAKEN_FROM_EEVEE or ("BLENDER_RENDER" in engines and name not in LEFT_OUT):
            found.append(panel)
    return found


def register() -> None:
    for panel in panels():
        panel.COMPAT_ENGINES.update(ENGINES)


def unregister() -> None:
    for panel in panels():
        panel.COMPAT_ENGINES.difference_update(ENGINES)
