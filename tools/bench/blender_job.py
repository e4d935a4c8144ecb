# SPDX-License-Identifier: GPL-3.0-or-later
"""One process of Cycles or Petzval: `python -m bench.blender_job JOB`, JOB as `programs.Job` in JSON.

Writes a line of JSON a render, after the mark that tells it from Blender's output.
"""

from __future__ import annotations

import json
import os
import resource
import sys
import time
import types
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from . import MARK


def main(job: dict) -> None:
    folder = Path(job["folder"])
    if job["program"] == "build":
        from . import blender_scene

        blender_scene.build(folder)
        return _say(version=bpy.app.version_string)
    import addon_utils

    addon_utils.enable("cycles")
    bpy.ops.wm.open_mainfile(filepath=str(folder / "scene.blend"), load_ui=False, use_scripts=False)
    if job["program"] == "blender":
        # What Blender takes with the scene loaded, whoever renders it.
        bpy.context.evaluated_depsgraph_get()
        return _say(peak_mb=_peak_mb(), version=bpy.app.version_string)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = job["size"]
    scene.render.threads_mode, scene.render.threads = "FIXED", job["threads"]
    statistics = (_petzval if job["program"] == "petzval" else _cycles)(scene, job)
    for samples, seed in job["renders"]:
        _render(scene, job, samples, seed, statistics)


def _petzval(scene: Any, job: dict) -> Any:
    from petzval import load_addon

    addon = load_addon()
    addon.register()
    scene.render.engine = "PETZVAL"
    own = scene.camera.data.petzval
    own.model = {"pinhole": "PINHOLE", "thin": "THIN"}.get(job["camera"], "LENS")
    own.match_viewport = False
    if own.model == "LENS":
        own.lens_file = job["lens"]["path"]
        own.focal_mode, own.focal_length = "LENGTH", job["lens"]["focal_length_mm"]
        own.wide_open, own.f_number = False, job["lens"]["f_number"]
        own.focus_mode, own.anchor = "CAMERA", "ENTRANCE_PUPIL"
        own.spectrum = "SINGLE" if job["camera"] == "lens-one" else "VISIBLE"
        # Framed by the film itself, not by Blender's focal length.
        own.film_mode = "SENSOR"
    scene.petzval.filter_width = 0.0
    scene.petzval.clamp_indirect = 0.0
    scene.petzval.max_bounces = scene.cycles.max_bounces
    return lambda: addon.render.statistics.last(scene.name).stats


def _cycles(scene: Any, job: dict) -> None:
    scene.render.engine = "CYCLES"
    data = scene.camera.data
    data.dof.use_dof = job["camera"] == "thin"
    if job["camera"] == "lens-one":
        try:
            import oslquery  # noqa: F401
        except ImportError:
            # Asked for the parameters of a script only, of which this one has none; the module bpy comes without it.
            stub = types.ModuleType("oslquery")
            stub.OSLQuery = lambda _path: types.SimpleNamespace(parameters=[])
            sys.modules["oslquery"] = stub
        data.type, data.custom_mode = "CUSTOM", "EXTERNAL"
        data.custom_filepath = job["script"]
        data.update_tag()


def _render(scene: Any, job: dict, samples: int, seed: int, statistics: Any) -> None:
    own = scene.petzval if job["program"] == "petzval" else scene.cycles
    own.samples, own.seed = samples, seed
    path = Path(job["picture"]).with_suffix(f".{os.getpid()}.exr")
    scene.render.filepath = str(path)
    before, began = resource.getrusage(resource.RUSAGE_SELF), time.perf_counter()
    bpy.ops.render.render(write_still=True)
    wall, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_SELF)
    found: dict[str, Any] = {}
    if statistics is not None:
        stats = statistics()
        found["sync_s"], found["tree_s"] = stats["seconds"]["sync"], stats["seconds"]["bvh"]
        found["lost"] = stats["camera_rays_lost"] / max(stats["camera_rays"], 1)
    if job["keep"]:
        np.save(_name(job, samples, seed), _pixels(path))
        found["file"] = str(_name(job, samples, seed))
    path.unlink()
    user = after.ru_utime - before.ru_utime
    _say(samples=samples, seed=seed, user_s=user, wall_s=wall, peak_mb=after.ru_maxrss / 1024.0, **found)


def _name(job: dict, samples: int, seed: int) -> Path:
    return Path(f"{job['picture']}-{samples}-{seed}.npy")


def _pixels(path: Path) -> np.ndarray:
    """Scene-linear, (height, width, 3), the top row first."""
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    width, height = image.size
    flat = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(flat)
    bpy.data.images.remove(image)
    return flat.reshape(height, width, -1)[::-1, :, :3]


def _peak_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def _say(**found: Any) -> None:
    print(MARK + json.dumps(found), flush=True)


if __name__ == "__main__":
    try:
        main(json.loads(sys.argv[1]))
        status = 0
    except BaseException:
        import traceback

        traceback.print_exc()
        status = 1
    sys.stdout.flush()
    sys.stderr.flush()
    # bpy with a render engine registered may crash when Python ends by itself.
    os._exit(status)
