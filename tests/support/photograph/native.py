# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders without Blender: an empty world, straight through the engine's Python module."""

from __future__ import annotations

import json
import os
from types import SimpleNamespace

import numpy as np

from petzval import _native
from petzval.description import CameraDescription, SettingsDescription, WorldDescription, changed, focal_length

IDENTITY = tuple(tuple(float(row == column) for column in range(4)) for row in range(4))


#: Settings of lens, focus and film by the keywords of `camera`.
INNER = {
    **{name: f"lens.{name}" for name in ("f_number", "pupil_diameter_mm", "blades", "blade_rotation_rad")},
    **{name: f"lens.{name}" for name in ("blade_curvature", "aperture_mask", "coating")},
    **{f"film_{name}": f"film.{name}" for name in ("width_mm", "height_mm")},
    **{name: f"film.{name}" for name in ("tilt_rad", "swing_rad", "shift_mm")},
    "focus_distance": "focus.distance",
    "film_distance_mm": "focus.film_distance_mm",
    "focus_point_world": "focus.point_world",
    "anchor": "focus.focusing.anchor",
    "focus_relation": "focus.focusing.relation",
}


def camera(lens, focal_length_mm: float | None = None, **settings) -> CameraDescription:
    """A camera at the origin; wide open, at infinity, one wavelength unless said otherwise."""
    plain = CameraDescription("Camera", IDENTITY, lens_path=os.fspath(lens), wavelength_nm=587.5618)
    inner = {INNER.get(name, name): value for name, value in settings.items()}
    return changed(plain, inner | {"lens.focal_length": focal_length(focal_length_mm)})


def info(lens_camera: object, width: int, height: int) -> dict:
    return json.loads(_native.camera_info_json(lens_camera, width, height))


def white_world(lens_camera: object, width: int, height: int, samples: int) -> np.ndarray:
    """(height, width, 3) of a uniform world of radiance one and nothing else; rows from below."""
    builder = _native.SceneBuilder()
    builder.set_world(WorldDescription(color=(1.0, 1.0, 1.0)))
    settings = SettingsDescription(width=width, height=height, samples=samples, seed=3)
    job = _native.Job(builder.build((0.0, 0.0, 0.0)), lens_camera, settings)
    assert job.wait(120.0)
    stats = SimpleNamespace(**json.loads(job.stats_json()))
    assert stats.non_finite_samples == 0
    assert stats.failure is None
    return job.image()[:, :, :3].astype(float)
