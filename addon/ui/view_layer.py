# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of the view layer."""

from __future__ import annotations

import bpy

from .. import passes
from .mixin import PetzvalPanel, columns


class PETZVAL_VIEW_LAYER_PT_passes(PetzvalPanel, bpy.types.Panel):
    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context):
        layout = columns(self)
        column = layout.column(heading="Data")
        for one in passes.DATA:
            column.prop(context.view_layer, one.switch, text=one.name)
        column = layout.column(heading="Cryptomatte")
        for one in passes.MATTES:
            column.prop(context.view_layer, one.switch, text=one.name.removeprefix("Crypto"))
        column.prop(context.view_layer, "pass_cryptomatte_depth", text="Levels")


CLASSES = (PETZVAL_VIEW_LAYER_PT_passes,)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
