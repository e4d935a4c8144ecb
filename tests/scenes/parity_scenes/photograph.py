# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene that is open, photographed by Petzval and by Cycles through the same pinhole, with nothing that trades truth
for speed: no clamping, no filtered gloss, no denoising, no adaptive sampling."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np

import beside_cycles
import scene_parts

BOUNCES = 16


def prepare(width: int, height: int, samples: int, bounces: int = BOUNCES) -> None:
    """Sets both programs to the same, and the camera to a pinhole."""
    scene = bpy.context.scene
    render = scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
    render.use_compositing = render.use_sequencer = render.use_border = False
    scene_parts.exr(scene)
    scene.camera.data.petzval.model = "PINHOLE"
    beside_cycles.without_tricks(samples)
    own, cycles = scene.petzval, scene.cycles
    own.seed = cycles.seed = 0
    own.max_bounces = cycles.max_bounces = bounces
    for kind in ("diffuse", "glossy", "transmission"):
        setattr(cycles, f"{kind}_bounces", bounces)
    cycles.transparent_max_bounces = 64
    cycles.caustics_reflective = cycles.caustics_refractive = True


def take(engine: str, folder: Path) -> np.ndarray:
    """The picture of `PETZVAL` or `CYCLES`: linear, (height, width, 4), first row at the bottom."""
    bpy.context.scene.render.engine = engine
    return scene_parts.render(folder, f"{engine.lower()}.exr")
