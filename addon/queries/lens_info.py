# SPDX-License-Identifier: GPL-3.0-or-later
"""The engine's answers about a camera's lens, remembered so that a panel may ask at every redraw."""

from __future__ import annotations

import json
import os
from typing import Any

import bpy

from petzval.description import CameraDescription, focused

from .. import redraw
from ..export import camera as camera_export
from ..export.errors import ExportError
from ..export.report import Report
from ..native import EngineMissing, engine

# A panel asks for one camera again and again; a slider being dragged leaves one entry a step.
_REMEMBERED = 64

_answers: dict[tuple, dict[str, Any]] = {}
_shown: dict[tuple[str, str], dict[str, Any]] = {}


def of_camera(
    camera: bpy.types.Object, scene: bpy.types.Scene, found: dict[str, Any] | None = None, model: str | None = None
) -> dict[str, Any]:
    """The engine's `camera_info_json` as a dictionary; where there is none, only `error`, one line.

    `found` stands instead of the camera's own focus: that which autofocus has found; `model` instead of its own model.
    """
    width, height = camera_export.resolution(scene.render)
    try:
        description = camera_export.describe(camera, scene, width, height, Report(), model)
        if found is not None:
            description = focused(description, found)
        return _ask(description, width, height)
    except (ExportError, EngineMissing) as error:
        return {"error": str(error)}


def for_panel(camera: bpy.types.Object, scene: bpy.types.Scene, found: dict[str, Any] | None = None) -> dict[str, Any]:
    """`of_camera`; while a render runs, the last answer.

    Blender keeps in one place, for all threads, whether Python may change the scene, and sets it back after each call.
    Where a panel lets go of Python's lock, to look for a file or to ask the engine, and a render ends just then in its own
    thread, it can stay forbidden.
    """
    key = (scene.name, camera.name_full)
    if key not in _shown or not redraw.is_rendering():
        while len(_shown) >= _REMEMBERED:
            del _shown[next(iter(_shown))]
        _shown[key] = of_camera(camera, scene, found)
    return _shown[key]


def coverage(camera: bpy.types.Object, scene: bpy.types.Scene) -> str:
    """The part of the picture that the lens does not light, why, and the remedy; empty if it lights all, and while a render runs."""
    if redraw.is_rendering():
        return ""
    size = camera_export.resolution(scene.render)
    try:
        description = camera_export.describe(camera, scene, *size, Report())
        return _ask(description, *size, "coverage_json").get("complaint") or ""
    except (ExportError, EngineMissing):
        return ""


def _ask(description: CameraDescription, width: int, height: int, function: str = "camera_info_json") -> dict[str, Any]:
    try:
        changed = os.stat(description.lens_path).st_mtime_ns
    except OSError:
        changed = 0
    key = (function, repr(description), width, height, changed)
    if key not in _answers:
        while len(_answers) >= _REMEMBERED:
            del _answers[next(iter(_answers))]
        native = engine()
        try:
            _answers[key] = json.loads(getattr(native, function)(description, width, height))
        except native.PetzvalError as error:
            _answers[key] = {"error": " ".join(str(error).split())}
    return _answers[key]


def forget() -> None:
    """Drops the remembered answers."""
    _answers.clear()
    _shown.clear()
