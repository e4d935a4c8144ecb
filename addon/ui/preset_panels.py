# SPDX-License-Identifier: GPL-3.0-or-later
"""The popovers in which presets are chosen, added and removed."""

from __future__ import annotations

import bpy
from bl_ui.utils import PresetPanel

from ..operators import presets as preset_operators
from .mixin import ENGINES


class _Presets(PresetPanel):
    COMPAT_ENGINES = ENGINES
    preset_operator = "script.execute_preset"

    def draw(self, context):
        if not preset_operators.CAN_REGISTER:
            column = self.layout.column(align=True)
            for file in preset_operators.shipped(self.preset_subdir.rpartition("/")[2]):
                name = bpy.path.display_name(file.stem, title_case=False)
                load = column.operator(self.preset_operator, text=name, emboss=False)
                load.filepath, load.menu_idname = str(file), type(self).__name__
        PresetPanel.draw(self, context)


class PETZVAL_PT_camera_presets(_Presets, bpy.types.Panel):
    bl_label = "Camera Presets"
    preset_subdir = preset_operators.PETZVAL_OT_camera_preset.preset_subdir
    preset_add_operator = preset_operators.PETZVAL_OT_camera_preset.bl_idname


class PETZVAL_PT_lens_presets(_Presets, bpy.types.Panel):
    bl_label = "Lens Presets"
    preset_subdir = preset_operators.PETZVAL_OT_lens_preset.preset_subdir
    preset_add_operator = preset_operators.PETZVAL_OT_lens_preset.bl_idname


class PETZVAL_PT_sampling_presets(_Presets, bpy.types.Panel):
    bl_label = "Sampling Presets"
    preset_subdir = preset_operators.PETZVAL_OT_sampling_preset.preset_subdir
    preset_add_operator = preset_operators.PETZVAL_OT_sampling_preset.bl_idname


CLASSES = (PETZVAL_PT_camera_presets, PETZVAL_PT_lens_presets, PETZVAL_PT_sampling_presets)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
