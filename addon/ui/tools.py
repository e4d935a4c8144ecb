# SPDX-License-Identifier: GPL-3.0-or-later
"""Lens Tools: reports, exports and measurements of the camera's lens; and Petzval's entries in the 3D view's menus."""

from __future__ import annotations

import bpy

from petzval.description import OF_LENS_FILE

from ..drawing import lens_report
from ..engine import ENGINE
from ..operators import cost as cost_operator
from .camera_parts import LensPart


class PETZVAL_MT_lens_reports(bpy.types.Menu):
    bl_label = "Lens Report"

    def draw(self, _context):
        for kind, name, _ in lens_report.KINDS:
            self.layout.operator("petzval.lens_report", text=name).kind = kind


class PETZVAL_MT_lens_tools(bpy.types.Menu):
    """In the 3D view and the Object menu."""

    bl_label = "Petzval"

    def draw(self, _context):
        layout = self.layout
        layout.operator_context = "INVOKE_DEFAULT"
        layout.operator("petzval.pick_focus", icon="EYEDROPPER")
        layout.operator("petzval.focus_on_object", text="Focus on Object's Surface").part = "SURFACE"
        layout.operator("petzval.focus_on_object", text="Focus on Object's Origin").part = "ORIGIN"
        layout.operator("petzval.focus_on_cursor")
        layout.separator()
        layout.operator("petzval.match_viewport", text="Match Camera View to Lens")
        layout.operator_menu_enum("petzval.frame_like_blender", "by", text="Match Lens to Camera View")
        layout.separator()
        layout.menu(PETZVAL_MT_lens_reports.__name__)
        layout.operator("petzval.measure_costs")
        layout.separator()
        layout.operator("petzval.export_stmap")
        layout.operator("petzval.export_osl")


class PETZVAL_CAMERA_PT_tools(LensPart, bpy.types.Panel):
    bl_label = "Lens Tools"
    bl_order = 1
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = False
        layout.menu(PETZVAL_MT_lens_reports.__name__, icon="GRAPH")
        column = layout.column(align=True)
        column.operator("petzval.pick_focus", icon="EYEDROPPER")
        row = column.row(align=True)
        row.operator_menu_enum("petzval.focus_on_object", "part", text="Focus on Object")
        row.operator("petzval.focus_on_cursor", text="On 3D Cursor")
        layout.operator_menu_enum("petzval.frame_like_blender", "by", text="Match Lens to Blender's Camera")
        row = layout.row(align=True)
        row.operator("petzval.export_stmap", text="Distortion Map")
        row.operator("petzval.export_osl", text="OSL Camera")
        layout.operator("petzval.measure_costs", icon="TIME")
        found = cost_operator.last(context.scene.name)
        if found:
            _costs(layout, found)


def _costs(layout, found) -> None:
    """The time that each camera takes for the picture, and the error of its pixels."""
    from petzval.cost import page
    from petzval.cost.advice import percent, seconds

    column = layout.column(align=True)
    for row in page.cameras(found):
        line = column.split(factor=0.58)
        line.label(text=row["name"].split(":")[0].removeprefix("exact, "))
        numbers = line.row()
        numbers.alignment = "RIGHT"
        numbers.label(text=f"{seconds(row['seconds'])}, {percent(row['rel_mse'])}")


def _entry(menu, context) -> None:
    """Draws the entry at the end of Blender's own menus, while Petzval is the engine and the scene's camera has a lens."""
    holder = context.scene.camera
    if context.engine != ENGINE or holder is None or holder.type != "CAMERA":
        return
    if holder.data.petzval.model in OF_LENS_FILE:
        menu.layout.separator()
        menu.layout.menu(PETZVAL_MT_lens_tools.__name__, icon="CAMERA_DATA")


CLASSES = (PETZVAL_MT_lens_reports, PETZVAL_MT_lens_tools, PETZVAL_CAMERA_PT_tools)
_MENUS = ("VIEW3D_MT_object", "VIEW3D_MT_view_cameras")


def _blenders_menus() -> list:
    found = [getattr(bpy.types, name, None) for name in _MENUS]
    return [menu for menu in found if menu is not None]


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    for menu in _blenders_menus():
        menu.append(_entry)


def unregister() -> None:
    for menu in _blenders_menus():
        menu.remove(_entry)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
