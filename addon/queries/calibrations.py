# SPDX-License-Identifier: GPL-3.0-or-later
"""The engine's answers about a camera's file of calibrations, remembered so that a panel may ask at every redraw."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from typing import Any

import bpy

from petzval.description import INSTALLED_LENSFUN

from ..export import camera as camera_export
from ..export.errors import ExportError
from ..export.report import Report
from ..native import EngineMissing, engine

# A slider being dragged leaves one entry a step.
_REMEMBERED = 32

_answers: dict[tuple[Any, ...], dict[str, Any]] = {}


def path_of(camera: bpy.types.Camera) -> str:
    """The file's path, or the word for the installed lensfun database; empty: none is chosen."""
    chosen = camera.petzval.calibration_file.strip()
    if chosen == INSTALLED_LENSFUN:
        return chosen
    return bpy.path.abspath(chosen, library=camera.library) if chosen else ""


def of_camera(camera: bpy.types.Camera) -> dict[str, Any]:
    """The engine's `calibration_json` as a dictionary; where there is none, only `error`, one line. An ST map has no cameras in it."""
    path = path_of(camera)
    if not path:
        return {"error": "no calibration: choose a file"}
    if path.lower().endswith(".exr"):
        return {"cameras": [], "format": "ST map", "remarks": []}
    try:
        changed = os.stat(path).st_mtime_ns
    except OSError:
        changed = 0
    return _remembered((path, changed), lambda native: native.calibration_json(path))


def chosen_in(camera: bpy.types.Camera) -> dict[str, Any]:
    """The chosen camera of the file, or the only one; `error`, one line, if there is none."""
    found = of_camera(camera)
    if "error" in found:
        return found
    name, cameras = camera.petzval.calibration_camera.strip(), found["cameras"]
    if found.get("lenses"):
        return _photographic(camera, found["lenses"])
    if not name and len(cameras) == 1:
        return cameras[0]
    names = ", ".join(one["name"] for one in cameras)
    if not name:
        return {"error": f"there are {len(cameras)} cameras: choose one of {names}"} if cameras else {}
    return next(
        (one for one in cameras if one["name"] == name), {"error": f"there is no camera '{name}': there is {names}"}
    )


def _photographic(camera: bpy.types.Camera, lenses: list[dict[str, Any]]) -> dict[str, Any]:
    """A lens of a lensfun database, at the camera's settings and on the scene's picture."""
    if not camera.petzval.calibration_camera.strip() and len(lenses) > 1:
        return {"error": f"there are {len(lenses)} lenses: choose one"}
    scene = bpy.context.scene
    holder = next((one for one in scene.objects if one.data == camera), None)
    if holder is None:
        return {"error": "no object of the scene has this camera"}
    width, height = camera_export.resolution(scene.render)
    try:
        described = camera_export.describe(holder, scene, width, height, Report(), "CALIBRATED")
    except ExportError as error:
        return {"error": str(error)}
    key = (described.calibration, described.perspective, described.focus, described.pixel_aspect, width, height)
    return _remembered(key, lambda native: native.photographic_lens_json(described, width, height))


def _remembered(key: tuple[Any, ...], ask: Callable[[Any], str]) -> dict[str, Any]:
    """The engine's answer of that key as a dictionary; `error`, one line, if there is none."""
    if key not in _answers:
        while len(_answers) >= _REMEMBERED:
            del _answers[next(iter(_answers))]
        try:
            native = engine()
        except EngineMissing as error:
            return {"error": str(error)}
        try:
            _answers[key] = json.loads(ask(native))
        except native.PetzvalError as error:
            _answers[key] = {"error": " ".join(str(error).split())}
    return _answers[key]
