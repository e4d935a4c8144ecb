# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes in which Cycles is not exact, rendered each way: `python -m parity.limits FOLDER`, in an environment with bpy.

Writes FOLDER/NAME.npz, a linear picture of each way; and a line of JSON: by name the title, the evidence, and of each way its label,
the mean of its picture and whether it is the truth.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np

from cycles_limits import LIMITS
from parity_scenes import photograph

from . import MARK, in_blender


def rendered(folder: Path) -> dict[str, dict]:
    """Every scene, every way: the findings, and the pictures in the folder."""
    found = {}
    for name, one in LIMITS.items():
        pictures = []
        for way in one.ways:
            one.open(way)
            pictures.append(photograph.take(way.engine, folder)[..., :3])
        np.savez_compressed(folder / f"{name}.npz", *pictures)
        means = [float(picture.mean(dtype=np.float64)) for picture in pictures]
        truth = next(mean for mean, way in zip(means, one.ways, strict=True) if way.is_truth)
        found[name] = {
            "title": one.title,
            "evidence": one.evidence,
            "truth": truth,
            "ways": [[way.label, mean, way.is_truth] for way, mean in zip(one.ways, means, strict=True)],
        }
    return found


def main(folder: str) -> None:
    in_blender.registered()
    print("\n" + MARK + json.dumps(rendered(Path(folder))), flush=True)


if __name__ == "__main__":
    in_blender.end(main, *sys.argv[1:])
