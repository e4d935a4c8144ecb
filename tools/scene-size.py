#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The cost of a large scene: memory and time of a tiny render, by Petzval or by Cycles, in a Python with bpy and petzval.

.venv-bpy52/bin/python tools/scene-size.py mesh 1e6            one mesh of so many triangles, smooth, with a UV map
.venv-bpy52/bin/python tools/scene-size.py forest 1e7          as many in instances of a tree of 5000
.venv-bpy52/bin/python tools/scene-size.py mesh 1e6 --cycles
"""

import argparse
import os
import resource
import sys
import time
from pathlib import Path

import bpy
import numpy as np
from growth.scenes import waves

import petzval

TREE_TRIANGLES = 5000


def resident_bytes() -> int:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize()


def forest(triangles: int) -> int:
    """Instances of one tree at the vertices of another mesh; returns their number of triangles."""
    tree = bpy.data.objects.new("Tree", waves("Tree", TREE_TRIANGLES, 2.0))
    each = 2 * len(tree.data.polygons)
    side = max(round((triangles / each) ** 0.5), 1)
    x, y = np.meshgrid(*[np.arange(side, dtype=np.float32) * 0.5] * 2)
    ground = bpy.data.meshes.new("Ground")
    ground.vertices.add(side * side)
    ground.vertices.foreach_set("co", np.stack([x - side * 0.25, y, np.zeros_like(x)], -1).ravel())
    holder = bpy.data.objects.new("Ground", ground)
    for one in (holder, tree):
        bpy.context.scene.collection.objects.link(one)
    tree.parent, holder.instance_type = holder, "VERTS"
    return side * side * each


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("kind", choices=("mesh", "forest"))
    parser.add_argument("triangles", type=float)
    parser.add_argument("--cycles", action="store_true", help="by Cycles, for comparison")
    asked = parser.parse_args()

    bpy.ops.wm.read_factory_settings(use_empty=True)
    petzval.load_addon().register()
    scene = bpy.context.scene
    scene.render.engine = "CYCLES" if asked.cycles else "PETZVAL"
    scene.render.resolution_x = scene.render.resolution_y = 64
    scene.cycles.device, scene.cycles.samples, scene.petzval.samples = "CPU", 4, 4
    scene.cycles.use_denoising = False
    scene.world = bpy.data.worlds.new("World")
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0.0, -30.0, 15.0), (1.1, 0.0, 0.0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    if asked.kind == "mesh":
        holder = bpy.data.objects.new("Waves", waves("Waves", int(asked.triangles), 2.0))
        holder.scale = (10.0, 10.0, 10.0)
        scene.collection.objects.link(holder)
        triangles = 2 * len(holder.data.polygons)
    else:
        triangles = forest(int(asked.triangles))

    bpy.context.view_layer.update()
    before, began = resident_bytes(), time.perf_counter()
    bpy.ops.render.render()
    seconds = time.perf_counter() - began
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    print(
        f"{asked.kind}, {triangles:,} triangles, {scene.render.engine}: {seconds:.2f} s; memory {before / 1e6:.0f} MB before, "
        f"{most / 1e6:.0f} MB at most, {(most - before) / triangles:.1f} bytes a triangle more"
    )
    sys.stdout.flush()
    # bpy with a render engine registered may hang at its end.
    os._exit(0)


if __name__ == "__main__":
    main()
