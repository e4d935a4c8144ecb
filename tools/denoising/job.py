# SPDX-License-Identifier: GPL-3.0-or-later
"""One step inside of bpy: `python -m denoising.job STEP ...`.

guided SCENE COPY PASSES                            the scene with these guides of the denoiser, by Cycles' name of the choice
cycles SCENE OUT.exr WIDTH HEIGHT SAMPLES SEED HOW  HOW is "off", or the quality of denoising
read SCENE OUT.npz PICTURE.exr ...                  pixels of pictures by their stems: radiance, and as the scene shows it
"""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import bpy
import numpy as np
from other_scenes.job import ended, opened


def guided(path: str, copy: str, passes: str) -> None:
    scene = opened(path)
    scene.cycles.denoising_input_passes = passes
    scene.cycles.denoising_prefilter = "ACCURATE"
    bpy.ops.wm.save_as_mainfile(filepath=copy, relative_remap=True, copy=True)


def cycles(path: str, out: str, width: str, height: str, samples: str, seed: str, how: str) -> None:
    scene = opened(path)
    render, own = scene.render, scene.cycles
    render.engine, own.device = "CYCLES", "CPU"
    own.samples, own.seed, own.time_limit, own.use_adaptive_sampling = int(samples), int(seed), 0.0, False
    own.use_denoising = how != "off"
    own.denoiser = "OPENIMAGEDENOISE"
    if own.use_denoising and hasattr(own, "denoising_quality"):
        own.denoising_quality = how.upper()
    render.threads_mode, render.threads = "FIXED", os.cpu_count() or 1
    render.resolution_x, render.resolution_y, render.resolution_percentage = int(width), int(height), 100
    _exr(render.image_settings)
    render.filepath = out
    bpy.ops.render.render(write_still=True)


def _exr(settings: bpy.types.ImageFormatSettings) -> None:
    if hasattr(settings, "media_type"):
        settings.media_type = "IMAGE"
    settings.file_format, settings.color_depth = "OPEN_EXR", "32"


def read(path: str, out: str, *pictures: str) -> None:
    scene = opened(path)
    settings = scene.render.image_settings
    _exr(settings)
    settings.file_format, settings.color_mode, settings.color_depth = "PNG", "RGB", "16"
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for picture in map(Path, pictures):
            image = bpy.data.images.load(str(picture))
            shown = Path(folder) / f"{picture.stem}.png"
            image.save_render(str(shown), scene=scene)
            found[f"{picture.stem} shown"] = _pixels(bpy.data.images.load(str(shown)))
            found[picture.stem] = _pixels(image)
    np.savez(out, **found)


def _pixels(image: bpy.types.Image) -> np.ndarray:
    """The pixels of a file without conversion, (height, width, 3)."""
    image.colorspace_settings.name, image.alpha_mode = "Non-Color", "CHANNEL_PACKED"
    width, height = image.size
    flat = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(flat)
    return flat.reshape(height, width, image.channels)[::-1, :, :3]


if __name__ == "__main__":
    ended({"guided": guided, "cycles": cycles, "read": read})
