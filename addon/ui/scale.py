# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera's Scale panel: millimetres to a Blender unit, and the size of the scene for the lens."""

from __future__ import annotations

import bpy

from ..queries import scene_size, viewport_camera
from .camera_parts import AperturePart, fact, lines_of
from .mixin import columns


class PETZVAL_CAMERA_PT_scale(AperturePart, bpy.types.Panel):
    bl_label = "Scale"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = columns(self)
        settings = context.camera.petzval
        layout.prop(settings, "scale_from_scene")
        column = layout.column(align=True)
        column.enabled = not settings.scale_from_scene
        column.prop(settings, "scale_locked")
        if settings.scale_locked:
            column.prop(settings, "scale", index=0, text="mm per Unit")
        else:
            for index, text in enumerate(("mm per Unit X", "Y", "Z")):
                column.prop(settings, "scale", index=index, text=text)
        _size(context, self.layout)


def _size(context, layout) -> None:
    holder = viewport_camera.camera_object(context.camera, context.scene)
    if holder is None:
        return
    found = scene_size.for_panel(holder, context.scene, context.view_layer)
    column = layout.column(align=True)
    # Dimmed while it is out of date.
    column.active = found is not None and found.is_current
    if found is None:
        fact(column, "Scene", "...")
        return
    units = context.scene.unit_settings
    for name, own, in_lens in (
        ("Scene", found.span, found.span_mm),
        ("Nearest in View", found.nearest, found.nearest_mm),
    ):
        fact(column, name, "nothing" if own is None else f"{length(own, units)}, {millimetres(in_lens)}")
    if found.nearest_name:
        fact(column, "", found.nearest_name)
    for warning in found.warnings:
        column = layout.column(align=True)
        for number, line in enumerate(lines_of(context, warning)):
            column.label(text=line, icon="BLANK1" if number else "ERROR")


def length(own: float, units: bpy.types.UnitSettings) -> str:
    """A length in Blender units as Blender's own fields show it."""
    if units.system == "NONE":
        return f"{own:.4g} units"
    return bpy.utils.units.to_string(
        units.system, "LENGTH", own * units.scale_length, precision=3, split_unit=units.use_separate
    )


def millimetres(value: float) -> str:
    """A length in the lens's world in words, mm, with thin spaces between thousands."""
    digits = 0 if value >= 100.0 else 1 if value >= 1.0 else 4
    return f"{value:,.{digits}f} mm".replace(",", "\u2009")
