# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene inside of bpy: `python -m other_scenes.job SCENE WIDTH HEIGHT` renders it by both programs, as its standard input asks.

{"program": "cycles", "picture": "OUT.exr", "samples": 64, "seed": 1}      answered by {"seconds": of the processor}
{"pixels": "OUT.npz", "pictures": ["ONE.exr", ...]}                        (height, width, 3) by their stems
"""

from __future__ import annotations

import json
import os
import sys
import time
from pathlib import Path

import bpy
import numpy as np

import petzval
from petzval import blender_faults

#: The reason why a file that is a part of others is left out.
NO_CAMERA = "it has no camera"


class LeftOut(Exception):
    """A scene cannot be compared; the message says why."""


def opened(path: str) -> bpy.types.Scene:
    bpy.ops.wm.open_mainfile(filepath=path, load_ui=False, use_scripts=False)
    return bpy.context.scene


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


def set_up(scene: bpy.types.Scene, size: tuple[int, int]) -> None:
    """Sets both programs to what they are compared by."""
    if scene.camera is None:
        raise LeftOut(NO_CAMERA)
    if scene.camera.data.type == "PANO":
        raise LeftOut("its camera is panoramic")
    without_what_differs(scene)
    render, own, petzval = scene.render, scene.cycles, scene.petzval
    render.threads_mode, render.threads = "FIXED", os.cpu_count() or 1
    render.resolution_x, render.resolution_y, render.resolution_percentage = *size, 100
    render.use_persistent_data = False
    own.device, own.time_limit = "CPU", 0.0
    own.use_denoising = own.use_adaptive_sampling = False
    petzval.use_noise_threshold = petzval.use_blue_noise = petzval.use_checkpoints = False
    scene.camera.data.petzval.model = "PINHOLE"
    settings = render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "IMAGE"
    settings.file_format, settings.color_depth = "OPEN_EXR", "32"


def rendered(scene: bpy.types.Scene, program: str, picture: str, samples: int, seed: int) -> float:
    """Renders a picture by a program; gives the processor seconds that it took."""
    scene.render.engine, scene.render.filepath = program.upper(), picture
    for own in (scene.cycles, scene.petzval):
        own.samples, own.seed = samples, seed
    before = time.process_time()
    bpy.ops.render.render(write_still=True)
    return time.process_time() - before


def serve(path: str, width: str, height: str) -> None:
    """Does in one Blender, with one scene, what the lines of standard input ask for, in JSON; each is answered by a line."""
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    # Blender prints there, too.
    os.dup2(2, 1)
    petzval.load_addon().register()
    scene = opened(path)
    set_up(scene, (int(width), int(height)))
    for line in sys.stdin:
        asked = json.loads(line)
        if "pixels" in asked:
            np.savez(asked["pixels"], **{Path(one).stem: pixels_of(one) for one in asked["pictures"]})
            print(json.dumps({}), file=answers)
        else:
            print(json.dumps({"seconds": rendered(scene, **asked)}), file=answers)


def pixels_of(path: str) -> np.ndarray:
    """A picture, (height, width, 3)."""
    image = bpy.data.images.load(path)
    image.colorspace_settings.name, image.alpha_mode = "Non-Color", "CHANNEL_PACKED"
    width, height = image.size
    flat = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(flat)
    bpy.data.images.remove(image)
    return flat.reshape(height, width, -1)[..., :3]


def main() -> None:
    code = 1
    try:
        serve(*sys.argv[1:])
        code = 0
    except LeftOut as why:
        print(why, file=sys.stderr, flush=True)
    except Exception as error:  # noqa: BLE001 (its last line is shown)
        print(f"{type(error).__name__}: {error}", file=sys.stderr, flush=True)
    # bpy may hang or crash at its end.
    sys.stdout.flush()
    os._exit(code)


if __name__ == "__main__":
    main()
