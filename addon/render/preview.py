# SPDX-License-Identifier: GPL-3.0-or-later
"""Preview pictures of materials, lights and worlds: Blender's own small scene, without a lens and soon done."""

from __future__ import annotations

import dataclasses

import bpy

from petzval.description import changed

from ..data.tiles import Tile
from ..export import camera as camera_export
from ..export import settings as render_settings
from ..export.report import Report
from ..native import engine
from . import loop, staging
from .results import Results

# The picture has a few hundred pixels a side.
_SAMPLES = 32
_MOST_BOUNCES = 4


def render(host: bpy.types.RenderEngine, depsgraph: bpy.types.Depsgraph) -> None:
    """Renders a preview; `loop.Stopped` where Blender no longer wants it."""
    native, scene, report = engine(), depsgraph.scene_eval, Report()
    width, height = camera_export.resolution(scene.render)
    results = Results(host, depsgraph)

    def check_stop() -> None:
        if host.test_break():
            raise loop.Stopped

    camera = camera_export.describe(scene.camera, scene, width, height, report)
    camera = changed(camera, {"model": "PINHOLE", "focus.autofocus": None})
    builder = native.SceneBuilder()
    staging.fill(builder, depsgraph, camera, (width, height), report, check_stop)
    settings = dataclasses.replace(
        render_settings.describe(scene, width, height),
        samples=_SAMPLES,
        noise_threshold=0.0,
        max_bounces=_MOST_BOUNCES,
        integrator="PATH",
    )
    built = builder.build(staging.place(camera), settings.threads, None)
    job = native.Job(built, camera, settings)
    loop.follow(job, stop_asked=host.test_break, show=results.show, tell=lambda part, _: host.update_progress(part))
    results.show([Tile(0, 0, job.image())])
