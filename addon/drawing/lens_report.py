# SPDX-License-Identifier: GPL-3.0-or-later
"""Reports of a camera's lens as it is set: asked of the engine, drawn by the pages of `petzval lens`."""

from __future__ import annotations

import json
from math import degrees

import bpy
import numpy as np

from petzval.description import LensReportSettings
from petzval.lens_reports.registry import REPORTS, find

from ..export import aperture_mask
from ..export import camera as camera_export
from ..export.errors import ExportError
from ..export.report import Report
from ..native import engine
from ..queries import autofocus, lens_info
from .lettering import Letters

#: Enum items: identifier, name, description. The drawing and every report of `petzval lens`.
KINDS = (
    ("DRAWING", "Drawing", "The lens in section, and the light through it"),
    *((one.name.upper(), one.label, one.description) for one in REPORTS),
)
_FEW, _MANY = (0.0, 0.7, 1.0), tuple(np.linspace(0.0, 1.0, 41).tolist())


def picture(holder: bpy.types.Object, scene: bpy.types.Scene, kind: str) -> np.ndarray:
    """(height, width, 4), first row at the bottom, sRGB. Raises `ExportError`, `EngineMissing` and the engine's errors."""
    native = engine()
    from petzval.plotting import pages

    width, height = camera_export.resolution(scene.render)
    camera = aperture_mask.added(camera_export.describe(holder, scene, width, height, Report()), holder.data)
    found_focus = (
        autofocus.find(holder, scene, bpy.context.evaluated_depsgraph_get()) if camera.focus.autofocus else None
    )
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
    report = next(one for one in REPORTS if one.name.upper() == kind)
    parts = _MANY if report.is_over_the_field else _FEW
    settings = LensReportSettings(
        # To the corner of the film; none where that sees nothing, which leaves the design's own.
        fields_deg=() if not half_deg else tuple(part * half_deg for part in parts),
        wavelengths_nm=() if camera.wavelength_nm is None else (camera.wavelength_nm,),
        focus_distance_mm=distance_mm,
    )
    found = find(report, lens, camera.lens, settings)
    shown = [found] if report.has_f_numbers else found
    with Letters() as letters:
        return pages.report(shown, report.size_in(shown), report.title(shown), report.draw, letters)
