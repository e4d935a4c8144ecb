# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera's lens for other programs: distortion maps for compositing, a camera for Cycles."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, StringProperty
from bpy_extras.io_utils import ExportHelper

from petzval.description import CameraDescription, focused

from ..export import aperture_mask
from ..export import camera as camera_export
from ..export.errors import ExportError
from ..export.report import Report
from ..native import engine
from ..queries import autofocus
from .common import result_of
from .focus import LensOperator


def described(
    holder: bpy.types.Object, scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph
) -> tuple[CameraDescription, tuple[int, int]]:
    """The camera as it is set and focused now, and the picture's pixels. Raises `ExportError`."""
    size = camera_export.resolution(scene.render)
    camera = aperture_mask.added(camera_export.describe(holder, scene, *size, Report()), holder.data)
    if camera.focus.autofocus is not None:
        found = autofocus.find(holder, scene, depsgraph)
        if "error" in found:
            raise ExportError(found["error"])
        camera = focused(camera, found)
    return camera, size


class PETZVAL_OT_export_stmap(LensOperator, ExportHelper, bpy.types.Operator):
    """Write where each pixel of one picture lies in the other, the lens's and a perspective camera's of the same framing: for a
    compositor's Map UV or STMap node"""

    bl_idname = "petzval.export_stmap"
    bl_label = "Export Distortion Map"

    filename_ext = ".exr"
    filter_glob: StringProperty(default="*.exr", options={"HIDDEN"})
    direction: EnumProperty(
        name="Direction",
        items=(
            ("UNDISTORT", "Undistort", "Makes the lens's picture that of a perspective camera"),
            ("DISTORT", "Distort", "Makes a perspective camera's picture that of the lens"),
        ),
    )
    wavelength: FloatProperty(
        name="Wavelength", description="Of the rays", default=587.5618, min=380.0, max=780.0, subtype="WAVELENGTH"
    )
    colours: BoolProperty(
        name="Colours", description="A layer for red, green and blue each, for lateral colour", default=False
    )

    def execute(self, context):
        holder = self.holder(context)
        if holder is None:
            return {"CANCELLED"}

        def write() -> float:
            native = engine()
            from petzval.distortion_maps import COLOURS_NM, note

            camera, size = described(holder, context.scene, context.evaluated_depsgraph_get())
            maps = [("", self.wavelength), *(COLOURS_NM if self.colours else ())]
            comments = note(native.Lens(camera.lens_path).name, self.direction.lower(), self.wavelength)
            out = bpy.path.abspath(self.filepath)
            return native.write_distortion_map(camera, *size, maps, self.direction, comments, out)[0]

        share = result_of(self, write)
        if share is None:
            return {"CANCELLED"}
        self.report({"INFO"}, f"{self.filepath}: {100.0 * share:.1f} % of its pixels have a source")
        return {"FINISHED"}


class PETZVAL_OT_export_osl(LensOperator, ExportHelper, bpy.types.Operator):
    """Write the lens as a camera that Cycles can use, Blender 4.5 or later: every camera ray is traced through the surfaces"""

    bl_idname = "petzval.export_osl"
    bl_label = "Export OSL Camera"

    filename_ext = ".osl"
    filter_glob: StringProperty(default="*.osl", options={"HIDDEN"})
    assign: BoolProperty(
        name="Use It Here",
        description="Set this camera to take its picture by the script when Cycles renders",
        default=False,
    )

    def execute(self, context):
        holder = self.holder(context)
        if holder is None:
            return {"CANCELLED"}

        def write() -> str:
            from petzval import atomic_files

            camera, size = described(holder, context.scene, context.evaluated_depsgraph_get())
            text = engine().osl_camera(camera, *size)
            out = Path(bpy.path.abspath(self.filepath))
            try:
                atomic_files.write_text(out, text)
            except OSError as error:
                raise ExportError(f"cannot write {out}: {error.strerror or error}: choose another place") from None
            return str(out)

        path = result_of(self, write)
        if path is None:
            return {"CANCELLED"}
        if self.assign and not _assign(holder.data, path):
            self.report({"WARNING"}, f"{path} is written; cameras of scripts need Blender 4.5")
            return {"FINISHED"}
        self.report({"INFO"}, path)
        return {"FINISHED"}


def _assign(camera: bpy.types.Camera, path: str) -> bool:
    """Assigns the script to the camera; False if this Blender has no such cameras."""
    if not hasattr(camera, "custom_filepath"):
        return False
    camera.type, camera.custom_mode, camera.custom_filepath = "CUSTOM", "EXTERNAL", path
    return True


CLASSES = (PETZVAL_OT_export_stmap, PETZVAL_OT_export_osl)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
