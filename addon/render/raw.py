# SPDX-License-Identifier: GPL-3.0-or-later
"""Raw files of a camera's sensor, beside the picture of a final render."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np

from petzval.description import CameraDescription
from petzval.errors import CommandError
from petzval.sensor_options import check_raw, told

from ..export import sensor
from ..export.errors import ExportError
from ..native import engine
from . import loop


def check(depsgraph: bpy.types.Depsgraph, view: str, camera: CameraDescription) -> None:
    """Raises `ExportError` where the raw file of the camera's sensor cannot be written: before the render, not after it."""
    native, file, name = engine(), *_asked(depsgraph, view)
    if file is None or name is None:
        return
    scene = depsgraph.scene_eval
    try:
        check_raw(file)
        native.check_exposure(name, sensor.exposure_of(camera, scene.frame_current))
        native.check_replaceable(file)
    except (native.PetzvalError, CommandError) as refused:
        raise ExportError(f"Camera '{scene.camera.name}': {refused}") from None
    except OSError as refused:
        why = refused.strerror or refused
        raise ExportError(f"Camera '{scene.camera.name}': cannot write {file}: {why}: change Raw File") from None


def _asked(depsgraph: bpy.types.Depsgraph, view: str) -> tuple[Path | None, str | None]:
    """The raw file and the sensor that a render is to have."""
    scene = depsgraph.scene_eval
    settings = scene.camera.data.petzval
    names = [view] if view else []
    if sum(layer.use for layer in scene.view_layers) > 1:
        names.append(depsgraph.view_layer_eval.name)
    return sensor.raw_file_of(settings, scene.frame_current, names), sensor.name_of(settings)


def write(
    depsgraph: bpy.types.Depsgraph,
    view: str,
    camera: CameraDescription,
    pixels: np.ndarray,
    warn: Callable[[str], None],
) -> None:
    """Writes the raw file of the camera's sensor, if one is asked for. Errors are reported, and the picture stays."""
    native, file, name = engine(), *_asked(depsgraph, view)
    if file is None or name is None:
        return
    exposure = sensor.exposure_of(camera, depsgraph.scene_eval.frame_current)
    try:
        found = json.loads(native.expose_pixels_json(name, exposure, np.ascontiguousarray(pixels), str(file)))
    except native.PetzvalError as failed:
        loop.WATCH.raw_problem = str(failed)
        warn(str(failed))
        return
    print(f"Petzval: {told(file, found)}")
