# SPDX-License-Identifier: GPL-3.0-or-later
"""One scene by both programs, in a process of its own: `python -m parity.job SCENE FOLDER WIDTH HEIGHT SAMPLES`.

SCENE is the name of a parity scene or a .blend file. Writes FOLDER/petzval.npy and, as two halves of other seeds,
FOLDER/cycles-0.npy and cycles-1.npy, all linear; and a line of JSON.
"""

from __future__ import annotations

import json
import os
import sys
import time
from pathlib import Path

import bpy
import numpy as np

from parity_scenes import SCENES, photograph

from . import MARK


def main(name: str, folder: Path, width: int, height: int, samples: int) -> dict:
    # bpy has it once it is there.
    import addon_utils

    from petzval import load_addon

    addon_utils.enable("cycles")
    addon = load_addon()
    addon.register()
    if name in SCENES:
        SCENES[name].open()
    else:
        bpy.ops.wm.open_mainfile(filepath=name, load_ui=False, use_scripts=False)
    scene = bpy.context.scene
    if scene.camera is None:
        return {"skipped": "it has no camera"}
    if scene.camera.data.type == "PANO":
        return {"skipped": "its camera is panoramic"}
    photograph.prepare(width, height, samples)
    began = time.perf_counter()
    np.save(folder / "petzval.npy", photograph.take("PETZVAL", folder))
    seconds = time.perf_counter() - began
    told = addon.statistics.last(scene.name)
    began = time.perf_counter()
    scene.cycles.samples = samples // 2
    for half in range(2):
        scene.cycles.seed = half
        np.save(folder / f"cycles-{half}.npy", photograph.take("CYCLES", folder))
    return {
        "warnings": list(told.warnings),
        "petzval_s": seconds,
        "cycles_s": time.perf_counter() - began,
        "blender": bpy.app.version_string,
    }


if __name__ == "__main__":
    name, folder, *numbers = sys.argv[1:]
    print(MARK + json.dumps(main(name, Path(folder), *map(int, numbers))), flush=True)
    # bpy with an engine registered may hang or crash at its end.
    os._exit(0)
