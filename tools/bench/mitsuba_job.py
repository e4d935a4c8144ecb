# SPDX-License-Identifier: GPL-3.0-or-later
"""One process of Mitsuba: `python -m bench.mitsuba_job JOB`, JOB as `programs.Job` in JSON; a line of JSON a render."""

from __future__ import annotations

import json
import resource
import sys
import time
from pathlib import Path

import drjit as dr
import mitsuba as mi
import numpy as np

from . import MARK

#: The LLVM variants hold the state of every path of a pass: more samples are rendered in several passes. Powers of two,
#: as other counts would be compiled anew.
SAMPLES_A_PASS = (16, 8, 4, 2, 1)


def main(job: dict) -> None:
    mi.set_variant(job["program"])
    from . import mitsuba_scene

    folder = Path(job["folder"])
    mitsuba_scene.write_meshes(folder)
    # Of the scalar variants too: one pool works for all.
    dr.set_thread_count(job["threads"])
    began = time.perf_counter()
    scene = mi.load_dict(mitsuba_scene.description(folder, tuple(job["size"]), job["camera"] == "thin"))
    load_s = time.perf_counter() - began
    if job["program"] == "llvm_ad_rgb" and job["camera"] == "rays":
        from . import embree

        return _say(**embree.measure(scene))
    # The first pictures compile.
    for count in (1, 2):
        np.array(mi.render(scene, spp=count, seed=987654))
    for samples, seed in job["renders"]:
        before, began = resource.getrusage(resource.RUSAGE_SELF), time.perf_counter()
        picture = _render(scene, samples, seed)
        wall, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_SELF)
        found = {}
        if job["keep"]:
            name = f"{job['picture']}-{samples}-{seed}.npy"
            np.save(name, picture.astype(np.float32))
            found["file"] = name
        user = after.ru_utime - before.ru_utime
        _say(samples=samples, seed=seed, user_s=user, wall_s=wall, peak_mb=after.ru_maxrss / 1024.0, tree_s=load_s,
             **found)  # fmt: skip


def _render(scene: mi.Scene, samples: int, seed: int) -> np.ndarray:
    total, done, turn = 0.0, 0, 0
    while done < samples:
        part = next(count for count in SAMPLES_A_PASS if count <= samples - done)
        # Passes of one picture must not share a seed with those of another.
        total = total + part * np.array(mi.render(scene, spp=part, seed=seed * 65536 + turn), dtype=np.float64)
        done, turn = done + part, turn + 1
    return total / samples


def _say(**found: object) -> None:
    print(MARK + json.dumps(found), flush=True)


if __name__ == "__main__":
    main(json.loads(sys.argv[1]))
