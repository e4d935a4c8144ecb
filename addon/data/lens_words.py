# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera's lens in words, for panels and messages. No bpy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from petzval.description import OF_LENS_FILE, CameraDescription

_MODELS = {
    "THIN": "thin lens",
    "PINHOLE": "pinhole",
    "ORTHOGRAPHIC": "orthographic",
    "PANORAMIC": "panoramic",
    "CALIBRATED": "calibrated",
}


def focus_text(mm: float | None) -> str:
    """A focus distance as a person would say it."""
    if mm is None:
        return "infinity"
    if mm <= 0.0:
        # The film stands before the focal plane.
        return "beyond infinity"
    return f"{mm:.0f} mm" if mm < 1e4 else f"{mm / 1000.0:.1f} m"


def in_a_line(camera: CameraDescription, info: dict[str, Any] | None, by: str = "") -> str:
    """The camera of a picture, in a line. `info`: the engine's `camera_info_json` of a camera with a lens file; `by`: the source of its
    focus, if not the user."""
    perspective = camera.perspective
    if camera.model not in OF_LENS_FILE or info is None:
        of = _MODELS.get(camera.model, camera.model.lower())
        if camera.model == "ORTHOGRAPHIC":
            return f"{of}, {camera.orthographic_width:.4g} units wide"
        if camera.panorama is not None:
            projection = camera.panorama.projection
            name = projection if isinstance(projection, str) else next(iter(projection))
            return f"{of}, {name.lower().replace('_', ' ')}"
        if camera.calibration is not None:
            name = Path(camera.calibration.path).name
            return f"{of} by {name}" + (f", {camera.calibration.camera}" if camera.calibration.camera else "")
        f_number = f" at f/{camera.lens.f_number:.2f}" if camera.model == "THIN" and camera.lens.f_number else ""
        return (
            f"{of}, {perspective.focal_length_mm:.1f} mm{f_number} on a picture {perspective.film_width_mm:.4g} mm wide"
        )
    focal = "afocal" if info["efl_mm"] is None else f"{abs(info['efl_mm']):.1f} mm"
    asked = camera.lens.f_number
    clamped = f" (f/{asked:.4g} is wider than it opens)" if info["f_number_was_clamped"] and asked else ""
    focused = f"focused at {focus_text(info['focus_scale_mm'])}{f' by {by}' if by else ''}"
    size = f"{info['picture_width_mm']:.4g} x {info['picture_height_mm']:.4g} mm"
    return f"{info['lens_name']}, {focal} at f/{info['f_number']:.2f}{clamped}, {focused}, {size}"
