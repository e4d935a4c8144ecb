# SPDX-License-Identifier: GPL-3.0-or-later
"""The work inside of bpy, for a driver that may have to begin it anew: a line of JSON on stdin asks, a line on stdout answers.

`{"walk": VALUES}` gives the stage's settings. `{"set": [[OWNER, NAME, VALUE], ...], "context": [[OWNER, NAME, VALUE], ...], "look": N}` gives
the changes of both programs' pictures by these values, in a stage that the context has changed before.
"""

from __future__ import annotations

import contextlib
import json
import os
import sys
import tempfile
from pathlib import Path
from typing import Any

import bpy
import numpy as np

import petzval
from support import scenes

from . import compare, owners, stage, worker

#: The mark before an answer, among all that Blender prints.
MARK = worker.MARK
#: Samples of the first look; each further one has four times those of the one before.
SAMPLES = 32
Values = list[list[Any]]


class Walk:
    """The stage in a file of its own, and the pictures of it as it is, by context."""

    def __init__(self, folder: Path, samples: int) -> None:
        self.folder, self.samples = folder, samples
        self.file = folder / "stage.blend"
        self.before: dict[str, tuple[list[np.ndarray], list[np.ndarray]]] = {}
        stage.build()
        bpy.ops.wm.save_as_mainfile(filepath=str(self.file))

    def opened(self, values: Values) -> list[str]:
        """Opens the stage and sets values; returns those that could not be set."""
        bpy.ops.wm.open_mainfile(filepath=str(self.file), load_ui=False)
        return [f"{owner}.{name}: {said}" for owner, name, value in values if (said := owners.put(owner, name, value))]

    def pictures(self, look: int) -> tuple[list[np.ndarray], list[np.ndarray]]:
        """The pictures of two seeds by Petzval and by Cycles, of the stage that is open."""
        taken: list[list[np.ndarray]] = []
        scene = bpy.context.scene
        for engine in ("PETZVAL", "CYCLES"):
            scene.render.engine = engine
            taken.append([])
            for seed in (2 * look, 2 * look + 1):
                scene.petzval.samples = scene.cycles.samples = self.samples * 4**look
                scene.petzval.seed = scene.cycles.seed = seed
                path = self.folder / "picture.exr"
                path.unlink(missing_ok=True)
                scene.render.filepath = str(path)
                bpy.ops.render.render(write_still=True)
                taken[-1].append(scenes.read(path))
        return taken[0], taken[1]

    def changed(self, values: Values, context: Values, look: int) -> dict[str, Any]:
        key = json.dumps([context, look])
        if key not in self.before:
            wrong = self.opened(context)
            if wrong:
                return {"failed": "; ".join(wrong)}
            self.before[key] = self.pictures(look)
        wrong = self.opened([*context, *values])
        if len(wrong) == len(values):
            return {"failed": "; ".join(wrong)}
        here, cycles = zip(self.before[key], self.pictures(look), strict=True)
        return compare.found(here, cycles).told() | {"not_set": wrong}


def answer(walk: Walk, asked: dict[str, Any]) -> Any:
    if "walk" in asked:
        walk.opened([])
        return owners.settings(asked["walk"])
    return walk.changed(asked["set"], asked["context"], asked["look"])


def main() -> None:
    petzval.load_addon().register()
    with tempfile.TemporaryDirectory() as folder:
        walk = Walk(Path(folder), int(sys.argv[1]) if len(sys.argv) > 1 else SAMPLES)
        for line in sys.stdin:
            try:
                told = answer(walk, json.loads(line))
            except Exception as error:  # noqa: BLE001 (it is the answer)
                told = {"failed": f"{type(error).__name__}: {error}"}
            print(MARK + json.dumps(told), flush=True)
    with contextlib.suppress(BrokenPipeError):
        sys.stdout.flush()
    # bpy may hang at its end.
    os._exit(0)


if __name__ == "__main__":
    main()
