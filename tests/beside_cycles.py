# SPDX-License-Identifier: GPL-3.0-or-later
"""The open scene by Petzval and by Cycles in the same Blender, and how far apart the two pictures are. Imported inside of
tests: it needs bpy."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np

import scene_parts

#: Columns of the table by which Cycles chooses directions of a sky. It computes one of its own choice for more than a second
#: before each render; what is seen does not depend on it.
SKY_TABLE = 256

#: Few samples tell most pictures that agree: a look is taken with one part in so many, and where both are not within this share
#: of the limits, another one with more. What is truly beyond a limit passes an early look less often than the last: a third
#: of the limit is more there than the noise that the last one has.
LOOKS = ((8, 2 / 3), (2, 2 / 3), (1, 1.0))


def without_tricks(samples: int) -> None:
    """Sets both programs to the same, with nothing that trades truth for speed: no clamping, no filtered gloss, no
    denoising, no adaptive sampling."""
    scene = bpy.context.scene
    own, cycles = scene.petzval, scene.cycles
    own.samples = cycles.samples = samples
    own.filter_width, own.clamp_indirect, own.noise_threshold = 0.0, 0.0, 0.0
    cycles.device = "CPU"
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    cycles.pixel_filter_type = "BOX"
    scene.camera.data.dof.use_dof = False


def small_sky_table() -> None:
    """Where Cycles would choose the size of its table itself."""
    world = bpy.context.scene.world
    if world is not None and world.cycles.sampling_method == "AUTOMATIC":
        world.cycles.sampling_method, world.cycles.sample_map_resolution = "MANUAL", SKY_TABLE


def both(folder: Path, samples: int, bounces: int | None = None, **cycles_settings) -> tuple[np.ndarray, np.ndarray]:
    """Petzval's picture and Cycles's, (height, width, 3). `bounces` of every kind, else as the scene has them."""
    without_tricks(samples)
    small_sky_table()
    scene = bpy.context.scene
    if bounces is not None:
        scene.petzval.max_bounces = bounces
        for kind in ("max", "diffuse", "glossy", "transmission", "transparent_max"):
            setattr(scene.cycles, f"{kind}_bounces", bounces)
    for name, value in cycles_settings.items():
        setattr(scene.cycles, name, value)
    ours = scene_parts.render(folder, "petzval.exr")[..., :3]
    warnings = scene_parts.part("statistics").last(scene.name).warnings
    assert not warnings, warnings
    scene.render.engine = "CYCLES"
    try:
        theirs = scene_parts.render(folder, "cycles.exr")[..., :3]
    finally:
        scene.render.engine = "PETZVAL"
    return ours, theirs


def apart(ours: np.ndarray, theirs: np.ndarray, side: int, floor: float = 0.1) -> tuple[float, float]:
    """How far apart pictures are in the mean of a channel, and at most in that of a block of `side` pixels. Blocks are compared
    with themselves and a part of the mean, lest the noise of dark ones count."""
    height, width = ours.shape[:2]
    blocks = [p.reshape(height // side, side, width // side, side, 3).mean((1, 3)) for p in (ours, theirs)]
    off = np.abs(blocks[0] - blocks[1]) / (blocks[1] + floor * blocks[1].mean())
    means = np.abs(ours.mean((0, 1)) - theirs.mean((0, 1))) / np.maximum(theirs.mean((0, 1)), 1e-12)
    return float(means.max()), float(off.max())


def alike(
    folder: Path, samples: int, *, side: int, mean: float, block: float, floor: float = 0.1, **more
) -> np.ndarray:
    """Asserts that both show the same within limits of `apart`; gives Petzval's picture. `more` is for `both`."""
    for part, share in LOOKS:
        ours, theirs = both(folder, samples // part, **more)
        assert theirs.mean() > 1e-4, "the scene is dark in Cycles"
        found = apart(ours, theirs, side, floor)
        print(f"{samples // part} samples: mean {found[0]:.4f} (of {mean}), block {found[1]:.4f} (of {block})")
        if found[0] < share * mean and found[1] < share * block:
            return ours
    raise AssertionError(f"mean {found[0]:.4f} (within {mean}?), worst block {found[1]:.4f} (within {block}?)")
