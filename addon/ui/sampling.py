# SPDX-License-Identifier: GPL-3.0-or-later
"""Render properties: sampling, and what the last render did."""

from __future__ import annotations

import bpy

from .. import loop
from .base import EnginePanel, settle


class PETZVAL_PT_sampling(EnginePanel, bpy.types.Panel):
    bl_label = "Sampling"
    bl_context = "render"

    def draw(self, context):
        layout = self.layout
        settle(layout)
        own = context.scene.petzval
        layout.prop(own, "samples")
        layout.prop(own, "max_bounces")
        layout.prop(own, "filter_width_px")
        column = layout.column(align=True)
        column.prop(own, "seed")
        column.prop(own, "sample_offset")


class PETZVAL_PT_last_render(EnginePanel, bpy.types.Panel):
    bl_label = "Last Render"
    bl_context = "render"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.scene.name in loop.last

    def draw(self, context):
        layout = self.layout
        outcome = loop.last[context.scene.name]
        if outcome.error:
            row = layout.row()
            row.alert = True
            row.label(text=outcome.error, icon="ERROR")
        if outcome.stats:
            column = layout.column(align=True)
            for part in loop.summary(outcome.stats).split("; "):
                column.label(text=part)
        for line in outcome.warnings:
            layout.label(text=line, icon="INFO")


CLASSES = (PETZVAL_PT_sampling, PETZVAL_PT_last_render)
