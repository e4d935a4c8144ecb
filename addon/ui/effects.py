# SPDX-License-Identifier: GPL-3.0-or-later
"""The Effects panel: one row an effect with the user's word, the measured size, the decision and its cost."""

from __future__ import annotations

import bpy

from petzval.description import OF_LENS_FILE

from ..data.effects import EFFECTS, LABELS, camera, cost, size
from ..render import planning
from .camera_parts import lines_of
from .mixin import PetzvalPanel, columns

# Pixels of an unscaled interface: in a narrower panel words are chosen from a menu, and there is no room for costs.
_NARROW_PX = 360


class PETZVAL_RENDER_PT_effects(PetzvalPanel, bpy.types.Panel):
    bl_label = "Effects"
    bl_context = "render"

    def draw(self, context):
        layout = columns(self)
        settings = context.scene.petzval
        holder = context.scene.camera
        model = holder.data.petzval.model if holder is not None and holder.type == "CAMERA" else None
        layout.prop(settings, "quality")
        layout.operator("petzval.plan_effects", icon="VIEWZOOM")
        if model is not None and model != "LENS":
            what = "made from a lens" if model in OF_LENS_FILE else "without a lens"
            layout.label(text=f"A camera {what} by a simpler model: nothing to choose", icon="INFO")
            return
        plan = planning.last(context.scene.name)
        rows = {row["effect"]: row for row in plan["effects"]} if plan else {}
        column = self.layout.column(align=True)
        column.use_property_split = column.use_property_decorate = False
        for effect in EFFECTS:
            _row(context, column, effect, settings.effects, rows.get(effect.name))
        layout.prop(settings, "ghost_reflections")
        if plan:
            _chosen(self.layout, context, plan)


def _row(context, column, effect, settings, row) -> None:
    """Name and word; size, decision and cost where they are known."""
    is_narrow = context.region.width / context.preferences.system.ui_scale < _NARROW_PX
    icon = "BLANK1"
    if row is not None:
        icon = "CHECKMARK" if row["decision"] == "on" else "X"
        if (
            row["decision"] == "off"
            and not effect.is_available
            and row["measure"]
            and row["measure"] > row["tolerance"]
        ):
            icon = "ERROR"
    line = column.split(factor=0.55 if is_narrow else 0.36, align=True)
    name = line.row()
    name.active = effect.is_available
    name.label(text=effect.label, icon=icon)
    rest = line.split(factor=0.48, align=True)
    words = rest.row(align=True)
    words.enabled = effect.is_available
    if is_narrow:
        words.prop(settings, effect.name, text="")
    else:
        words.prop(settings, effect.name, expand=True)
    told = rest if is_narrow else rest.split(factor=0.62, align=True)
    texts = [""] if row is None else [size(row), cost(row)]
    for text in texts[:1] if is_narrow else texts:
        right = told.row()
        right.alignment = "RIGHT"
        right.label(text=text)


def _chosen(layout, context, plan) -> None:
    """The camera that follows from the decisions, and the time that it is to take."""
    column = layout.column(align=True)
    text = f"{camera(plan).capitalize()}, light followed by {plan['camera']['pipeline']}"
    predicted = plan.get("predicted")
    if predicted:
        text += f"; about {predicted['seconds']:.0f} s"
    for line in lines_of(context, text):
        column.label(text=line)


class PETZVAL_RENDER_PT_effects_why(PetzvalPanel, bpy.types.Panel):
    bl_label = "Why"
    bl_context = "render"
    bl_parent_id = "PETZVAL_RENDER_PT_effects"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and planning.last(context.scene.name) is not None

    def draw(self, context):
        column = self.layout.column(align=True)
        for row in planning.last(context.scene.name)["effects"]:
            first, *others = lines_of(context, f"{LABELS[row['effect']]}: {row['why']}")
            column.label(text=first, icon="DOT")
            for line in others:
                column.label(text=line, icon="BLANK1")


CLASSES = (PETZVAL_RENDER_PT_effects, PETZVAL_RENDER_PT_effects_why)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
