# SPDX-License-Identifier: GPL-3.0-or-later
"""A camera object as the engine takes it. Reads evaluated data in a render, original data for a panel."""

from __future__ import annotations

import bpy

from ..description import OF_LENS_FILE, CameraDescription, Matrix4, Report
from ..lens_files import LensMissing, resolve
from .errors import ExportError

MILLIMETRES_PER_METRE = 1000.0

#: As lens files write them.
_COATINGS = {"NONE": "none", "MGF2": "MgF2", "DOUBLE": "double", "TRIPLE": "triple"}


def resolution(render: bpy.types.RenderSettings) -> tuple[int, int]:
    """Pixels of the whole picture, rounded as Blender does it."""
    percent = render.resolution_percentage
    return max(render.resolution_x * percent // 100, 1), max(render.resolution_y * percent // 100, 1)


def pixel_aspect(render: bpy.types.RenderSettings) -> float:
    """The height of a pixel over its width."""
    return render.pixel_aspect_y / render.pixel_aspect_x


def rows(matrix: object) -> Matrix4:
    """A matrix of mathutils, row by row."""
    return tuple(tuple(row) for row in matrix)


def describe(
    holder: bpy.types.Object | None,
    scene: bpy.types.Scene,
    width: int,
    height: int,
    report: Report,
    model: str | None = None,
) -> CameraDescription:
    """What the engine is told; `model` instead of the camera's own. Raises `ExportError`."""
    if holder is None:
        raise ExportError(f"Scene '{scene.name}' has no camera: add one, and make it the active camera")
    if holder.type != "CAMERA":
        raise ExportError(f"Object '{holder.name}' is not a camera: choose a camera as the scene's camera")
    camera = holder.data
    settings = camera.petzval
    picture_width_mm, side = _picture(camera, scene.render, width, height)
    aspect = pixel_aspect(scene.render)
    larger = max(width, height * aspect)
    model = settings.model if model is None else model
    of_lens = model in OF_LENS_FILE
    wide_open = settings.wide_open
    description = CameraDescription(
        object_name=holder.name,
        matrix_world=rows(holder.matrix_world),
        model=model,
        pinhole_focal_length_mm=camera.lens,
        pinhole_film_width_mm=picture_width_mm,
        pinhole_shift=(camera.shift_x * side / larger, camera.shift_y * side / larger),
        pixel_aspect=aspect,
        f_number=(None if wide_open else settings.f_number) if of_lens else _thin_f_number(camera),
        pupil_diameter_mm=(settings.pupil_diameter or None) if of_lens and not wide_open else None,
        blades=_blades(settings.blades if of_lens or settings.blades else camera.dof.aperture_blades),
        blade_rotation_rad=settings.blade_rotation,
        blade_curvature=settings.blade_curvature,
        roughness_nm=settings.glare_roughness,
        cleanliness=settings.glare_cleanliness,
        veiling_index=settings.glare_veil,
        coating=_COATINGS.get(settings.coating) if of_lens else None,
        exposes_by_f_number=settings.exposes_by_f_number,
        scale_mm_per_unit=scale(settings, scene),
        wavelength_nm=settings.wavelength if settings.spectrum == "SINGLE" else None,
        spectrum="THREE" if settings.spectrum == "THREE" else "VISIBLE",
        precision=settings.precision,
        exposure=_exposure(settings, model),
        clip=_clip(camera, holder.name, report),
    )
    if camera.type == "ORTHO":
        return _orthographic(description, camera, width / side, report)
    _focus(description, camera, report)
    if of_lens:
        _lens(description, camera, height * aspect / width)
    _warn(description, camera, report)
    return description


def _clip(camera: bpy.types.Camera, name: str, report: Report) -> tuple[float, float]:
    begin, end = camera.clip_start, camera.clip_end
    if end > begin:
        return begin, end
    # A driver that fails leaves 0.
    report.warn(f"Camera '{name}': its clipping ends before it begins, so nothing is clipped: raise Clip End")
    return 0.0, float("inf")


def _orthographic(
    description: CameraDescription, camera: bpy.types.Camera, share: float, report: Report
) -> CameraDescription:
    """A picture by parallel rays: no lens and no focus. `share`: the picture's width on the side that Blender measures."""
    if description.model != "PINHOLE":
        report.warn(
            f"Camera '{description.object_name}': it is orthographic, so no lens takes its picture: make it a perspective camera"
        )
    description.model, description.exposure = "ORTHOGRAPHIC", None
    description.orthographic_width = camera.ortho_scale * share
    return description


def scale(settings: bpy.types.PropertyGroup, scene: bpy.types.Scene) -> tuple[float, float, float]:
    """Millimetres in the lens for a Blender unit, along the camera's axes."""
    if settings.scale_from_scene:
        return (MILLIMETRES_PER_METRE * scene.unit_settings.scale_length,) * 3
    return (settings.scale[0],) * 3 if settings.scale_locked else tuple(settings.scale)


def _picture(
    camera: bpy.types.Camera, render: bpy.types.RenderSettings, width: int, height: int
) -> tuple[float, float]:
    """The picture's width on Blender's sensor, and the side that the sensor is fitted to (widths of a pixel)."""
    aspect = pixel_aspect(render)
    fit = camera.sensor_fit
    sensor = camera.sensor_height if fit == "VERTICAL" else camera.sensor_width
    if fit == "AUTO":
        fit = "HORIZONTAL" if width >= height * aspect else "VERTICAL"
    side = width if fit == "HORIZONTAL" else height * aspect
    return sensor * width / side, side


def blender_shift(
    larger_sides: tuple[float, float],
    camera: bpy.types.Camera,
    render: bpy.types.RenderSettings,
    width: int,
    height: int,
) -> tuple[float, float]:
    """A shift in the picture's larger sides, in the units of the camera's own shift: the side that its sensor fits."""
    _, side = _picture(camera, render, width, height)
    x, y = larger_sides
    larger = max(width, height * pixel_aspect(render))
    return x * larger / side, y * larger / side


def _thin_f_number(camera: bpy.types.Camera) -> float:
    settings = camera.petzval
    return camera.dof.aperture_fstop if settings.wide_open else settings.f_number


def _exposure(settings: bpy.types.PropertyGroup, model: str) -> tuple[float, float, float] | None:
    if not settings.physical_exposure or model == "PINHOLE":
        return None
    return settings.shutter, settings.iso, settings.lumens_per_watt


def _blades(count: int) -> int:
    return min(count, 24) if count >= 3 else 0


def _focus(description: CameraDescription, camera: bpy.types.Camera, report: Report) -> None:
    settings, dof = camera.petzval, camera.dof
    mode = settings.focus_mode
    if description.model in OF_LENS_FILE:
        description.anchor = settings.anchor
        description.focus_relation = settings.focus_relation
        if mode == "AUTO":
            description.autofocus = tuple(settings.autofocus_point)
    if mode == "FILM" and description.model in OF_LENS_FILE:
        description.film_distance_mm = settings.film_distance
    elif mode == "INFINITY":
        description.focus_distance = None
    elif dof.focus_object is not None:
        description.focus_point_world = _focus_point(dof)
    elif dof.focus_distance > 0.0:
        description.focus_distance = dof.focus_distance
    else:
        # Common in files that never had depth of field.
        if description.model != "PINHOLE":
            report.warn(f"Camera '{description.object_name}': its focus distance is zero, it is focused at infinity")
        description.focus_distance = None


def _focus_point(dof: bpy.types.CameraDOFSettings) -> tuple[float, float, float]:
    matrix = dof.focus_object.matrix_world
    pose = dof.focus_object.pose
    if dof.focus_subtarget and pose is not None and dof.focus_subtarget in pose.bones:
        matrix = matrix @ pose.bones[dof.focus_subtarget].matrix
    return tuple(matrix.translation)


def _lens(description: CameraDescription, camera: bpy.types.Camera, aspect: float) -> None:
    """`aspect`: the picture's height over its width."""
    settings = camera.petzval
    try:
        description.lens_path = resolve(settings.lens_file, camera.library)
    except LensMissing as error:
        raise ExportError(f"Camera '{description.object_name}': {error}") from None
    if settings.focal_mode == "LENGTH":
        description.focal_length_mm = settings.focal_length
    elif settings.focal_mode == "SCALE":
        description.focal_scale = settings.focal_scale
    if settings.film_mode == "SIZE":
        description.film_width_mm = settings.film_width
        description.film_height_mm = settings.film_height
    else:
        description.film_width_mm = description.pinhole_film_width_mm
        description.film_height_mm = description.pinhole_film_width_mm * aspect
    description.tilt_rad = settings.tilt
    description.swing_rad = settings.swing
    description.shift_mm = (settings.shift_x, settings.shift_y)


def _warn(description: CameraDescription, camera: bpy.types.Camera, report: Report) -> None:
    name = f"Camera '{description.object_name}'"
    if camera.type != "PERSP":
        kind = {"PANO": "panoramic"}.get(camera.type, camera.type.lower())
        report.warn(f"{name}: {kind} cameras are not supported yet, it is taken as perspective")
    if description.model in OF_LENS_FILE and any(description.pinhole_shift) and not camera.petzval.in_step:
        report.warn(f"{name}: Blender's shift does not move a real lens: use the shift of its Film & Movements panel")
