# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera's Lens panel with its parts."""

from __future__ import annotations

from math import degrees

import bpy

from .. import film_formats, lens_info, viewport_camera
from ..description import OF_LENS_FILE
from .mixin import PetzvalPanel, columns


class _CameraPanel(PetzvalPanel):
    bl_context = "data"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.camera is not None


class _LensPart(_CameraPanel):
    """A part that only a real lens has."""

    bl_parent_id = "PETZVAL_CAMERA_PT_lens"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.camera.petzval.model in OF_LENS_FILE


class _AperturePart(_CameraPanel):
    """A part that a thin lens has too."""

    bl_parent_id = "PETZVAL_CAMERA_PT_lens"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.camera.petzval.model != "PINHOLE"


class PETZVAL_CAMERA_PT_lens(_CameraPanel, bpy.types.Panel):
    bl_label = "Lens"

    def draw(self, context):
        layout = columns(self)
        camera = context.camera
        settings = camera.petzval
        layout.prop(settings, "model")
        if settings.model not in OF_LENS_FILE:
            layout.prop(camera, "lens")
            return
        row = layout.row(align=True)
        row.prop(settings, "lens_file")
        row.operator("petzval.choose_lens", text="", icon="VIEWZOOM")
        layout.prop(settings, "focal_mode")
        if settings.focal_mode == "LENGTH":
            layout.prop(settings, "focal_length")
        elif settings.focal_mode == "SCALE":
            layout.prop(settings, "focal_scale")
        layout.prop(settings, "spectrum")
        if settings.spectrum == "SINGLE":
            layout.prop(settings, "wavelength")


class PETZVAL_CAMERA_PT_info(_LensPart, bpy.types.Panel):
    bl_label = "Lens Data"

    def draw(self, context):
        holder = viewport_camera.camera_object(context.camera, context.scene)
        if holder is None:
            self.layout.label(text="This camera is not in the scene", icon="INFO")
            return
        info = lens_info.of_camera(holder, context.scene)
        if "error" in info:
            _complain(self.layout, info["error"], _characters(context))
            return
        column = self.layout.column(align=True)
        column.label(text=f"{info['lens_name']}, {info['surfaces']} surfaces")
        for name, text in _facts(info):
            row = column.split(factor=0.45)
            row.alignment = "RIGHT"
            row.label(text=name)
            row.label(text=text)


# Of an unscaled interface: what a character of a label takes in the mean, and what icon and margins take of a line.
_CHARACTER_PX, _MARGIN_PX = 7, 60


def _characters(context) -> int:
    """About how many characters the panel shows in a line."""
    width = context.region.width / context.preferences.system.ui_scale
    return max(int((width - _MARGIN_PX) / _CHARACTER_PX), 16)


def _complain(layout, text: str, line_characters: int) -> None:
    """The engine's complaint in red, broken where it must be."""
    column = layout.column(align=True)
    column.alert = True
    line, icon = "", "ERROR"
    for word in text.split():
        if line and len(line) + len(word) >= line_characters:
            column.label(text=line, icon=icon)
            line, icon = "", "BLANK1"
        line = f"{line} {word}".strip()
    column.label(text=line, icon=icon)


def _facts(info: dict) -> list[tuple[str, str]]:
    """Name and value of each row."""

    def number(key: str, form: str) -> str:
        value = info[key]
        return "infinite" if value is None else form.format(value)

    def angle(key: str) -> str:
        value = info[key]
        return "beyond the lens" if value is None else f"{degrees(value):.1f}°"

    return [
        ("Focal Length", number("efl_mm", "{:.2f} mm")),
        ("F-Number", f"f/{info['f_number']:.2f}, widest f/{info['widest_f_number']:.2f}"),
        ("Film Distance", number("film_distance_mm", "{:.3f} mm")),
        ("Focused At", number("focus_scale_mm", "{:.0f} mm")),
        ("Magnification", number("magnification", "{:.4f}")),
        ("Field of View", f"{angle('fov_horizontal_rad')} x {angle('fov_vertical_rad')}"),
        ("Diagonal", angle("fov_diagonal_rad")),
        ("Picture", f"{info['picture_width_mm']:.2f} x {info['picture_height_mm']:.2f} mm"),
    ]


class PETZVAL_CAMERA_PT_aperture(_AperturePart, bpy.types.Panel):
    bl_label = "Aperture"

    def draw(self, context):
        layout = columns(self)
        camera = context.camera
        settings = camera.petzval
        if settings.model in OF_LENS_FILE:
            layout.prop(settings, "wide_open")
        else:
            layout.prop(settings, "wide_open", text="Blender's F-Stop")
        if not settings.wide_open:
            layout.prop(settings, "f_number")
        elif settings.model == "THIN":
            layout.prop(camera.dof, "aperture_fstop")
        column = layout.column(align=True)
        column.prop(settings, "blades")
        column.prop(settings, "blade_rotation")
        column.prop(settings, "blade_curvature")
        column.template_ID(settings, "aperture_mask", open="image.open", text="Mask")


class PETZVAL_CAMERA_PT_exposure(_AperturePart, bpy.types.Panel):
    bl_label = "Physical Exposure"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context):
        self.layout.prop(context.camera.petzval, "physical_exposure", text="")

    def draw(self, context):
        layout = columns(self)
        settings = context.camera.petzval
        layout.active = settings.physical_exposure
        layout.prop(settings, "shutter")
        layout.prop(settings, "iso")
        layout.prop(settings, "lumens_per_watt")


class PETZVAL_CAMERA_PT_focus(_AperturePart, bpy.types.Panel):
    bl_label = "Focus"

    def draw(self, context):
        layout = columns(self)
        camera = context.camera
        settings, dof = camera.petzval, camera.dof
        layout.prop(settings, "focus_mode")
        if settings.model in OF_LENS_FILE:
            layout.prop(settings, "anchor")
            layout.prop(settings, "focus_relation")
        if settings.focus_mode == "FILM":
            layout.prop(settings, "film_distance")
        elif settings.focus_mode == "AUTO":
            layout.prop(settings, "autofocus_point")
        elif settings.focus_mode == "CAMERA":
            layout.prop(dof, "focus_object", text="Object")
            if dof.focus_object is not None and dof.focus_object.type == "ARMATURE":
                layout.prop_search(dof, "focus_subtarget", dof.focus_object.data, "bones", text="Bone")
            row = layout.row()
            row.active = dof.focus_object is None
            row.prop(dof, "focus_distance", text="Distance")


class PETZVAL_CAMERA_PT_film(_LensPart, bpy.types.Panel):
    bl_label = "Film & Movements"

    def draw(self, context):
        layout = columns(self)
        camera = context.camera
        settings = camera.petzval
        layout.prop(settings, "film_mode")
        column = layout.column(align=True)
        if settings.film_mode == "SIZE":
            film = film_formats.of_size(settings.film_width, settings.film_height)
            column.operator_menu_enum("petzval.choose_film", "film", text=film.title if film else "Formats")
            column.prop(settings, "film_width")
            column.prop(settings, "film_height")
        else:
            column.prop(camera, "sensor_fit")
            column.prop(camera, "sensor_height" if camera.sensor_fit == "VERTICAL" else "sensor_width", text="Size")
        column = layout.column(align=True)
        column.prop(settings, "tilt")
        column.prop(settings, "swing")
        column = layout.column(align=True)
        column.prop(settings, "shift_x")
        column.prop(settings, "shift_y")
        layout.prop(settings, "match_viewport")
        layout.operator("petzval.match_viewport")


class PETZVAL_CAMERA_PT_scale(_AperturePart, bpy.types.Panel):
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
            column.prop(settings, "scale", index=0, text="Millimetres a Unit")
        else:
            column.prop(settings, "scale")


CLASSES = (
    PETZVAL_CAMERA_PT_lens,
    PETZVAL_CAMERA_PT_info,
    PETZVAL_CAMERA_PT_aperture,
    PETZVAL_CAMERA_PT_exposure,
    PETZVAL_CAMERA_PT_focus,
    PETZVAL_CAMERA_PT_film,
    PETZVAL_CAMERA_PT_scale,
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
