# SPDX-License-Identifier: GPL-3.0-or-later
"""One measurement inside of bpy: `python -m growth.job PROGRAM KIND NUMBER SAMPLES` prints a line of JSON.

`once_s`: processor time of a render of one sample a pixel; `again_s`: of the next frame, before which the camera moves; `sample_us`: of each
further sample; `memory_mb`: the most that the first render takes beside Blender's own memory.
"""

from __future__ import annotations

import json
import os
import resource
import sys
from pathlib import Path

import bpy

import petzval

from .scenes import KINDS, new

WIDTH, HEIGHT = 96, 54


def resident_mb() -> float:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 1e6


def most_mb() -> float:
    """The most that was resident since `forget_most`."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmHWM"):
            return int(line.split()[1]) * 1024 / 1e6
    raise RuntimeError("/proc/self/status does not say VmHWM")


def forget_most() -> None:
    """Building a scene takes memory, too."""
    Path("/proc/self/clear_refs").write_text("5")


def rendered(scene: bpy.types.Scene, samples: int) -> float:
    """Processor seconds of a render with a number of samples."""
    scene.cycles.samples = scene.petzval.samples = samples
    # Blender does not tell its copy of the scene by itself.
    scene.update_tag()
    return timed()


def timed() -> float:
    """Processor seconds of a render."""
    before = resource.getrusage(resource.RUSAGE_SELF)
    bpy.ops.render.render()
    after = resource.getrusage(resource.RUSAGE_SELF)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measured(program: str, name: str, number: int, samples: int) -> dict[str, float]:
    kind = KINDS[name]
    petzval.load_addon().register()
    width, height = WIDTH, HEIGHT
    if kind.of_picture == "pixels":
        height = max(round((number * 9 / 16) ** 0.5), 1)
        width = max(round(number / height), 1)
    scene = new(width, height, number if kind.of_picture == "samples" else 1)
    kind.build(scene, number)
    scene.render.engine = {"petzval": "PETZVAL", "cycles": "CYCLES"}[program]
    bpy.context.view_layer.update()
    forget_most()
    before = resident_mb()
    found = {"once_s": timed(), "memory_mb": most_mb() - before}
    scene.frame_set(2)
    found["again_s"] = timed()
    if not kind.of_picture:
        fewest = rendered(scene, 1)
        more = rendered(scene, 1 + samples)
        found["sample_us"] = max(more - fewest, 0.0) / (width * height * samples) * 1e6
    return found


def main() -> None:
    program, name, number, samples = sys.argv[1:]
    print(json.dumps(measured(program, name, int(number), int(samples))), flush=True)
    # bpy may hang at its end.
    os._exit(0)


if __name__ == "__main__":
    main()
