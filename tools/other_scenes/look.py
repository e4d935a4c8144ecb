# SPDX-License-Identifier: GPL-3.0-or-later
"""A first look at scenes, several in one Blender, about a second each: `python -m other_scenes.look WIDTH HEIGHT SAMPLES SCENE ...` prints a
line of JSON a scene, with the difference of Petzval and Cycles. A scene without a camera is seen from a corner of the box about all that
it shows, under a sun if it has no light.
"""

from __future__ import annotations

import contextlib
import dataclasses
import json
import os
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

import petzval

from . import compare
from .job import LeftOut, opened, pixels_of, rendered, set_up

SEEDS = (1, 2)
#: The distance from the middle of the seen objects to the camera.
TOWARDS_CAMERA = Vector((0.6, -0.9, 0.5)).normalized()
SHAPES = {"MESH", "CURVE", "FONT", "SURFACE", "META", "CURVES", "VOLUME", "POINTCLOUD"}


def look(path: str, size: tuple[int, int], samples: int, folder: Path) -> dict[str, float]:
    """The difference of a scene."""
    scene = opened(path)
    if scene.camera is None:
        give_camera(scene)
    set_up(scene, size)
    shown = {
        program: [taken(scene, program, samples, seed, folder) for seed in SEEDS] for program in ("petzval", "cycles")
    }
    return dataclasses.asdict(compare.difference(shown["petzval"], shown["cycles"]))


def taken(scene: bpy.types.Scene, program: str, samples: int, seed: int, folder: Path) -> np.ndarray:
    """A picture, (height, width, 3)."""
    picture = str(folder / "picture.exr")
    rendered(scene, program, picture, samples, seed)
    return pixels_of(picture)


def give_camera(scene: bpy.types.Scene) -> None:
    """Adds a camera that sees all shapes, and a sun where there is no light."""
    places = [
        place.matrix_world @ Vector(corner)
        for place in bpy.context.evaluated_depsgraph_get().object_instances
        if place.object.type in SHAPES
        for corner in place.object.bound_box
    ]
    if not places:
        raise ValueError("it shows nothing")
    low, high = [Vector(one(place[axis] for place in places) for axis in range(3)) for one in (min, max)]
    radius = max((high - low).length / 2, 1e-3)
    scene.camera = linked(scene, bpy.data.cameras.new("Camera"))
    scene.camera.location = (low + high) / 2 + 2.6 * radius * TOWARDS_CAMERA
    scene.camera.rotation_euler = (-TOWARDS_CAMERA).to_track_quat("-Z", "Y").to_euler()
    scene.camera.data.clip_start, scene.camera.data.clip_end = 0.01 * radius, 20.0 * radius
    if not any(one.type == "LIGHT" for one in scene.objects):
        sun = linked(scene, bpy.data.lights.new("Sun", "SUN"))
        sun.data.energy, sun.rotation_euler = 3.0, (0.7, 0.3, 0.0)


def linked(scene: bpy.types.Scene, data: bpy.types.ID) -> bpy.types.Object:
    holder = bpy.data.objects.new(data.name, data)
    scene.collection.objects.link(holder)
    return holder


def main() -> None:
    width, height, samples, *scenes = sys.argv[1:]
    petzval.load_addon().register()
    # Blender prints what it saves.
    said = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    with tempfile.TemporaryDirectory() as folder:
        for path in scenes:
            found: dict[str, object] = {"scene": path}
            try:
                found |= look(path, (int(width), int(height)), int(samples), Path(folder))
            except (RuntimeError, ValueError, LeftOut) as why:
                found["left_out"] = str(why).strip().splitlines()[-1]
            print(json.dumps(found), file=said, flush=True)
        with contextlib.suppress(OSError):
            (Path(folder) / "picture.exr").unlink()
    # bpy may hang at its end.
    os._exit(0)


if __name__ == "__main__":
    main()
