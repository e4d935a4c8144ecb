# SPDX-License-Identifier: GPL-3.0-or-later
"""One step inside of bpy: `python -m other_scenes.job STEP ...`.

prepare SCENE COPY                     the scene without the parts that the comparison leaves out
cycles SCENE OUT.exr WIDTH HEIGHT SAMPLES SEED
read OUT.npz PICTURE.exr ...           pixels of pictures, (height, width, 3), by their stems
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

import bpy
import numpy as np

from petzval import blender_faults


def opened(path: str) -> bpy.types.Scene:
    bpy.ops.wm.open_mainfile(filepath=path, load_ui=False, use_scripts=False)
    return bpy.context.scene


def prepare(path: str, copy: str) -> None:
    """Saves a copy of a scene without the parts that differ."""
    scene = opened(path)
    if scene.camera is None:
        raise SystemExit("it has no camera")
    without_what_differs(scene)
    bpy.ops.wm.save_as_mainfile(filepath=copy, relative_remap=True, copy=True)


def without_what_differs(scene: bpy.types.Scene) -> None:
    """Both programs are compared without depth of field and motion blur, which Petzval has its own ways for, and without clamps, which
    make each wrong in its own way."""
    blender_faults.keep_fluids(scene)
    scene.render.use_motion_blur = scene.render.use_border = scene.render.use_freestyle = False
    scene.render.use_compositing = scene.render.use_sequencer = False
    # Colours are compared, whatever the file is saved in.
    scene.render.image_settings.color_mode = "RGB"
    cycles = scene.cycles
    cycles.use_animated_seed = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    # A driven seed would be the same for every picture.
    if scene.animation_data:
        for driver in [one for one in scene.animation_data.drivers if "seed" in one.data_path]:
            scene.animation_data.drivers.remove(driver)
        scene.animation_data.action = None
    camera = scene.camera.data
    camera.dof.use_dof = False
    camera.shift_x = camera.shift_y = 0.0
    # Shadow caustics lose light: docs/parity.md.
    for light in bpy.data.lights:
        light.cycles.is_caustics_light = False


def cycles(path: str, out: str, width: str, height: str, samples: str, seed: str) -> None:
    scene = opened(path)
    render, own = scene.render, scene.cycles
    render.engine, own.device = "CYCLES", "CPU"
    own.samples, own.seed, own.time_limit = int(samples), int(seed), 0.0
    own.use_denoising = own.use_adaptive_sampling = False
    render.threads_mode, render.threads = "FIXED", os.cpu_count() or 1
    render.resolution_x, render.resolution_y, render.resolution_percentage = int(width), int(height), 100
    settings = render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "IMAGE"
    settings.file_format, settings.color_depth = "OPEN_EXR", "32"
    render.filepath = out
    bpy.ops.render.render(write_still=True)


def read(out: str, *pictures: str) -> None:
    np.savez(out, **{Path(path).stem: pixels_of(path) for path in pictures})


def pixels_of(path: str) -> np.ndarray:
    """A picture, (height, width, 3)."""
    image = bpy.data.images.load(path)
    image.colorspace_settings.name, image.alpha_mode = "Non-Color", "CHANNEL_PACKED"
    width, height = image.size
    flat = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(flat)
    bpy.data.images.remove(image)
    return flat.reshape(height, width, -1)[..., :3]


def ended(steps: dict[str, Callable[..., None]]) -> NoReturn:
    """Does the step that the command line names, and ends the process."""
    code = 1
    try:
        steps[sys.argv[1]](*sys.argv[2:])
        code = 0
    except SystemExit as why:
        print(why, file=sys.stderr, flush=True)
    except Exception as error:  # noqa: BLE001 (its last line is shown)
        print(f"{type(error).__name__}: {error}", file=sys.stderr, flush=True)
    # bpy may hang or crash at its end.
    sys.stdout.flush()
    os._exit(code)


if __name__ == "__main__":
    ended({"prepare": prepare, "cycles": cycles, "read": read})
