# SPDX-License-Identifier: GPL-3.0-or-later
"""Reports of a camera's lens as it is set: asked of the engine, drawn by the pages of `petzval lens`."""

from __future__ import annotations

import json
from collections.abc import Callable
from math import degrees
from typing import Any

import bpy
import numpy as np

from petzval.description import LensReportSettings

from . import autofocus, lens_info
from .export import aperture_mask
from .export import camera as camera_export
from .export.errors import ExportError
from .export.report import Report
from .lettering import Letters
from .native import engine

#: Enum items: identifier, name, description.
KINDS = (
    ("DRAWING", "Drawing", "The lens in section, and the light through it"),
    ("SPOTS", "Spot Diagrams", "Where the rays of points meet the film"),
    ("FANS", "Ray Fans", "How far rays across the pupil land from the middle one"),
    ("MTF", "MTF", "How much contrast is left of fine lines"),
    ("DISTORTION", "Distortion & Field Curvature", "Distortion, field curvature and lateral colour over the field"),
    ("ILLUMINATION", "Illumination", "How bright the picture is off its middle"),
)
_FEW, _MANY = (0.0, 0.7, 1.0), tuple(np.linspace(0.0, 1.0, 41).tolist())


def picture(holder: bpy.types.Object, scene: bpy.types.Scene, kind: str) -> np.ndarray:
    """(height, width, 4), first row at the bottom, sRGB. Raises `ExportError`, `EngineMissing` and what the engine raises."""
    native = engine()
    from petzval.plotting import pages

    width, height = camera_export.resolution(scene.render)
    camera = aperture_mask.added(camera_export.describe(holder, scene, width, height, Report()), holder.data)
    found_focus = autofocus.find(holder, scene, bpy.context.evaluated_depsgraph_get()) if camera.focus.autofocus else None
    if found_focus is not None and "error" in found_focus:
        raise ExportError(found_focus["error"])
    info = lens_info.of_camera(holder, scene, found_focus)
    if "error" in info:
        raise ExportError(info["error"])
    lens = native.Lens(camera.lens_path)
    half_deg = None if info["fov_diagonal_rad"] is None else degrees(info["fov_diagonal_rad"]) / 2.0
    distance_mm = info["focus_distance_mm"]
    if kind == "DRAWING":
        fields = [] if half_deg is None else [part * half_deg for part in _FEW]
        asked = {} if camera.wavelength_nm is None else {"wavelength_nm": camera.wavelength_nm}
        answer = native.lens_drawing_json(lens, camera.lens, fields, 9, focus_distance_mm=distance_mm, **asked)
        with Letters() as letters:
            return pages.drawing(json.loads(answer), letters)
    look = LensReportSettings(
        fields_deg=_fields(kind, half_deg),
        wavelengths_nm=() if camera.wavelength_nm is None else (camera.wavelength_nm,),
        focus_distance_mm=distance_mm,
    )
    found, title, report = _ask(native, kind, lens, camera.lens, look)
    with Letters() as letters:
        return pages.report(found, report.size_in(found), title, report.draw, letters)


def _fields(kind: str, half_deg: float | None) -> tuple[float, ...]:
    """To the corner of the film; none where that sees nothing, which leaves the design's own."""
    parts = _MANY if kind in ("DISTORTION", "ILLUMINATION") else _FEW
    return () if not half_deg else tuple(part * half_deg for part in parts)


def _ask(native: Any, kind: str, lens: Any, setting: Any, look: Any) -> tuple[Any, str, Any]:
    """What the engine says, its title, and the module that draws it."""
    from petzval.lens_reports import distortion, fans, illumination, mtf, spots, titles

    if kind == "SPOTS":
        return json.loads(native.lens_spots_json(lens, setting, look, 41, [0.0])), titles.SPOTS, spots
    if kind == "FANS":
        return json.loads(native.lens_fans_json(lens, setting, look, 201)), titles.FANS, fans
    if kind == "MTF":
        found = json.loads(native.lens_mtf_json(lens, setting, look, (100.0, 40), (13, 10.0)))
        return found, titles.mtf(found), mtf
    if kind == "DISTORTION":
        return json.loads(native.lens_distortion_json(lens, setting, look, 41)), titles.DISTORTION, distortion
    return [json.loads(native.lens_illumination_json(lens, setting, look, 31))], titles.ILLUMINATION, illumination
