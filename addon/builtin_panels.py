# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own panels that stay useful with this engine: meshes, materials, lights, worlds, output."""

from __future__ import annotations

import bpy

ENGINE_ID = "PETZVAL"

# Of those that all of Blender's engines share: settings that this engine has its own for, or none.
_LEFT_OUT = {
    "DATA_PT_camera_dof",
    "DATA_PT_camera_dof_aperture",
    "DATA_PT_lens",
    "DATA_PT_light",
    "DATA_PT_area",
    "DATA_PT_spot",
    "NODE_DATA_PT_light",
    "RENDER_PT_freestyle",
    "RENDER_PT_gpencil",
    "RENDER_PT_simplify",
    "VIEWLAYER_PT_filter",
    "VIEWLAYER_PT_layer_passes",
    "VIEWLAYER_PT_freestyle",
    "VIEWLAYER_PT_freestyle_edge_detection",
    "VIEWLAYER_PT_freestyle_style_modules",
}
# EEVEE's, which draw the same node trees and lamps.
_OF_EEVEE = {
    "EEVEE_MATERIAL_PT_context_material",
    "EEVEE_MATERIAL_PT_surface",
    "EEVEE_WORLD_PT_surface",
    "DATA_PT_EEVEE_light",
}
_EEVEE_IDS = {"BLENDER_EEVEE", "BLENDER_EEVEE_NEXT"}


def _panels():
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", None)
        if engines is None:
            continue
        shared = "BLENDER_RENDER" in engines and panel.__name__ not in _LEFT_OUT
        if shared or (panel.__name__ in _OF_EEVEE and engines & _EEVEE_IDS):
            yield panel


def register() -> None:
    for panel in _panels():
        panel.COMPAT_ENGINES.add(ENGINE_ID)


def unregister() -> None:
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", None)
        # This add-on's own panels have a set of their own, which goes with them.
        if engines is not None and engines != {ENGINE_ID}:
            engines.discard(ENGINE_ID)
