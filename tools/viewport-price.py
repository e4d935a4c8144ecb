#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The delay of an edit in a 3D view in rendered shading: docs/viewport.md's table, by the view's own steps, without a screen.

Run by `make viewport-price` in an environment with bpy. `--scene FILE`, `--divide N` (of the scene's resolution, default 4).
"""

from __future__ import annotations

import argparse
import dataclasses
import os
import statistics
import sys
import time
from importlib import import_module
from pathlib import Path

import bpy
import pages

import petzval

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/viewport.md"
BEGIN, END = "<!-- table of tools/viewport-price.py -->", "<!-- end of the table -->"
REPEATS = 7

addon = petzval.load_addon()
addon.register()


def part(name: str):
    return import_module(f"{addon.__name__}.{name}")


class Clock:
    """One view of a scene, and the times of its edits."""

    def __init__(self, size: tuple[int, int]) -> None:
        self.native, self.size, self.is_denoised = part("native").engine(), size, False
        self.sync, self.session = (
            part("viewport.sync").SceneSync(self.native),
            part("viewport.session").Session(self.native),
        )
        self.origin = None
        self.updated, self.ended = 0.0, 0.0
        bpy.app.handlers.depsgraph_update_post.append(self._evaluated)

    def _evaluated(self, _scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
        """Sends what Blender has evaluated: only now does it name the changes."""
        began = time.perf_counter()
        if self.origin is None:
            self.origin = tuple(depsgraph.scene_eval.camera.matrix_world.translation)
        draft = self.sync.update(depsgraph, part("export.kept").Changes.of(depsgraph), None, self.origin)
        if draft is not None:
            self.session.build(draft)
        self.ended = time.perf_counter()
        self.updated = self.ended - began

    def look(self) -> None:
        depsgraph = bpy.context.evaluated_depsgraph_get()
        camera = part("render.staging").camera(depsgraph.scene_eval, *self.size, part("export.report").Report())
        settings = part("export.settings").describe(bpy.context.scene, *self.size)
        settings = dataclasses.replace(settings, samples=1, noise_threshold=0.0, blue_noise=False)
        how = part("export.denoising").of_view(bpy.context.scene) if self.is_denoised else None
        self.session.look(part("viewport.session").Wanted(camera, settings, denoising=how))

    def edit(self, change) -> tuple[float, ...]:
        """Seconds to send it, to the first picture of it, and to one sample of every pixel, without and with denoising, then to the first
        denoised picture; Blender's own evaluation is not counted."""
        noisy, denoised = [self._edited(change, is_denoised) for is_denoised in (False, True)]
        return *noisy[:3], denoised[1], denoised[3], denoised[2]

    def _edited(self, change, is_denoised: bool) -> tuple[float, float, float, float]:
        """Seconds to send it, to the first picture, to the last one, and to the first denoised one."""
        self.is_denoised = is_denoised
        before, self.updated = self.session.picture, 0.0
        change()
        bpy.context.view_layer.update()
        # Since it began to be sent.
        began = self.ended - self.updated if self.updated else time.perf_counter()
        self.look()
        while self.session.picture is before:
            time.sleep(0.001)
            if time.perf_counter() - began > 20.0:
                raise SystemExit(f"viewport-price: an edit changes nothing: {self.session.error}")
        first = time.perf_counter() - began
        clean = None
        while self.session.is_busy:
            if clean is None and self.session.picture is not before and self.session.picture.is_denoised:
                clean = time.perf_counter() - began
            time.sleep(0.001)
            if time.perf_counter() - began > 120.0:
                raise SystemExit("viewport-price: no end")
        return self.updated, first, time.perf_counter() - began, clean or time.perf_counter() - began


def edits(scene: bpy.types.Scene) -> dict:
    """The edits, by name."""
    camera, own = scene.camera, scene.camera.data.petzval
    meshes = [one for one in scene.objects if one.type == "MESH" and one.data.users == 1 and one.visible_get()]
    chosen = max(meshes, key=lambda one: len(one.data.polygons))
    paint = next(
        node.inputs["Roughness"]
        for one in meshes
        for slot in one.material_slots
        if slot.material and slot.material.node_tree
        for node in slot.material.node_tree.nodes
        if node.type == "BSDF_PRINCIPLED" and node.outputs[0].is_linked and not node.inputs["Roughness"].is_linked
    )
    lamp = next(one for one in scene.objects if one.type == "LIGHT")
    steps = {"i": 0}

    def step() -> int:
        steps["i"] += 1
        return steps["i"]

    def move(one, by):
        one.location.x += by * (-1) ** step()

    def lens():
        own.wide_open, own.f_number = False, 4.0 + step() % 5

    def focus():
        own.focus_mode, camera.data.dof.focus_object = "CAMERA", None
        camera.data.dof.focus_distance = 2.0 + 0.1 * (step() % 5)

    def material():
        paint.default_value = 0.31 + 0.1 * (step() % 5)

    def shape():
        chosen.data.vertices[0].co.z += 1e-3 * (-1) ** step()
        chosen.data.update()

    return {
        "camera moved": lambda: move(camera, 0.02),
        "f-number": lens,
        "focus": focus,
        "material": material,
        "lamp moved": lambda: move(lamp, 0.05),
        "object moved": lambda: move(chosen, 0.01),
        f"vertex moved, of {len(chosen.data.vertices)}": shape,
    }


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--scene", default=str(ROOT / "tests/scenes/demo.blend"))
    parser.add_argument("--divide", type=int, default=4)
    parser.add_argument("--repeats", type=int, default=REPEATS, help="of each edit")
    arguments = parser.parse_args()
    began, origin = time.monotonic(), pages.made(str(PAGE.relative_to(ROOT)))
    bpy.ops.wm.open_mainfile(filepath=arguments.scene)
    scene = bpy.context.scene
    size = (scene.render.resolution_x // arguments.divide, scene.render.resolution_y // arguments.divide)
    scene.cycles.use_preview_denoising = True
    clock = Clock(size)
    rows = {"first look": [clock.edit(lambda: scene.update_tag())]}
    for name, change in edits(scene).items():
        print(f"{name} ...", file=sys.stderr, flush=True)
        clock.edit(change)
        rows[name] = [clock.edit(change) for _ in range(arguments.repeats)]
    lines = [
        f"Of `{Path(arguments.scene).name}`, {clock.session._scene.triangle_count} triangles, {size[0]} x {size[1]} pixels, "
        f"{os.cpu_count()} cores; ms, medians of {arguments.repeats}; by the engine of `make {pages.build()}`.",
        "",
        "| edit | sent | first picture | all pixels | denoised: first picture | first denoised | all pixels |",
        "|---|---:|---:|---:|---:|---:|---:|",
    ]
    for name, times in rows.items():
        medians = [1e3 * statistics.median(column) for column in zip(*times, strict=True)]
        lines.append(f"| {name} | " + " | ".join(f"{one:.0f}" for one in medians) + " |")
    table = "\n".join(lines)
    print(table)
    text = PAGE.read_text(encoding="utf-8")
    head, _, rest = text.partition(BEGIN)
    text = head + BEGIN + "\n\n" + table + "\n\n" + END + rest.partition(END)[2]
    PAGE.write_text(pages.stamped(text, origin.took(time.monotonic() - began)), encoding="utf-8")
    clock.session.close()
    sys.stdout.flush()
    # bpy with an engine registered does not end by itself.
    os._exit(0)


if __name__ == "__main__":
    main()
