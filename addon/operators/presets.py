# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets as Blender keeps them: of the camera, its lens, and the sampling of a render. Those that come with Petzval lie in
`presets/`, the user's own where Blender has all of them.
"""

from __future__ import annotations

from pathlib import Path

import bpy
from bl_operators.presets import AddPresetBase

from ..settings.lens import LensProperties

_FOLDER = Path(__file__).resolve().parents[1]
#: Newer than 4.2: that has no way to be told of a folder, and panels show ours themselves.
CAN_REGISTER = hasattr(bpy.utils, "register_preset_path")

_CAMERA = 'petzval = (getattr(bpy.context, "camera", None) or bpy.context.scene.camera.data).petzval'
OF_LENS = tuple(LensProperties.__annotations__)
#: The other settings of the camera.
OF_BODY = ("film_mode", "film_width", "film_height", "anchor", "focus_relation")
OF_SAMPLING = ("samples", "use_noise_threshold", "noise_threshold", "min_samples", "use_blue_noise", "time_limit")


def shipped(kind: str) -> list[Path]:
    """The files that come with Petzval."""
    return sorted((_FOLDER / "presets" / "petzval" / kind).glob("*.py"))


class _AddPreset(AddPresetBase):
    def execute(self, context):
        if self.remove_name or self.remove_active:
            menu = getattr(bpy.types, self.preset_menu)
            name = menu.bl_label if self.remove_active else self.name
            if any(name in (file.stem, bpy.path.display_name(file.stem, title_case=False)) for file in self._ours()):
                # Blender refuses that for its own alone.
                self.report({"WARNING"}, "This preset comes with Petzval and stays")
                return {"CANCELLED"}
        done = super().execute(context)
        if done == {"FINISHED"} and not (self.remove_name or self.remove_active):
            self._make_paths_absolute(context)
        return done

    def _ours(self) -> list[Path]:
        return shipped(self.preset_subdir.rpartition("/")[2])

    def _make_paths_absolute(self, context) -> None:
        """Makes the paths of a preset absolute: one that begins with // is of this file, and a preset is for all."""
        from petzval import atomic_files

        from .common import shown_camera

        camera = shown_camera(context)
        found = bpy.utils.preset_find(self.as_filename(self.name.strip()), self.preset_subdir)
        if not found or camera is None or not camera.petzval.lens_file.startswith("//"):
            return
        kept = camera.petzval.lens_file
        whole = bpy.path.abspath(kept, library=camera.library)
        file = Path(found)
        atomic_files.write_text(file, file.read_text(encoding="utf-8").replace(repr(kept), repr(whole)))


class PETZVAL_OT_camera_preset(_AddPreset, bpy.types.Operator):
    """Add or remove a preset of a camera: its film and its lens"""

    bl_idname = "petzval.camera_preset"
    bl_label = "Camera Preset"
    preset_menu = "PETZVAL_PT_camera_presets"
    preset_subdir = "petzval/camera"
    preset_defines = (_CAMERA,)
    preset_values = tuple(f"petzval.{name}" for name in (*OF_LENS, *OF_BODY))


class PETZVAL_OT_lens_preset(_AddPreset, bpy.types.Operator):
    """Add or remove a preset of a lens: its file and how it is set"""

    bl_idname = "petzval.lens_preset"
    bl_label = "Lens Preset"
    preset_menu = "PETZVAL_PT_lens_presets"
    preset_subdir = "petzval/lens"
    preset_defines = (_CAMERA,)
    preset_values = tuple(f"petzval.{name}" for name in OF_LENS)


class PETZVAL_OT_sampling_preset(_AddPreset, bpy.types.Operator):
    """Add or remove a preset of the sampling of a render"""

    bl_idname = "petzval.sampling_preset"
    bl_label = "Sampling Preset"
    preset_menu = "PETZVAL_PT_sampling_presets"
    preset_subdir = "petzval/sampling"
    preset_defines = ("petzval = bpy.context.scene.petzval",)
    preset_values = tuple(f"petzval.{name}" for name in OF_SAMPLING)


CLASSES = (PETZVAL_OT_camera_preset, PETZVAL_OT_lens_preset, PETZVAL_OT_sampling_preset)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    if CAN_REGISTER:
        bpy.utils.register_preset_path(str(_FOLDER))


def unregister() -> None:
    if CAN_REGISTER:
        bpy.utils.unregister_preset_path(str(_FOLDER))
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
