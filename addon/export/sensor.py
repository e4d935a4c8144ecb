# SPDX-License-Identifier: GPL-3.0-or-later
"""The sensor of a camera, as the engine takes it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy

from petzval.description import CameraDescription
from petzval.frame_names import numbered


def name_of(settings: bpy.types.PropertyGroup) -> str | None:
    """The sensor's name or file; None where the camera has none."""
    if not settings.use_sensor:
        return None
    named: str = settings.sensor.strip()
    path = bpy.path.abspath(named, library=settings.id_data.library)
    return path if named.startswith("//") or Path(path).is_file() else named


def exposure_of(camera: CameraDescription, frame: int) -> dict[str, Any]:
    """The exposure of a picture of that frame: by the camera's own film speed and shutter where it exposes physically, else at the sensor's own
    speed. Frames have noise of their own."""
    found: dict[str, Any] = {"frame": frame % 2**32, "f_number": camera.lens.f_number}
    if camera.exposure is not None:
        found |= {"iso": camera.exposure.iso, "shutter_s": camera.exposure.shutter_s}
    return found


def raw_file_of(settings: bpy.types.PropertyGroup, frame: int, parts: list[str]) -> Path | None:
    """The path of a frame's raw file, with the names of its view and layer where there are several; None if none is written."""
    if not settings.use_sensor or not settings.raw_file.strip():
        return None
    path = Path(bpy.path.abspath(settings.raw_file, library=settings.id_data.library))
    if "#" in path.stem:
        path = numbered(path, frame)
    return path.with_name("_".join([path.stem, *parts]) + path.suffix)
