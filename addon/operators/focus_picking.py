# SPDX-License-Identifier: GPL-3.0-or-later
"""Focusing on a target that the user points at: an object, the 3D cursor, or a place under the mouse."""

from __future__ import annotations

import time
from dataclasses import dataclass

import bpy
import numpy as np
from bpy.props import EnumProperty, FloatVectorProperty
from bpy_extras import view3d_utils
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Vector

from ..export import camera as camera_export
from ..queries import autofocus
from .focus import LensOperator, keep

# What lies under the mouse is looked for again after so many times as long as the last look took, and not before so many seconds.
_PATIENCE, _LEAST_S = 4.0, 0.05
_HELP = "Click: focus there    Esc, right click: leave the focus as it was"
_NOTHING = "Nothing there: infinity"


@dataclass
class Target:
    """A target to focus on: a point of the picture, (0, 0) lower left; or a place of the world, seen there."""

    point: tuple[float, float]
    place: Vector | None = None


class _Finder(LensOperator):
    """Keeps the target's focus."""

    def focus(self, context, holder: bpy.types.Object, target: Target | None) -> set[str]:
        if target is None:
            self.report({"ERROR"}, "It lies behind the camera: move one of them")
            return {"CANCELLED"}
        found = find(context, holder, target)
        if "error" in found:
            self.report({"ERROR"}, found["error"])
            return {"CANCELLED"}
        said = keep(holder.data, context.scene, found)
        # By the smallest spot: the focus distance, which is that of rays near the axis, may be another.
        what = _words(found)
        self.report({"INFO"}, f"{what}: {said[0].lower()}{said[1:]}" if what else said)
        return {"FINISHED"}


def find(context: bpy.types.Context, holder: bpy.types.Object, target: Target) -> dict:
    """The focus, as `autofocus.find` has it; outside of the picture, or in its dark corners, by depth alone."""
    scene, depsgraph = context.scene, context.evaluated_depsgraph_get()
    is_in = all(0.0 <= part <= 1.0 for part in target.point)
    found = autofocus.find(holder, scene, depsgraph, point=target.point, place=target.place) if is_in else {"error": ""}
    if "error" not in found or target.place is None:
        return found
    depth = -(holder.matrix_world.normalized().inverted_safe() @ target.place).z
    scale = camera_export.scale(holder.data.petzval, scene)[2]
    return {"focus_scale_mm": depth * scale, "moves_groups": False, "subject_mm": depth * scale, "object_name": ""}


def of_place(context: bpy.types.Context, holder: bpy.types.Object, place: Vector) -> Target | None:
    """A place of the world; None: behind the camera. Where in the picture it is Blender's camera says, which is near enough: the
    place is taken for the target."""
    x, y, depth = world_to_camera_view(context.scene, holder, place)
    return Target((x, y), place) if depth > 0.0 else None


def nearest_place(context: bpy.types.Context, holder: bpy.types.Object, subject: bpy.types.Object) -> Vector | None:
    """The vertex of an object that is nearest to the camera in depth, of those in its picture; None: there is none."""
    evaluated = subject.evaluated_get(context.evaluated_depsgraph_get())
    try:
        mesh = evaluated.to_mesh()
    except RuntimeError:
        return None
    if mesh is None or not len(mesh.vertices):
        return None
    local = np.empty(len(mesh.vertices) * 3, dtype=np.float32)
    mesh.vertices.foreach_get("co", local)
    evaluated.to_mesh_clear()
    matrix = np.array(holder.matrix_world.normalized().inverted_safe() @ evaluated.matrix_world)
    seen = local.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]
    right, up = _frame_at_one(holder, context.scene)
    depth = -seen[:, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        across, high = seen[:, 0] / depth, seen[:, 1] / depth
    is_seen = (depth > holder.data.clip_start) & (across >= right[0]) & (across <= right[1]) & (high >= up[0]) & (high <= up[1])  # fmt: skip
    if not is_seen.any():
        return None
    nearest = np.where(is_seen, depth, np.inf).argmin()
    return evaluated.matrix_world @ Vector(local.reshape(-1, 3)[nearest])


def _frame_at_one(holder: bpy.types.Object, scene: bpy.types.Scene) -> tuple[tuple[float, float], tuple[float, float]]:
    """Left and right, low and high of the frame of Blender's camera, at depth one."""
    corners = [corner / -corner.z for corner in holder.data.view_frame(scene=scene)]
    xs, ys = [corner.x for corner in corners], [corner.y for corner in corners]
    return (min(xs), max(xs)), (min(ys), max(ys))


class PETZVAL_OT_focus_on_object(_Finder, bpy.types.Operator):
    """Focus exactly on the active object, as it is now"""

    bl_idname = "petzval.focus_on_object"
    bl_label = "Focus on Object"
    bl_options = {"REGISTER", "UNDO"}

    part: EnumProperty(
        name="On",
        items=(
            ("SURFACE", "Nearest Surface", "The point of it in the picture that is nearest to the camera"),
            ("ORIGIN", "Origin", "The object's origin"),
        ),
    )

    @classmethod
    def poll(cls, context):
        if not super().poll(context):
            return False
        chosen = context.active_object
        if chosen is None or chosen.type == "CAMERA":
            cls.poll_message_set("Make the object active that is to be sharp")
            return False
        return True

    def execute(self, context):
        holder = self.holder(context)
        if holder is None:
            return {"CANCELLED"}
        subject = context.active_object
        place = nearest_place(context, holder, subject) if self.part == "SURFACE" else None
        if place is None:
            place = subject.evaluated_get(context.evaluated_depsgraph_get()).matrix_world.translation.copy()
        return self.focus(context, holder, of_place(context, holder, place))


class PETZVAL_OT_focus_on_cursor(_Finder, bpy.types.Operator):
    """Focus exactly on the 3D cursor"""

    bl_idname = "petzval.focus_on_cursor"
    bl_label = "Focus on 3D Cursor"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        holder = self.holder(context)
        if holder is None:
            return {"CANCELLED"}
        return self.focus(context, holder, of_place(context, holder, context.scene.cursor.location.copy()))


class PETZVAL_OT_pick_focus(_Finder, bpy.types.Operator):
    """Click on what is to be sharp: in the camera's view and in the render it is looked for through the lens itself"""

    bl_idname = "petzval.pick_focus"
    bl_label = "Pick Focus"
    bl_options = {"REGISTER", "UNDO"}

    point: FloatVectorProperty(
        name="Point",
        description="As parts of the picture's width and height from its lower left corner",
        size=2,
        default=(0.5, 0.5),
        min=0.0,
        max=1.0,
    )

    def execute(self, context):
        holder = self.holder(context)
        return {"CANCELLED"} if holder is None else self.focus(context, holder, Target(tuple(self.point)))

    def invoke(self, context, _event):
        self._camera_name = getattr(self.holder(context), "name", None)
        if self._camera_name is None:
            return {"CANCELLED"}
        self._next_look = 0.0
        context.window.cursor_modal_set("EYEDROPPER")
        context.workspace.status_text_set(_HELP)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        holder = context.scene.objects.get(self._camera_name)
        if holder is None or event.type in {"ESC", "RIGHTMOUSE"}:
            self._leave(context)
            return {"CANCELLED"}
        if event.type == "MOUSEMOVE":
            self._say(context, holder, event)
            return {"RUNNING_MODAL"}
        if event.type == "LEFTMOUSE" and event.value == "PRESS":
            target = under_mouse(context, holder, event.mouse_x, event.mouse_y)
            if target is None:
                self.report({"INFO"}, "Click in a 3D view or on a render")
                return {"RUNNING_MODAL"}
            self._leave(context)
            self.point = tuple(min(max(part, 0.0), 1.0) for part in target.point)
            return self.focus(context, holder, target)
        # Views may be turned and zoomed meanwhile.
        return {"PASS_THROUGH"}

    def _leave(self, context) -> None:
        context.window.cursor_modal_restore()
        context.workspace.status_text_set(None)

    def cancel(self, context) -> None:
        self._leave(context)

    def _say(self, context, holder: bpy.types.Object, event) -> None:
        began = time.monotonic()
        if began < self._next_look:
            return
        target = under_mouse(context, holder, event.mouse_x, event.mouse_y)
        text = _HELP if target is None else f"{described(context, holder, target)}    |    {_HELP}"
        context.workspace.status_text_set(text)
        took = time.monotonic() - began
        self._next_look = began + took + max(_PATIENCE * took, _LEAST_S)


def described(context: bpy.types.Context, holder: bpy.types.Object, target: Target) -> str:
    """The object at a target, in words."""
    found = find(context, holder, target)
    if "error" in found:
        return found["error"] or "Outside of the picture"
    return _words(found) or _NOTHING


def _words(found: dict) -> str:
    """The sharp object and its distance, in words; empty if it is infinitely far."""
    if found["subject_mm"] is None:
        return ""
    name = f"{found['object_name']}, " if found["object_name"] else ""
    return f"{name}{found['subject_mm'] / 1000.0:.4g} m away"


def under_mouse(context: bpy.types.Context, holder: bpy.types.Object, x: int, y: int) -> Target | None:
    """The target under a pixel of the window; None: neither a picture nor a view of the scene, or nothing there."""
    for area in context.window.screen.areas:
        if not (area.x <= x < area.x + area.width and area.y <= y < area.y + area.height):
            continue
        for region in area.regions:
            if region.type != "WINDOW" or not (0 <= x - region.x < region.width and 0 <= y - region.y < region.height):
                continue
            at = (x - region.x, y - region.y)
            if area.type == "IMAGE_EDITOR":
                return _on_image(region, at)
            if area.type == "VIEW_3D":
                space = area.spaces.active
                view = space.region_3d if not space.region_quadviews else None
                return None if view is None else _in_view(context, holder, region, view, at)
    return None


def _on_image(region: bpy.types.Region, at: tuple[int, int]) -> Target | None:
    point = region.view2d.region_to_view(*at)
    return Target(point) if all(0.0 <= part <= 1.0 for part in point) else None


def _in_view(context, holder: bpy.types.Object, region, view: bpy.types.RegionView3D, at: tuple[int, int]) -> Target | None:  # fmt: skip
    if view.view_perspective == "CAMERA" and context.scene.camera == holder:
        point = picture_point(context.scene, holder, region, view, at)
        # Beside the frame nothing is in the picture.
        return point and Target(point)
    origin = view3d_utils.region_2d_to_origin_3d(region, view, at)
    direction = view3d_utils.region_2d_to_vector_3d(region, view, at)
    is_hit, place, *_ = context.scene.ray_cast(context.evaluated_depsgraph_get(), origin, direction)
    return of_place(context, holder, place) if is_hit else None


def picture_point(
    scene: bpy.types.Scene, holder: bpy.types.Object, region, view: bpy.types.RegionView3D, at: tuple[float, float]
) -> tuple[float, float] | None:
    """The picture point of a pixel of a camera view; None: beside the picture."""
    matrix = holder.matrix_world.normalized()
    corners = [
        view3d_utils.location_3d_to_region_2d(region, view, matrix @ corner)
        for corner in holder.data.view_frame(scene=scene)
    ]
    if any(corner is None for corner in corners):
        return None
    left, right = min(c.x for c in corners), max(c.x for c in corners)
    low, high = min(c.y for c in corners), max(c.y for c in corners)
    if right <= left or high <= low:
        return None
    point = (at[0] - left) / (right - left), (at[1] - low) / (high - low)
    return point if all(0.0 <= part <= 1.0 for part in point) else None


CLASSES = (PETZVAL_OT_focus_on_object, PETZVAL_OT_focus_on_cursor, PETZVAL_OT_pick_focus)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
