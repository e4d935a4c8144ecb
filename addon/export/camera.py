# SPDX-License-Identifier: GPL-3.0-or-later
"""A camera object as the engine takes it. Reads evaluated data in a render, original data for a panel."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from typing import Any

import bpy

from petzval.description import (
    INSTALLED_LENSFUN,
    MOST_BLADES,
    OF_LENS_FILE,
    CalibrationSettings,
    CameraDescription,
    FilmSettings,
    FocalLength,
    Focusing,
    FocusSettings,
    LensSettings,
    Matrix4,
    Panorama,
    Perspective,
    PhysicalExposure,
    Scattering,
)

from ..data import default_lens
from ..data.lens_files import LensMissing, resolve
from . import framing, sensor
from .errors import ExportError
from .report import Report
from .stereo import Eye, is_pair

MILLIMETRES_PER_METRE = 1000.0

#: The names of coatings in lens files.
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
    return tuple(map(tuple, matrix))


def describe(
    holder: bpy.types.Object | None,
    scene: bpy.types.Scene,
    width: int,
    height: int,
    report: Report,
    model: str | None = None,
    eye: Eye | None = None,
) -> CameraDescription:
    """The camera as the engine takes it; `model` replaces the camera's own, `eye` is that of a view in stereo. Raises `ExportError`."""
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
    eye = Eye(holder, holder.matrix_world, camera.shift_x) if eye is None else eye
    if any(axis.length == 0.0 for axis in eye.matrix.to_3x3().col):
        report.warn(
            f"Camera '{holder.name}': its scale is 0 along an axis, where Cycles' picture is black; it counts as 1: reset the scale"
        )
    alike = CameraDescription(holder.name, rows(eye.matrix), **_alike(CameraDescription, settings))
    description = replace(
        alike,
        model=model,
        perspective=Perspective(
            camera.lens,
            picture_width_mm,
            (eye.shift_x * side / larger, camera.shift_y * side / larger),
            camera.dof.aperture_ratio,
        ),
        pixel_aspect=aspect,
        lens=_lens(camera, of_lens),
        scale_mm_per_unit=scale(settings, scene),
        wavelength_nm=settings.wavelength if settings.spectrum == "SINGLE" else None,
        spectrum="THREE" if settings.spectrum == "THREE" else "VISIBLE",
        film_sensor=sensor.name_of(settings),
        scattering=Scattering(settings.glare_roughness, settings.glare_cleanliness, settings.glare_veil),
        exposure=_exposure(settings, model),
        clip=_clip(camera, holder.name, report),
        spherical_stereo=eye.spherical,
    )
    if camera.type == "ORTHO":
        return _orthographic(description, camera, width / side, report)
    if camera.type == "PANO":
        return _panoramic(description, camera, height * aspect / width, report)
    if model == "CALIBRATED":
        return _calibrated(description, camera, report)
    description = replace(description, focus=_focus(description, camera, report))
    if of_lens:
        description = replace(description, lens_path=_lens_path(description, camera, height * aspect / width))
        description = replace(description, film=_film(description, camera, (width, height)))
        if settings.focal_mode == "BLENDER":
            own = tuple(shift * side / larger for shift in (camera.shift_x, camera.shift_y))
            framed = framing.like_blender(description, own, (width, height), report)
            description = replace(description, lens=framed.lens, film=framed.film)
        if eye.turn:
            description = framing.turned(description, (width, height), eye.turn, report)
    _warn(description, camera, report)
    if of_lens and is_pair(scene.render) and camera.stereo.use_spherical_stereo:
        report.warn(f"Camera '{holder.name}': a lens does not turn with each of its rays: spherical stereo is left out")
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
    return replace(description, model="ORTHOGRAPHIC", exposure=None, orthographic_width=camera.ortho_scale * share)


def _panoramic(
    description: CameraDescription, camera: bpy.types.Camera, aspect: float, report: Report
) -> CameraDescription:
    """A picture in a projection of Blender's: no lens, and depth of field as of a thin lens. `aspect`: the picture's height over its width."""
    if description.model in OF_LENS_FILE:
        report.warn(
            f"Camera '{description.object_name}': it is panoramic, so no lens takes its picture: make it a perspective camera"
        )
    is_thin = description.model == "THIN" or (description.model != "PINHOLE" and camera.dof.use_dof)
    lens = _lens(camera, False) if is_thin else LensSettings(f_number=None)
    sensor_mm = (description.perspective.film_width_mm, description.perspective.film_width_mm * aspect)
    panorama = Panorama(_projection(camera, sensor_mm), (camera.shift_x, camera.shift_y))
    described = replace(description, model="PANORAMIC", exposure=None, lens=lens, panorama=panorama)
    return replace(described, focus=_focus(described, camera, report)) if is_thin else described


def _calibrated(description: CameraDescription, camera: bpy.types.Camera, report: Report) -> CameraDescription:
    """A picture by a calibration; with Blender's depth of field switched on, the blur of a thin lens."""
    settings = camera.petzval
    chosen = settings.calibration_file.strip()
    if not chosen:
        raise ExportError(
            f"Camera '{description.object_name}': it has no calibration: choose its file in the camera's Lens panel"
        )
    path = chosen if chosen == INSTALLED_LENSFUN else bpy.path.abspath(chosen, library=camera.library)
    if description.spherical_stereo is not None:
        report.warn(
            f"Camera '{description.object_name}': a calibration does not turn with each of its rays: spherical stereo is left out"
        )
    blurred = _lens(camera, False)
    lens = blurred if camera.dof.use_dof else LensSettings(f_number=None)
    described = replace(
        description,
        calibration=CalibrationSettings(
            path,
            settings.calibration_camera.strip() or None,
            settings.calibration_body.strip() or None,
            blurred.f_number or camera.dof.aperture_fstop,
        ),
        exposure=None,
        lens=lens,
        spherical_stereo=None,
    )
    return replace(described, focus=_focus(described, camera, report)) if camera.dof.use_dof else described


def _projection(camera: bpy.types.Camera, sensor_mm: tuple[float, float]) -> str | dict[str, dict[str, Any]]:
    """The projection of a panoramic camera by the engine's name, with its settings."""
    kind = camera.panorama_type
    if kind == "EQUIRECTANGULAR":
        longitudes, latitudes = (camera.longitude_min, camera.longitude_max), (camera.latitude_min, camera.latitude_max)
        return {kind: {"longitude_rad": longitudes, "latitude_rad": latitudes}}
    if kind == "FISHEYE_EQUIDISTANT":
        return {kind: {"field_rad": camera.fisheye_fov}}
    if kind == "FISHEYE_EQUISOLID":
        lens = {"focal_length_mm": camera.fisheye_lens, "field_rad": camera.fisheye_fov}
        return {kind: lens | {"sensor_mm": sensor_mm}}
    if kind == "FISHEYE_LENS_POLYNOMIAL":
        coefficients = [getattr(camera, f"fisheye_polynomial_k{power}") for power in range(5)]
        return {kind: {"coefficients": coefficients, "field_rad": camera.fisheye_fov, "sensor_mm": sensor_mm}}
    if kind == "CENTRAL_CYLINDRICAL":
        radius = camera.central_cylindrical_radius
        heights = [
            side / radius for side in (camera.central_cylindrical_range_v_min, camera.central_cylindrical_range_v_max)
        ]
        longitudes = (camera.central_cylindrical_range_u_min, camera.central_cylindrical_range_u_max)
        return {kind: {"longitude_rad": longitudes, "height": heights}}
    return {"MIRRORBALL": "MIRROR_BALL"}.get(kind, kind)


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


def _lens(camera: bpy.types.Camera, of_lens: bool) -> LensSettings:
    """The settings of the lens; `of_lens`: of a lens file, else of a thin lens, which takes values that are not set from Blender's depth of
    field."""
    settings = camera.petzval
    f_number = None if settings.wide_open else settings.f_number
    if not of_lens:
        blades, turn_rad = _blades(settings.blades), settings.blade_rotation
        if blades == 0:
            blades, turn_rad = _blades(camera.dof.aperture_blades), turn_rad or camera.dof.aperture_rotation
            # The middle of an edge lies where a lens's own blades have a corner.
            turn_rad += math.pi / max(blades, 1)
        return LensSettings(
            f_number=camera.dof.aperture_fstop if f_number is None else f_number,
            blades=blades,
            blade_rotation_rad=turn_rad,
            blade_curvature=settings.blade_curvature,
        )
    return replace(
        LensSettings(**_alike(LensSettings, settings)),
        focal_length=_focal_length(settings),
        f_number=f_number,
        pupil_diameter_mm=None if settings.wide_open else settings.pupil_diameter or None,
        blades=_blades(settings.blades),
        blade_rotation_rad=settings.blade_rotation,
        aperture_mask=None,
        coating=_COATINGS.get(settings.coating),
    )


def _alike(description: type, settings: bpy.types.PropertyGroup) -> dict[str, Any]:
    """The fields of a description that are settings of Blender's camera under their own name: they need no line of their own here."""
    names = settings.bl_rna.properties
    return {one.name: getattr(settings, one.name) for one in fields(description) if one.name in names}


def _focal_length(settings: bpy.types.PropertyGroup) -> FocalLength:
    if settings.focal_mode == "LENGTH":
        return {"MILLIMETRES": settings.focal_length}
    return {"SCALE": settings.focal_scale} if settings.focal_mode == "SCALE" else "AS_PUBLISHED"


def _exposure(settings: bpy.types.PropertyGroup, model: str) -> PhysicalExposure | None:
    if not settings.physical_exposure or model == "PINHOLE":
        return None
    return PhysicalExposure(settings.shutter, settings.iso, settings.lumens_per_watt)


def _blades(count: int) -> int:
    return min(count, MOST_BLADES) if count >= 3 else 0


def _focus(description: CameraDescription, camera: bpy.types.Camera, report: Report) -> FocusSettings:
    settings, dof = camera.petzval, camera.dof
    mode, focus = settings.focus_mode, FocusSettings()
    if description.model in OF_LENS_FILE:
        autofocus = tuple(settings.autofocus_point) if mode == "AUTO" else None
        focus = FocusSettings(focusing=Focusing(settings.anchor, settings.focus_relation), autofocus=autofocus)
        if mode == "FILM":
            return replace(focus, film_distance_mm=settings.film_distance)
    if mode == "INFINITY":
        return focus
    if dof.focus_object is not None:
        return replace(focus, point_world=_focus_point(dof))
    if dof.focus_distance > 0.0:
        return replace(focus, distance=dof.focus_distance)
    # Common in files that never had depth of field.
    if description.model != "PINHOLE":
        report.warn(f"Camera '{description.object_name}': its focus distance is zero, it is focused at infinity")
    return focus


def _focus_point(dof: bpy.types.CameraDOFSettings) -> tuple[float, float, float]:
    matrix = dof.focus_object.matrix_world
    pose = dof.focus_object.pose
    if dof.focus_subtarget and pose is not None and dof.focus_subtarget in pose.bones:
        matrix = matrix @ pose.bones[dof.focus_subtarget].matrix
    return tuple(matrix.translation)


def _lens_path(description: CameraDescription, camera: bpy.types.Camera, aspect: float) -> str:
    """The lens's file; `aspect`: the picture's height over its width."""
    of = description.perspective
    chosen = camera.petzval.lens_file.strip()
    try:
        return resolve(
            chosen or default_lens.file_name(of.focal_length_mm, of.film_width_mm, of.film_width_mm * aspect),
            camera.library,
        )
    except LensMissing as error:
        raise ExportError(f"Camera '{description.object_name}': {error}") from None


def _film(description: CameraDescription, camera: bpy.types.Camera, size: tuple[int, int]) -> FilmSettings:
    """The film of a lens; `size`: the picture's pixels."""
    settings = camera.petzval
    aspect = size[1] * description.pixel_aspect / size[0]
    if settings.film_mode == "LENS":
        try:
            width_mm, height_mm = framing.film_of_lens_mm(description, size)
        except framing.Refused as error:
            raise ExportError(str(error)) from None
    elif settings.film_mode == "SIZE":
        width_mm, height_mm = settings.film_width, settings.film_height
    else:
        width_mm = description.perspective.film_width_mm
        height_mm = width_mm * aspect
    return FilmSettings(width_mm, height_mm, settings.tilt, settings.swing, (settings.shift_x, settings.shift_y))


def _warn(description: CameraDescription, camera: bpy.types.Camera, report: Report) -> None:
    name = f"Camera '{description.object_name}'"
    if camera.type != "PERSP":
        kind = camera.type.lower()
        report.warn(f"{name}: {kind} cameras are not supported yet, it is taken as perspective")
    settings = camera.petzval
    is_followed = settings.focal_mode == "BLENDER" or (settings.in_step and settings.match_viewport)
    if description.model in OF_LENS_FILE and any((camera.shift_x, camera.shift_y)) and not is_followed:
        report.warn(f"{name}: Blender's shift does not move a real lens: use the shift of its Film & Movements panel")
