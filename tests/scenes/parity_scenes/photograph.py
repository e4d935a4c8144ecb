# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene that is open, photographed by Petzval and by Cycles through the same pinhole, with nothing that trades truth
for speed: no clamping, no filtered gloss, no denoising, no adaptive sampling."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np

from support import beside_cycles, render_passes, scenes

BOUNCES = 16


def prepare(width: int, height: int, samples: int, bounces: int = BOUNCES) -> None:
    """Sets both programs to the same, and the camera to a pinhole."""
    scene = bpy.context.scene
    render = scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
    render.use_compositing = render.use_sequencer = render.use_border = False
    scenes.exr(scene)
    scene.camera.data.petzval.model = "PINHOLE"
    beside_cycles.without_tricks(samples)
    own, cycles = scene.petzval, scene.cycles
    own.seed = cycles.seed = 0
    own.max_bounces = cycles.max_bounces = bounces
    for kind in ("diffuse", "glossy", "transmission"):
        setattr(cycles, f"{kind}_bounces", bounces)
    cycles.transparent_max_bounces = 64
    cycles.caustics_reflective = cycles.caustics_refractive = True


def take(engine: str, folder: Path) -> np.ndarray:
    """The picture of `PETZVAL` or `CYCLES`: linear, (height, width, 4), first row at the bottom."""
    bpy.context.scene.render.engine = engine
    return scenes.render(folder, f"{engine.lower()}.exr")


def looks(
    engine: str, folder: Path, passes: tuple[str, ...] = (), frames: tuple[int, ...] = ()
) -> dict[str, np.ndarray]:
    """What there is to compare of the scene that is open, by name: its picture, or these passes, or these frames. Each
    (height, width, channels), first row at the bottom."""
    if frames:
        return _animation(engine, folder, frames)
    if passes:
        found = render_passes.photograph(folder / f"{engine.lower()}.exr", engine, samples=None)
        return {name: _of_pass(found, name) for name in passes}
    return {"picture": take(engine, folder)[..., :3]}


def _animation(engine: str, folder: Path, frames: tuple[int, ...]) -> dict[str, np.ndarray]:
    """By Petzval as an animation, one after the other; by Cycles each for itself."""
    scene = bpy.context.scene
    if engine == "CYCLES":
        found = {}
        for frame in frames:
            scene.frame_set(frame)
            found[f"frame {frame}"] = take(engine, folder)[..., :3]
        return found
    scene.render.engine = engine
    steps = {after - before for before, after in zip(frames, frames[1:], strict=False)}
    assert len(steps) == 1, "frames at even steps"
    scene.frame_start, scene.frame_end, scene.frame_step = frames[0], frames[-1], steps.pop()
    scene.render.filepath = str(folder / "petzval-####.exr")
    bpy.ops.render.render(animation=True)
    return {f"frame {frame}": scenes.read(folder / f"petzval-{frame:04}.exr")[..., :3] for frame in frames}


def _of_pass(found: dict[str, np.ndarray], name: str) -> np.ndarray:
    if name.startswith("Crypto"):
        return _matte(found, name)
    pixels = render_passes.lit_by(found, name)
    return np.repeat(pixels, 3, axis=2) if pixels.shape[2] == 1 else pixels


def _matte(found: dict[str, np.ndarray], layer: str) -> np.ndarray:
    """Each name's coverage in a colour that its number says."""
    picture = 0.0
    for one in (name for name in found if name.startswith(layer)):
        for number, coverage in ((0, 1), (2, 3)):
            ids = np.ascontiguousarray(found[one][..., number]).view(np.uint32)
            colour = np.stack([(ids >> shift & 255) / 255.0 for shift in (0, 8, 16)], -1)
            picture = picture + colour * found[one][..., coverage, None]
    return picture
