# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera's Focus panel: by hand, by autofocus, by three points."""

from __future__ import annotations

import bpy

from petzval.description import OF_LENS_FILE

from ..data.lens_words import focus_text
from ..operators.focus import SHARP_OBJECTS
from ..queries import autofocus, viewport_camera
from .camera_parts import AperturePart, LensPart, complain, fact
from .mixin import columns


class PETZVAL_CAMERA_PT_focus(AperturePart, bpy.types.Panel):
    bl_label = "Focus"
    of_blur = True

    def draw(self, context):
        layout = columns(self)
        camera = context.camera
        settings = camera.petzval
        is_lens = settings.model in OF_LENS_FILE
        mode = settings.focus_mode
        layout.prop(settings, "focus_mode")
        if is_lens and mode == "FILM":
            layout.prop(settings, "film_distance")
        elif is_lens and mode == "AUTO":
            _autofocus(context, layout)
        elif mode != "INFINITY":
            # A thin lens has no film to move: it takes the distance.
            _by_hand(layout, camera)
        if is_lens:
            layout.prop(settings, "anchor")
            row = layout.row()
            row.active = mode == "CAMERA" and camera.dof.focus_object is None
            row.prop(settings, "focus_relation")
            row = layout.row(heading="In 3D Views", align=True)
            row.prop(settings, "show_focus", text="")
            part = row.row()
            part.active = settings.show_focus
            part.prop(settings, "confusion", text="Confusion (mm)")


def _by_hand(layout, camera: bpy.types.Camera) -> None:
    dof = camera.dof
    layout.prop(dof, "focus_object", text="Object")
    if dof.focus_object is not None and dof.focus_object.type == "ARMATURE":
        layout.prop_search(dof, "focus_subtarget", dof.focus_object.data, "bones", text="Bone")
    row = layout.row()
    row.active = dof.focus_object is None
    row.prop(dof, "focus_distance", text="Distance")


def _autofocus(context, layout) -> None:
    settings = context.camera.petzval
    column = layout.column(align=True)
    column.prop(settings, "autofocus_point", index=0, text="Point X")
    column.prop(settings, "autofocus_point", index=1, text="Y")
    holder = viewport_camera.camera_object(context.camera, context.scene)
    found = autofocus.for_panel(holder, context.scene, context.view_layer) if holder is not None else None
    facts = layout.column(align=True)
    # Dimmed while it is out of date.
    facts.active = found is not None and found.is_current
    if found is None:
        fact(facts, "Finds", "...")
    elif "error" in found.answer:
        complain(context, facts, found.answer["error"])
    else:
        fact(facts, "Finds", found.answer["object_name"] or "nothing")
        fact(facts, "At", focus_text(found.answer["subject_mm"]))
        # By exact rays: aberrations move the sharpest film from where first order has it.
        fact(facts, "As Focus Distance", focus_text(found.answer["focus_scale_mm"]))
        fact(facts, "Spot", f"{found.answer['rms_spot_mm']:.3f} mm")
    layout.operator("petzval.focus_here")


class PETZVAL_CAMERA_PT_sharp(LensPart, bpy.types.Panel):
    bl_label = "Three Sharp Points"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = columns(self)
        settings = context.camera.petzval
        column = layout.column(align=True)
        for name in SHARP_OBJECTS:
            column.prop(settings, name)
        row = layout.row(align=True)
        row.operator("petzval.sharp_from_selection")
        row.operator("petzval.sharp_points")
