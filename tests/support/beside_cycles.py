# SPDX-License-Identifier: GPL-3.0-or-later
"""The open scene by Petzval and by Cycles in the same Blender, and how far apart the two pictures are. Imported inside of
tests: it needs bpy."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import bpy
import numpy as np

from support import kept_references, scenes

#: Columns of the table by which Cycles chooses directions of a sky. It computes one of its own choice for more than a second
#: before each render; what is seen does not depend on it.
SKY_TABLE = 256

#: Few samples tell most pictures that agree: looks are taken with these parts of them, Petzval's and Cycles's, and where both are not
#: within this share of the limits, more are added. Cycles has fewer looks, as it builds the scene anew for each. What is truly beyond
#: a limit passes an early look less often than the last: what is off by x more than the limit must be thought x + 1 - share nearer
#: than it is, by the noise of both, which is 2.8, 1.7 or 1.4 times the last one's; that is the rarer chance up to an x of 0.18, 0.45
#: and 0.48 of the limit, and beyond none has a chance that matters.
LOOKS = ((1 / 8, 1 / 8, 2 / 3), (1 / 4, 1 / 2, 2 / 3), (1 / 2, 1 / 2, 0.8), (1, 1, 1.0))


def without_tricks(samples: int) -> None:
    """Sets both programs to the same, with nothing that trades truth for speed: no clamping, no filtered gloss, no
    denoising, no adaptive sampling."""
    scene = bpy.context.scene
    own, cycles = scene.petzval, scene.cycles
    own.samples = cycles.samples = samples
    own.clamp_indirect, own.noise_threshold = 0.0, 0.0
    own.property_unset("filter_width")
    cycles.device = "CPU"
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    cycles.pixel_filter_type = "BOX"
    scene.camera.data.dof.use_dof = False


def small_sky_table() -> None:
    """Where Cycles would choose the size of its table itself."""
    world = bpy.context.scene.world
    if world is not None and world.cycles.sampling_method == "AUTOMATIC":
        world.cycles.sampling_method, world.cycles.sample_map_resolution = "MANUAL", SKY_TABLE


#: A picture, or several by their names.
Pictures = np.ndarray | dict[str, np.ndarray]


def _joined(first: Pictures, first_samples: int, second: Pictures, second_samples: int) -> Pictures:
    """The mean of all their samples."""
    if isinstance(first, dict):
        return {name: _joined(one, first_samples, second[name], second_samples) for name, one in first.items()}
    return (first_samples * first + second_samples * second) / (first_samples + second_samples)


def looks(
    samples: int,
    take: Callable[[str], Pictures],
    *,
    theirs_at_once: bool = False,
    blocks: tuple[int, int] | None = None,
    chapter: Path | None = None,
) -> Iterator[tuple[int, float, Pictures, Pictures]]:
    """By the `LOOKS`: Petzval's samples so far, the share of the limits, Petzval's picture and Cycles's. `take` renders with the
    engine of that name, a picture or several by their names. What has been rendered is not rendered again: samples are added to
    it, the next ones of the same sequence. `theirs_at_once`: Cycles takes all samples for the first look. `blocks`: so many rows and
    columns of blocks, of whose means alone Cycles's pictures are right; these may be stored, by the sources of the scene's `chapter`."""
    own, cycles = bpy.context.scene.petzval, bpy.context.scene.cycles
    done, pictures = {"PETZVAL": 0, "CYCLES": 0}, {}

    def add(engine: str, part: float) -> None:
        first = done[engine]
        more = max(round(part * samples), 1) - first
        if not more:
            return
        if engine == "PETZVAL":
            # Neighbours that share a sequence would share another one in each part.
            own.samples, own.sample_offset, own.use_blue_noise = more, first, False
        elif hasattr(cycles, "use_sample_subset"):
            cycles.samples, cycles.use_sample_subset = samples, True
            cycles.sample_offset, cycles.sample_subset_length = first, more
        else:
            cycles.samples, cycles.sample_offset = more, first
        taken = (
            take(engine)
            if engine == "PETZVAL" or blocks is None
            else theirs_in_blocks(take, blocks, first, more, chapter)
        )
        pictures[engine] = _joined(pictures[engine], first, taken, more) if first else taken
        done[engine] += more

    for ours, theirs, share in LOOKS:
        before = dict(done)
        add("PETZVAL", ours)
        add("CYCLES", 1 if theirs_at_once else theirs)
        if done == before:
            continue
        own.samples, own.sample_offset = done["PETZVAL"], 0
        yield done["PETZVAL"], share, pictures["PETZVAL"], pictures["CYCLES"]


def theirs_in_blocks(
    take: Callable[[str], Pictures], blocks: tuple[int, int], first: int, more: int, chapter: Path | None
) -> Pictures:
    """Cycles' pictures of samples from the `first` on, or stored ones with the same means of blocks."""
    from support import stored_blocks

    key, again = kept_references.digest(blocks, first, more, chapter=chapter), os.environ.get("PETZVAL_CYCLES_AGAIN")
    found = None if again else stored_blocks.find(key)
    if found is not None:
        return found
    taken = take("CYCLES")
    if again:
        stored_blocks.check(key, taken, blocks)
    if os.environ.get("PETZVAL_STORE_BLOCKS"):
        stored_blocks.store(key, taken, blocks)
    return taken


def both(folder: Path, samples: int, bounces: int | None = None, **cycles_settings) -> tuple[np.ndarray, np.ndarray]:
    """Petzval's picture and Cycles's, (height, width, 3). `bounces` of every kind, else as the scene has them."""
    prepare(samples, bounces, **cycles_settings)
    return take(folder, "PETZVAL"), take(folder, "CYCLES")


def prepare(samples: int, bounces: int | None = None, **cycles_settings) -> None:
    """Sets both programs to the same."""
    without_tricks(samples)
    small_sky_table()
    scene = bpy.context.scene
    if bounces is not None:
        scene.petzval.max_bounces = bounces
        for kind in ("max", "diffuse", "glossy", "transmission", "transparent_max"):
            setattr(scene.cycles, f"{kind}_bounces", bounces)
    for name, value in cycles_settings.items():
        setattr(scene.cycles, name, value)


def take(folder: Path, engine: str, warns: str = "") -> np.ndarray:
    """The picture of `PETZVAL`, which warns of nothing, or once of what `warns` names, or of `CYCLES`: (height, width, 3)."""
    scene = bpy.context.scene
    scene.render.engine = engine
    try:
        picture = scenes.render(folder, f"{engine.lower()}.exr")[..., :3]
    finally:
        scene.render.engine = "PETZVAL"
    if engine == "PETZVAL":
        warnings = scenes.part("render.statistics").last(scene.name).warnings
        assert len(warnings) == bool(warns) and all(warns in warning for warning in warnings), warnings
    return picture


def apart(ours: np.ndarray, theirs: np.ndarray, side: int, floor: float = 0.1) -> tuple[float, float]:
    """How far apart pictures are in the mean of a channel, and at most in that of a block of `side` pixels. Blocks are compared
    with themselves and a part of the mean, lest the noise of dark ones count."""
    height, width = ours.shape[:2]
    blocks = [p.reshape(height // side, side, width // side, side, 3).mean((1, 3)) for p in (ours, theirs)]
    off = np.abs(blocks[0] - blocks[1]) / (blocks[1] + floor * blocks[1].mean())
    means = np.abs(ours.mean((0, 1)) - theirs.mean((0, 1))) / np.maximum(theirs.mean((0, 1)), 1e-12)
    return float(means.max()), float(off.max())


def alike(
    folder: Path, samples: int, *, side: int, mean: float, block: float, floor: float = 0.1, warns: str = "", **more
) -> np.ndarray:
    """Asserts that both show the same within limits of `apart`; gives Petzval's picture. `warns`: see `take`; `more` is for
    `prepare`."""
    prepare(samples, **more)
    render = bpy.context.scene.render
    blocks = render.resolution_y // side, render.resolution_x // side
    for done, share, ours, theirs in looks(samples, lambda engine: take(folder, engine, warns), blocks=blocks):
        assert theirs.mean() > 1e-4, "the scene is dark in Cycles"
        found = apart(ours, theirs, side, floor)
        print(f"{done} samples: mean {found[0]:.4f} (of {mean}), block {found[1]:.4f} (of {block})")
        if found[0] < share * mean and found[1] < share * block:
            return ours
    raise AssertionError(f"mean {found[0]:.4f} (within {mean}?), worst block {found[1]:.4f} (within {block}?)")
