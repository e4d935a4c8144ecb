# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders without Blender: an empty world, straight through the engine's Python module."""

from __future__ import annotations

import importlib.util
import json
import os
import sys
from types import ModuleType, SimpleNamespace

import numpy as np

import petzval
from petzval import _native

IDENTITY = tuple(tuple(float(row == column) for column in range(4)) for row in range(4))


def description() -> ModuleType:
    """The add-on's plain data classes, which need no Blender."""
    name = "petzval_test_description"
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, petzval.addon_folder() / "description.py")
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        spec.loader.exec_module(module)
    return sys.modules[name]


def camera(lens, **settings) -> object:
    """A CameraDescription at the origin; wide open, at infinity, one wavelength unless said otherwise."""
    given = {"wavelength_nm": 587.5618, **settings}
    return description().CameraDescription(
        object_name="Camera", matrix_world=IDENTITY, model="LENS", lens_path=os.fspath(lens), **given
    )


def info(lens_camera: object, width: int, height: int) -> dict:
    return json.loads(_native.camera_info_json(lens_camera, width, height))


def white_world(lens_camera: object, width: int, height: int, samples: int) -> np.ndarray:
    """(height, width, 3) of a uniform world of radiance one and nothing else; rows from below."""
    builder = _native.SceneBuilder()
    builder.set_world(description().WorldDescription(color=(1.0, 1.0, 1.0)))
    settings = description().SettingsDescription(width=width, height=height, samples=samples, seed=3)
    job = _native.Job(builder.build((0.0, 0.0, 0.0)), lens_camera, settings)
    assert job.wait(120.0)
    stats = SimpleNamespace(**json.loads(job.stats_json()))
    assert stats.non_finite_samples == 0
    assert stats.failure is None
    return job.image()[:, :, :3].astype(float)
