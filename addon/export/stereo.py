# SPDX-License-Identifier: GPL-3.0-or-later
"""Views of a scene in stereo or multiview: the camera of each, and its place.

Rules and names are Blender's (`BKE_camera_multiview_*` in blenkernel/intern/camera.cc).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import bpy
from mathutils import Matrix

from petzval.description import OF_LENS_FILE, SphericalStereo

#: Blender's name of the view of the right eye; where no view is named it takes the left one.
RIGHT = "right"


class View(NamedTuple):
    """One of a render's views."""

    #: The view's name; empty where there is one alone.
    name: str
    index: int
    count: int


#: The view of a render without stereo.
ONLY = View("", 0, 1)


@dataclass(frozen=True)
class Eye:
    """A camera as one view has it."""

    #: The camera's object.
    holder: bpy.types.Object
    #: The matrix of the camera, moved aside and turned as its stereo settings say.
    matrix: Matrix
    #: Blender's own shift of its picture, with that of the convergence plane.
    shift_x: float
    #: The shift of a real lens: tangent of the angle between its axis and the middle of its picture, to the right.
    turn: float = 0.0
    #: The eye of each ray in spherical stereo; None: one eye for all rays.
    spherical: SphericalStereo | None = None


def eye_of_render(host: bpy.types.RenderEngine, scene: bpy.types.Scene, view: View) -> Eye | None:
    """The eye of a render's view, in the scene's frame; None without a camera."""
    if view.name:
        host.active_view_set(view.name)
    holder = host.camera_override or scene.camera
    if holder is None or holder.type != "CAMERA":
        return None
    is_spherical = host.use_spherical_stereo(holder) and not is_of_lens(holder.data)
    is_left = view.name != RIGHT
    return Eye(
        holder,
        host.camera_model_matrix(holder, use_spherical_stereo=is_spherical),
        host.camera_shift_x(holder, use_spherical_stereo=is_spherical),
        0.0 if is_spherical else turn(holder.data, scene.render, view.name),
        spherical(holder.data.stereo, is_left=is_left) if is_spherical else None,
    )


def is_of_lens(camera: bpy.types.Camera) -> bool:
    """True if a lens takes the picture: it does not turn with each of its rays, as spherical stereo would have it."""
    return camera.type == "PERSP" and camera.petzval.model in OF_LENS_FILE


def is_pair(render: bpy.types.RenderSettings) -> bool:
    """True if the views are those of two eyes of one camera."""
    return render.use_multiview and render.views_format == "STEREO_3D"


def turn(camera: bpy.types.Camera, render: bpy.types.RenderSettings, view: str) -> float:
    """The tangent by which a picture's middle lies to the right of the camera's axis, for both eyes to converge without being turned."""
    stereo = camera.stereo
    share = _share(stereo, is_left=view != RIGHT)
    if not is_pair(render) or camera.type != "PERSP" or stereo.convergence_mode != "OFFAXIS":
        return 0.0
    return share * stereo.interocular_distance / stereo.convergence_distance


def _share(stereo: bpy.types.CameraStereoData, *, is_left: bool) -> float:
    """The distance of an eye to the left of its camera, as a part of the interocular distance."""
    if stereo.pivot == "CENTER":
        return 0.5 if is_left else -0.5
    return 0.0 if (stereo.pivot == "LEFT") == is_left else 1.0 if is_left else -1.0


def shift_x(camera: bpy.types.Camera, render: bpy.types.RenderSettings, view: str) -> float:
    """Blender's shift of a camera, with that of an eye's convergence plane: by the sensor's width, whatever side it fits."""
    return camera.shift_x + turn(camera, render, view) * camera.lens / camera.sensor_width


def spherical(stereo: bpy.types.CameraStereoData, *, is_left: bool) -> SphericalStereo:
    """One eye of a pair that turns with the ray. As in Cycles, the pivot does not matter."""
    half = 0.5 * stereo.interocular_distance
    merge = (stereo.pole_merge_angle_from, stereo.pole_merge_angle_to)
    return SphericalStereo(
        offset=-half if is_left else half,
        convergence=None if stereo.convergence_mode == "PARALLEL" else stereo.convergence_distance,
        pole_merge_rad=merge if stereo.use_pole_merge else None,
    )


def eye_of_3d_view(
    holder: bpy.types.Object, scene: bpy.types.Scene, space: bpy.types.SpaceView3D, view_matrix: Matrix
) -> Eye | None:
    """The eye of a 3D view that looks through a camera, at the place where Blender has put the view; None: the camera as it is."""
    render = scene.render
    if not render.use_multiview:
        return None
    which = space.stereo_3d_camera
    place = view_matrix.inverted_safe()
    if which == "S3D":
        # Only a window in stereo shows both eyes, in turn.
        if _are_alike(place, holder.matrix_world.normalized()):
            return None
        which = space.stereo_3d_eye.removesuffix("_EYE")
    view = which.lower()
    if not is_pair(render):
        own = camera_of_view(holder, scene, view)
        return Eye(own, own.matrix_world.copy(), own.data.shift_x)
    return Eye(holder, place, shift_x(holder.data, render, view), turn(holder.data, render, view))


def _are_alike(one: Matrix, other: Matrix) -> bool:
    return all(
        abs(a - b) < 1e-5 for own, others in zip(one, other, strict=True) for a, b in zip(own, others, strict=True)
    )


def cameras(scene: bpy.types.Scene) -> list[bpy.types.Camera]:
    """The cameras of all views of a scene, that of the scene first."""
    found = [scene.camera]
    if scene.render.use_multiview and not is_pair(scene.render):
        found += [camera_of_view(scene.camera, scene, one.name) for one in scene.render.views if one.use]
    return list(dict.fromkeys(one.data for one in found if one.type == "CAMERA"))


def camera_of_view(holder: bpy.types.Object, scene: bpy.types.Scene, view: str) -> bpy.types.Object:
    """The camera of a view in multiview: the one of the same name with the view's suffix; the scene's own where there is none."""
    views = scene.render.views
    ends = [one.camera_suffix for one in views if holder.name.endswith(one.camera_suffix)]
    chosen = views.get(view)
    if not ends or chosen is None:
        return holder
    stem = holder.name[: len(holder.name) - len(max(ends, key=len))]
    found = scene.objects.get(stem + chosen.camera_suffix)
    return holder if found is None else found
