# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera's Lens Data panel: the numbers of the lens as it is set, from the engine."""

from __future__ import annotations

from math import degrees

import bpy

from ..data.lens_words import focus_text
from ..queries import autofocus, lens_info, viewport_camera
from .camera_parts import LensPart, fact, lines_of

#: Rows that the focus decides.
_OF_FOCUS = {"Film Distance", "Focused At", "Magnification"}


class PETZVAL_CAMERA_PT_info(LensPart, bpy.types.Panel):
    bl_options = {"DEFAULT_CLOSED"}
    bl_label = "Lens Data"

    def draw(self, context):
        camera = context.camera
        holder = viewport_camera.camera_object(camera, context.scene)
        if holder is None:
            self.layout.label(text="This camera is not in the scene", icon="INFO")
            return
        found = autofocus.for_panel(holder, context.scene, context.view_layer) if _looks(camera) else None
        answer = None if found is None or "error" in found.answer else found.answer
        info = lens_info.for_panel(holder, context.scene, answer)
        if "error" in info:
            self.layout.label(text="No data: Lens says why", icon="INFO")
            return
        column = self.layout.column(align=True)
        for line in lines_of(context, info["lens_name"]):
            column.label(text=line)
        is_open = _looks(camera) and answer is None
        for name, text in _facts(info):
            fact(column, name, "by autofocus" if is_open and name in _OF_FOCUS else text)


def _looks(camera: bpy.types.Camera) -> bool:
    return camera.petzval.focus_mode == "AUTO"


def _facts(info: dict) -> list[tuple[str, str]]:
    """Name and value of each row."""

    def number(key: str, form: str) -> str:
        value = info[key]
        return "infinite" if value is None else form.format(value)

    def angle(key: str) -> str:
        value = info[key]
        return "beyond the lens" if value is None else f"{degrees(value):.1f}°"

    zoom = info["zoom_range_mm"]
    return [
        ("Surfaces", f"{info['surfaces']}"),
        ("Focal Length", number("efl_mm", "{:.2f} mm")),
        *([("Zoom", f"{zoom[0]:.1f} to {zoom[1]:.1f} mm")] if zoom else []),
        *([("Focused By", "groups inside")] if info["focuses_inside"] else []),
        ("F-Number, at ∞", f"f/{info['f_number']:.2f}" + (", its widest" if info["f_number_was_clamped"] else "")),
        ("Widest, at ∞", f"f/{info['widest_f_number']:.2f}"),
        ("T-Number, at ∞", "dark" if info["t_number"] is None else f"T/{info['t_number']:.2f}"),
        ("Coatings", (", ".join(info["coatings"]) or "none") + (" (assumed)" if info["coating_is_assumed"] else "")),
        ("Film Distance", number("film_distance_mm", "{:.3f} mm")),
        ("Focused At", focus_text(info["focus_scale_mm"])),
        ("Magnification", number("magnification", "{:.4f}")),
        ("Field of View", f"{angle('fov_horizontal_rad')} x {angle('fov_vertical_rad')}"),
        ("Diagonal", angle("fov_diagonal_rad")),
        ("Picture", f"{info['picture_width_mm']:.2f} x {info['picture_height_mm']:.2f} mm"),
    ]
