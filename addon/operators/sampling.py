# SPDX-License-Identifier: GPL-3.0-or-later
"""The Sampling panels' buttons: they choose Petzval's own settings of the number of samples, or Cycles'."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty

from ..export import sampling

_OF = {"RENDER": sampling.OF_RENDER, "VIEW": sampling.OF_VIEW}


class _Operator(bpy.types.Operator):
    bl_options = {"REGISTER", "UNDO"}

    of: EnumProperty(
        name="Of",
        description="Of which pictures",
        items=(
            ("RENDER", "Render", "Final renders", "", 0),
            ("VIEW", "View", "3D views in rendered shading", "", 1),
        ),
    )

    @classmethod
    def poll(cls, context):
        return hasattr(context.scene, "cycles")


class PETZVAL_OT_own_sampling(_Operator):
    """Give Petzval settings of its own, which begin as those of Cycles are. They mean nothing to Cycles"""

    bl_idname = "petzval.own_sampling"
    bl_label = "Set Petzval's Own"

    def execute(self, context):
        sampling.make_own(context.scene, _OF[self.of])
        return {"FINISHED"}


class PETZVAL_OT_cycles_sampling(_Operator):
    """Forget the settings of Petzval's own: those of Cycles count"""

    bl_idname = "petzval.cycles_sampling"
    bl_label = "As Set for Cycles"

    def execute(self, context):
        sampling.follow_cycles(context.scene, _OF[self.of])
        return {"FINISHED"}


CLASSES = (PETZVAL_OT_own_sampling, PETZVAL_OT_cycles_sampling)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
