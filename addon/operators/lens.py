# SPDX-License-Identifier: GPL-3.0-or-later
"""The buttons of the Lens panel for lens files: favourites, and lens files of other programs."""

from __future__ import annotations

import bpy
from bpy.props import StringProperty

from ..data import favourites, lens_files
from ..native import EngineMissing, engine
from .common import shown_camera

#: The endings of lens files that the engine reads: its own, Zemax, CODE V, OSLO, pbrt, and tables of the Optical Bench.
ENDINGS = (".lens", ".zmx", ".seq", ".len", ".dat", ".txt")
# More lines would fill the screen.
_MOST_REMARKS = 4


def _is_free(context: bpy.types.Context) -> bool:
    camera = shown_camera(context)
    return camera is not None and not camera.library


class PETZVAL_OT_favourite_lens(bpy.types.Operator):
    """Add this lens to your favourites, which stand on top of the menu of lenses, or take it away from them"""

    bl_idname = "petzval.favourite_lens"
    bl_label = "Favourite Lens"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context):
        camera = shown_camera(context)
        return camera is not None and bool(camera.petzval.lens_file.strip())

    def execute(self, context):
        camera = shown_camera(context)
        try:
            favourites.toggle(favourites.key(camera.petzval.lens_file, camera.library))
        except OSError as error:
            self.report({"ERROR"}, f"Favourites cannot be kept: {error}")
            return {"CANCELLED"}
        return {"FINISHED"}


class PETZVAL_OT_set_lens(bpy.types.Operator):
    """Give the camera this lens"""

    bl_idname = "petzval.set_lens"
    bl_label = "Set Lens"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    lens: StringProperty(
        name="Lens", description="Name of a lens that comes with Petzval, or a path", options={"SKIP_SAVE"}
    )

    @classmethod
    def poll(cls, context):
        return _is_free(context)

    @classmethod
    def description(cls, _context, properties):
        try:
            entry = lens_files.entry_of(properties.lens)
        except EngineMissing as error:
            return str(error)
        return properties.lens if entry is None else f"{entry['name']}: {lens_files.description(entry)}"

    def execute(self, context):
        shown_camera(context).petzval.lens_file = self.lens
        return {"FINISHED"}


class PETZVAL_OT_import_lens(bpy.types.Operator):
    """Give the camera a lens from a file: .lens, Zemax .zmx, CODE V .seq, OSLO .len, pbrt .dat, or a table of the Optical Bench"""

    bl_idname = "petzval.import_lens"
    bl_label = "Import Lens File"
    bl_options = {"REGISTER", "UNDO"}

    filepath: StringProperty(name="File", description="The lens file", subtype="FILE_PATH", options={"SKIP_SAVE"})
    filter_glob: StringProperty(default=";".join(f"*{ending}" for ending in ENDINGS), options={"HIDDEN"})

    @classmethod
    def poll(cls, context):
        return _is_free(context)

    def invoke(self, context, _event):
        if self.filepath:
            # Dropped into the window.
            return self.execute(context)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        path = bpy.path.abspath(self.filepath)
        try:
            lens = engine().Lens(path)
        except EngineMissing as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        except engine().PetzvalError as error:
            self.report({"ERROR"}, " ".join(str(error).split()))
            return {"CANCELLED"}
        is_relative = bpy.data.is_saved and context.preferences.filepaths.use_relative_paths
        try:
            kept = bpy.path.relpath(path) if is_relative else path
        except ValueError:
            # On another drive.
            kept = path
        camera = shown_camera(context)
        camera.petzval.lens_file = kept
        remarks = lens.remarks
        for remark in remarks[:_MOST_REMARKS]:
            self.report({"WARNING"}, remark)
        if len(remarks) > _MOST_REMARKS:
            self.report({"WARNING"}, f"{len(remarks) - _MOST_REMARKS} more remarks: petzval lens check")
        self.report({"INFO"}, f"{lens.name}: {lens.surface_count} surfaces")
        return {"FINISHED"}


class PETZVAL_FH_lens(bpy.types.FileHandler):
    """A lens file dropped into the 3D view or the properties is the camera's"""

    bl_idname = "PETZVAL_FH_lens"
    bl_label = "Lens"
    bl_import_operator = "petzval.import_lens"
    # Those that nothing else has: `.dat` and `.txt` may be anything.
    bl_file_extensions = ".lens;.zmx;.seq"

    @classmethod
    def poll_drop(cls, context):
        return context.area is not None and context.area.type in {"VIEW_3D", "PROPERTIES"} and _is_free(context)


CLASSES = (PETZVAL_OT_favourite_lens, PETZVAL_OT_set_lens, PETZVAL_OT_import_lens, PETZVAL_FH_lens)


def _in_menu(menu, _context) -> None:
    menu.layout.operator(PETZVAL_OT_import_lens.bl_idname, text="Lens (.lens, .zmx, .seq, .len, .dat)")


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.TOPBAR_MT_file_import.append(_in_menu)


def unregister() -> None:
    bpy.types.TOPBAR_MT_file_import.remove(_in_menu)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
