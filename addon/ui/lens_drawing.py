# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera's Lens Drawing panel: glass, rays, pupils and film of the lens as it is set."""

from __future__ import annotations

import bpy

from ..drawing import live_drawing
from ..queries import viewport_camera
from .camera_parts import LensPart

#: The colours of the fields' rays, as Blender has them in its icons.
_FIELD_ICONS = ("COLORSET_04_VEC", "COLORSET_03_VEC", "COLORSET_01_VEC")
# Of an unscaled interface.
_UNIT_PX = 20
# In units: what margins take of a panel's width, and the largest drawing.
_MARGIN, _MOST = 2.2, 20


class PETZVAL_CAMERA_PT_drawing(LensPart, bpy.types.Panel):
    bl_options = {"DEFAULT_CLOSED"}
    bl_label = "Lens Drawing"

    def draw(self, context):
        layout = self.layout
        holder = viewport_camera.camera_object(context.camera, context.scene)
        if holder is None:
            layout.label(text="This camera is not in the scene", icon="INFO")
            return
        unit = _UNIT_PX * context.preferences.system.ui_scale
        units = min(max(int(context.region.width / unit - _MARGIN), 4), _MOST)
        drawn = live_drawing.for_panel(holder, context.scene, context.view_layer, int(units * unit))
        if drawn is None:
            layout.label(text="...")
            return
        if drawn.error:
            layout.label(text="Nothing to draw: Lens says why", icon="INFO")
            return
        layout.template_icon(drawn.icon, scale=units)
        row = layout.row()
        # Dimmed while it is out of date.
        row.active = drawn.is_current
        for icon, (angle, is_lit) in zip(_FIELD_ICONS, drawn.fields, strict=False):
            row.label(text=f"{angle:.1f}°" if is_lit else f"{angle:.1f}° (dark)", icon=icon)
