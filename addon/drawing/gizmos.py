# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles in 3D views: the focus distance of a camera that is selected, on its axis."""

from __future__ import annotations

import bpy
from bpy_extras.view3d_utils import region_2d_to_origin_3d, region_2d_to_vector_3d
from mathutils import Matrix, Vector
from mathutils.geometry import intersect_line_line

from petzval.description import OF_LENS_FILE

from ..engine import ENGINE

_COLOR, _BRIGHT = (0.2, 0.85, 0.35), (0.6, 1.0, 0.7)
#: The least distance of the focus gizmo, Blender units.
_NEAREST = 1e-3


def _focuses_by_distance(camera: bpy.types.Camera) -> bool:
    own = camera.petzval
    return own.model in (*OF_LENS_FILE, "THIN") and own.focus_mode == "CAMERA" and camera.dof.focus_object is None


def _axis(holder: bpy.types.Object) -> tuple[Vector, Vector]:
    """The position of a camera in the world, and the direction it looks in, a unit vector: a camera's own scale has no effect."""
    return holder.matrix_world.translation, holder.matrix_world.to_quaternion() @ Vector((0.0, 0.0, -1.0))


class PETZVAL_GT_focus(bpy.types.Gizmo):
    """A ring on the axis that is dragged along it"""

    bl_idname = "PETZVAL_GT_focus"
    bl_target_properties = ({"id": "distance", "type": "FLOAT", "array_length": 1},)

    def draw(self, _context):
        self.draw_preset_circle(self.matrix_world)

    def draw_select(self, _context, select_id):
        self.draw_preset_circle(self.matrix_world, select_id=select_id)

    def invoke(self, _context, _event):
        self._before = self.target_get_value("distance")
        return {"RUNNING_MODAL"}

    def exit(self, context, cancel):
        context.area.header_text_set(None)
        if cancel:
            self.target_set_value("distance", self._before)

    def modal(self, context, event, _tweak):
        mouse = event.mouse_region_x, event.mouse_region_y
        origin = region_2d_to_origin_3d(context.region, context.region_data, mouse)
        ray = region_2d_to_vector_3d(context.region, context.region_data, mouse)
        place, forward = _axis(context.object)
        met = intersect_line_line(place, place + forward, origin, origin + ray)
        if met is not None:
            distance = max((met[0] - place).dot(forward), _NEAREST)
            self.target_set_value("distance", distance)
            context.area.header_text_set(f"Focus distance {distance:.3f}")
        return {"RUNNING_MODAL"}


class PETZVAL_GGT_focus(bpy.types.GizmoGroup):
    """The focus distance, to be dragged along the camera's axis"""

    bl_idname = "PETZVAL_GGT_focus"
    bl_label = "Focus Distance"
    bl_space_type = "VIEW_3D"
    bl_region_type = "WINDOW"
    bl_options = {"3D", "PERSISTENT", "SHOW_MODAL_ALL"}

    @classmethod
    def poll(cls, context):
        holder = context.object
        return (
            context.scene.render.engine == ENGINE
            and holder is not None
            and holder.type == "CAMERA"
            and holder.select_get()
            and holder.data.petzval.show_focus
            and not holder.data.library
            and _focuses_by_distance(holder.data)
        )

    def setup(self, context):
        ring = self.gizmos.new(PETZVAL_GT_focus.bl_idname)
        ring.color, ring.alpha = _COLOR, 0.9
        ring.color_highlight, ring.alpha_highlight = _BRIGHT, 1.0
        ring.line_width, ring.scale_basis = 3.0, 0.25
        ring.use_draw_modal = True
        self._ring = ring
        self.refresh(context)

    def refresh(self, context):
        self._ring.target_set_prop("distance", context.object.data.dof, "focus_distance")

    def draw_prepare(self, context):
        holder = context.object
        place, forward = _axis(holder)
        at = place + forward * holder.data.dof.focus_distance
        self._ring.matrix_basis = Matrix.LocRotScale(at, holder.matrix_world.to_quaternion(), None)


CLASSES = (PETZVAL_GT_focus, PETZVAL_GGT_focus)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
