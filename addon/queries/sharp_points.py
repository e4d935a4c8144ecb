# SPDX-License-Identifier: GPL-3.0-or-later
"""Three points of the world made sharp at once: the engine turns and places the film, the camera's settings take it."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import bpy

from ..export import camera as camera_export
from ..export.report import Report
from ..native import engine

Point = Sequence[float]


def solve(holder: bpy.types.Object, scene: bpy.types.Scene, points: Sequence[Point]) -> dict[str, Any]:
    """The engine's `sharp_points_json`. Raises `ExportError`, `EngineMissing` and the engine's `PetzvalError`."""
    width, height = camera_export.resolution(scene.render)
    camera = camera_export.describe(holder, scene, width, height, Report())
    places = [tuple(map(float, point)) for point in points]
    return json.loads(engine().sharp_points_json(camera, width, height, places))


def apply(camera: bpy.types.Camera, film: dict[str, Any]) -> None:
    """Writes a solution into the camera's settings."""
    own = camera.petzval
    own.tilt, own.swing = film["tilt_rad"], film["swing_rad"]
    own.focus_mode, own.film_distance = "FILM", film["film_distance_mm"]
