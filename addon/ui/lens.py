# SPDX-License-Identifier: GPL-3.0-or-later
"""Camera properties: the lens, its diaphragm, focus, film and scale."""

from __future__ import annotations

import bpy

from ..lens_info import lens_info
from ..native import EngineMissing, lenses_folder
from .base import EnginePanel, settle

# Blender drops the strings of a dynamic enum that nobody holds.
_shipped: list[tuple[str, str, str]] = []


def _shipped_lenses(_self, _context):
    try:
        names = sorted(path.name for path in lenses_folder().glob("*.lens"))
    except EngineMissing:
        names = []
    _shipped[:] = [(name, name.removesuffix(".lens"), "") for name in names]
    return _shipped


class PETZVAL_OT_choose_lens(bpy.types.Operator):
    """Choose one of the lenses that come with Petzval"""

    bl_idname = "petzval.choose_lens"
    bl_label = "Choose Lens"
    bl_options = {"REGISTER", "UNDO"}
    bl_property = "lens"

    lens: bpy.props.EnumProperty(name="Lens", items=_shipped_lenses)

    @classmethod
    def poll(cls, context):
        return getattr(context, "camera", None) is not None or context.scene.camera is not None

    def invoke(self, context, _event):
        context.window_manager.invoke_search_popup(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        data = getattr(context, "camera", None) or context.scene.camera.data
        data.petzval.lens_file = self.lens
        return {"FINISHED"}


class _CameraPanel(EnginePanel):
    bl_context = "data"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.camera is not None


class _LensOnlyPanel(_CameraPanel):
    bl_parent_id = "PETZVAL_PT_lens"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.camera.petzval.model == "LENS"


class PETZVAL_PT_lens(_CameraPanel, bpy.types.Panel):
    bl_label = "Lens"

    def draw(self, context):
        layout = self.layout
        settle(layout)
        data = context.camera
        own = data.petzval
        layout.prop(own, "model")
        if own.model != "LENS":
            column = layout.column(align=True)
            column.prop(data, "lens")
            column.prop(data, "sensor_fit")
            column.prop(data, "sensor_height" if data.sensor_fit == "VERTICAL" else "sensor_width")
            column = layout.column(align=True)
            column.prop(data, "shift_x")
            column.prop(data, "shift_y")
            return
        row = layout.row(align=True)
        row.prop(own, "lens_file", text="File")
        row.operator("petzval.choose_lens", text="", icon="PRESET")
        layout.prop(own, "focal_mode")
        if own.focal_mode == "MILLIMETRES":
            layout.prop(own, "focal_length_mm", text="mm")
        elif own.focal_mode == "SCALE":
            layout.prop(own, "focal_scale")
        layout.prop(own, "use_spectrum")
        if not own.use_spectrum:
            layout.prop(own, "wavelength_nm")
        _draw_info(layout, context)


class PETZVAL_PT_aperture(_CameraPanel, bpy.types.Panel):
    bl_label = "Aperture"
    bl_parent_id = "PETZVAL_PT_lens"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.camera.petzval.model != "PINHOLE"

    def draw(self, context):
        layout = self.layout
        settle(layout)
        own = context.camera.petzval
        if own.model == "THIN":
            layout.prop(own, "wide_open", text="Blender's F-Stop", invert_checkbox=False)
            if own.wide_open:
                layout.prop(context.camera.dof, "aperture_fstop")
            else:
                layout.prop(own, "f_number")
        else:
            layout.prop(own, "wide_open")
            column = layout.column()
            column.active = not own.wide_open
            column.prop(own, "f_number")
        column = layout.column(align=True)
        column.prop(own, "blades")
        row = column.row()
        row.active = own.blades >= 3
        row.prop(own, "blade_rotation")


class PETZVAL_PT_focus(_CameraPanel, bpy.types.Panel):
    bl_label = "Focus"
    bl_parent_id = "PETZVAL_PT_lens"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.camera.petzval.model != "PINHOLE"

    def draw(self, context):
        layout = self.layout
        settle(layout)
        data = context.camera
        own = data.petzval
        layout.prop(own, "focus_mode")
        if own.focus_mode == "FOCUS":
            layout.prop(data.dof, "focus_object")
            column = layout.column()
            column.active = data.dof.focus_object is None
            column.prop(data.dof, "focus_distance")
        elif own.focus_mode == "FILM":
            layout.prop(own, "film_distance_mm")


class PETZVAL_PT_film(_LensOnlyPanel, bpy.types.Panel):
    bl_label = "Film"

    def draw(self, context):
        layout = self.layout
        settle(layout)
        own = context.camera.petzval
        column = layout.column(align=True)
        column.prop(own, "film_width_mm")
        column.prop(own, "film_height_mm")
        column = layout.column(align=True)
        column.prop(own, "tilt")
        column.prop(own, "swing")
        column = layout.column(align=True)
        column.prop(own, "shift_x_mm")
        column.prop(own, "shift_y_mm")


class PETZVAL_PT_scale(_CameraPanel, bpy.types.Panel):
    bl_label = "World to Lens"
    bl_parent_id = "PETZVAL_PT_lens"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.camera.petzval.model != "PINHOLE"

    def draw(self, context):
        layout = self.layout
        settle(layout)
        own = context.camera.petzval
        layout.prop(own, "scale_auto")
        column = layout.column(align=True)
        column.active = not own.scale_auto
        column.prop(own, "scale_locked")
        column.prop(own, "scale_x", text="mm per Unit X" if not own.scale_locked else "mm per Unit")
        if not own.scale_locked:
            column.prop(own, "scale_y", text="Y")
            column.prop(own, "scale_z", text="Z")


def _draw_info(layout, context) -> None:
    """What the lens does as it is set; or why it cannot."""
    info = lens_info(context.object, context.scene) if context.object and context.object.type == "CAMERA" else ""
    box = layout.box().column(align=True)
    if isinstance(info, str):
        box.alert = True
        for i, part in enumerate(info.split("; ") if info else ["select the camera object to see its lens"]):
            box.label(text=part, icon="ERROR" if i == 0 else "BLANK1")
        return
    box.label(text=info["lens_name"], icon="CAMERA_DATA")
    widest = f" (widest f/{info['widest_f_number']:.2f})"
    rows = [
        ("Focal length", _mm(info["efl_mm"])),
        ("In force", f"f/{info['f_number']:.2f}{widest}"),
        ("Sharp at", "infinity" if info["focus_distance_mm"] is None else f"{info['focus_distance_mm'] / 1000:.3f} m"),
        ("Film distance", _mm(info["film_distance_mm"])),
        ("Picture on film", f"{info['picture_width_mm']:.1f} x {info['picture_height_mm']:.1f} mm"),
        ("Magnification", f"{info['magnification']:.4f}"),
        ("Field of view", " x ".join(_degrees(info[f"fov_{side}_rad"]) for side in ("horizontal", "vertical"))),
    ]
    for name, text in rows:
        row = box.split(factor=0.4)
        row.label(text=name)
        row.label(text=text)
    if info["f_number_was_clamped"]:
        box.label(text="The glass allows no wider opening than this", icon="INFO")


def _mm(value: float | None) -> str:
    return "none" if value is None else f"{value:.2f} mm"


def _degrees(value: float | None) -> str:
    return "dark" if value is None else f"{value * 57.29577951308232:.1f}°"


CLASSES = (
    PETZVAL_OT_choose_lens,
    PETZVAL_PT_lens,
    PETZVAL_PT_aperture,
    PETZVAL_PT_focus,
    PETZVAL_PT_film,
    PETZVAL_PT_scale,
)
