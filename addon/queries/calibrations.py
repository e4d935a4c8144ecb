# SPDX-License-Identifier: GPL-3.0-or-later
"""What the engine says of a camera's file of calibrations, remembered so that a panel may ask at every redraw."""

from __future__ import annotations

import json
import os
from typing import Any

import bpy

from ..native import EngineMissing, engine

_REMEMBERED = 16

_answers: dict[tuple[str, int], dict[str, Any]] = {}


def path_of(camera: bpy.types.Camera) -> str:
    """The file's path; empty: none is chosen."""
    chosen = camera.petzval.calibration_file.strip()
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
    key = (path, changed)
    if key not in _answers:
        while len(_answers) >= _REMEMBERED:
            del _answers[next(iter(_answers))]
        try:
            native = engine()
        except EngineMissing as error:
            return {"error": str(error)}
        try:
            _answers[key] = json.loads(native.calibration_json(path))
        except native.PetzvalError as error:
            _answers[key] = {"error": " ".join(str(error).split())}
    return _answers[key]


def chosen_in(camera: bpy.types.Camera) -> dict[str, Any]:
    """The chosen camera of the file, or the only one; `error`, one line, if there is none."""
    found = of_camera(camera)
    if "error" in found:
        return found
    name, cameras = camera.petzval.calibration_camera.strip(), found["cameras"]
    if not name and len(cameras) == 1:
        return cameras[0]
    names = ", ".join(one["name"] for one in cameras)
    if not name:
        return {"error": f"there are {len(cameras)} cameras: choose one of {names}"} if cameras else {}
    return next(
        (one for one in cameras if one["name"] == name), {"error": f"there is no camera '{name}': there is {names}"}
    )
