# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes by both programs: `python -m parity.job WIDTH HEIGHT SAMPLES MOST SCENE FOLDER [SCENE FOLDER ...]`.

SCENE is the name of a parity scene or a .blend file. Each program takes it in two halves of other seeds, until the halves
say that the noise of blocks is small and blocks are alike, or until MOST samples. Writes FOLDER/looks.npz, linear: petzval/NAME, the halves
cycles-0/NAME and cycles-1/NAME, for the picture or each pass or frame; and a line of JSON for each scene when it is done.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

import bpy
import numpy as np

from parity_scenes import SCENES, photograph
from support import beside_cycles

from . import MARK, in_blender
from .blocks import block_noise, block_ratios, floor_of

#: The noise of a block that is small enough, where blocks are no farther apart than that.
ENOUGH, ALIKE = 0.006, 0.01
ENGINES = ("PETZVAL", "CYCLES")


class Halves:
    """The two half renders of a program, and the processor time that they took, s."""

    def __init__(self, engine: str, folder: Path, passes: tuple[str, ...], frames: tuple[int, ...]) -> None:
        self.engine, self.folder, self.passes, self.frames = engine, folder, passes, frames
        self.samples, self.seeds, self.seconds = 0, 0, 0.0
        self.looks: list[dict[str, np.ndarray]] = [{}, {}]

    def add(self, samples: int) -> None:
        """Adds so many samples to a pixel of each half."""
        scene = bpy.context.scene
        began = time.process_time()
        for half in self.looks:
            scene.petzval.samples = scene.cycles.samples = samples
            scene.petzval.seed = scene.cycles.seed = self.seeds
            self.seeds += 1
            for name, pixels in photograph.looks(self.engine, self.folder, self.passes, self.frames).items():
                before = half.get(name, 0.0)
                half[name] = (before * self.samples + pixels * samples) / (self.samples + samples)
        self.samples += samples
        self.seconds += time.process_time() - began

    def of(self, look: str) -> list[np.ndarray]:
        return [half[look] for half in self.looks]

    def mean(self, look: str) -> np.ndarray:
        return 0.5 * sum(self.of(look))


def photographed(addon, name: str, folder: Path, width: int, height: int, samples: int, most: int) -> dict:
    """A scene by both programs; returns the findings."""
    one = SCENES.get(name)
    if one:
        one.open()
    else:
        bpy.ops.wm.open_mainfile(filepath=name, load_ui=False, use_scripts=False)
    scene = bpy.context.scene
    if scene.camera is None:
        return {"skipped": "it has no camera"}
    if scene.camera.data.type == "PANO":
        return {"skipped": "its camera is panoramic"}
    photograph.prepare(width, height, samples)
    beside_cycles.small_sky_table()
    wanted = (one.passes, one.frames) if one else ((), ())
    ours, theirs = (Halves(engine, folder, *wanted) for engine in ENGINES)
    while True:
        for halves in (ours, theirs):
            halves.add(halves.samples or samples // 2)
            if halves is ours:
                told = list(addon.render.statistics.last(scene.name).warnings)
        noise = max(block_noise(ours.of(look), theirs.of(look), floor_of(look)) for look in ours.looks[0])
        apart = max(
            np.abs(block_ratios(ours.mean(look), theirs.mean(look), floor_of(look)) - 1.0).max()
            for look in ours.looks[0]
        )
        if (noise < ENOUGH and apart < ALIKE) or 4 * ours.samples > most:
            break
    kept = {f"petzval/{look}": ours.mean(look) for look in ours.looks[0]}
    kept |= {f"cycles-{i}/{look}": pixels for i, half in enumerate(theirs.looks) for look, pixels in half.items()}
    np.savez_compressed(folder / "looks.npz", **{look: np.asarray(pixels, np.float32) for look, pixels in kept.items()})
    return {
        "warnings": told,
        "samples": 2 * ours.samples,
        "noise": noise,
        "petzval_s": ours.seconds,
        "cycles_s": theirs.seconds,
        "blender": bpy.app.version_string,
    }


def main(numbers: list[str], scenes: list[str]) -> None:
    addon = in_blender.registered()
    for name, folder in zip(scenes[::2], scenes[1::2], strict=True):
        found = photographed(addon, name, Path(folder), *map(int, numbers))
        # From the start of a line: Blender says things without an end.
        print("\n" + MARK + json.dumps(found), flush=True)


if __name__ == "__main__":
    in_blender.end(main, sys.argv[1:5], sys.argv[5:])
