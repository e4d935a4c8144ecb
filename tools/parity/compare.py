# SPDX-License-Identifier: GPL-3.0-or-later
"""The difference of two pictures: by means of blocks, and to the eye (FLIP, Andersson et al. 2020 and 2021)."""

from __future__ import annotations

from pathlib import Path

import flip_evaluator
import numpy as np
from PIL import Image

from .blocks import PASS, block_ratios, floor_of

#: Passes that hold no light. They are shown from black to white over their own range.
DATA = (
    "Depth",
    "Position",
    "Normal",
    "UV",
    "Vector",
    "Denoising Depth",
    "Denoising Normal",
    "Object Index",
    "Material Index",
)
#: Pixels between two columns of several pictures in one.
GAP = 6


def compare(folder: Path) -> dict:
    """The comparison of the pictures that `job` left in a folder. Means are over all of them, the worst block is the worst of all."""
    kept = np.load(folder / "looks.npz")
    names = [name.partition("/")[2] for name in kept.files if name.startswith("petzval/")]
    strips, flips, noises, blocks, means, finite = [], [], [], {}, [], True
    for name in names:
        ours = kept[f"petzval/{name}"]
        halves = [kept[f"cycles-{half}/{name}"] for half in range(2)]
        theirs = 0.5 * (halves[0] + halves[1])
        finite &= bool(np.isfinite(ours).all())
        if not theirs.any():
            return {"black": True, "finite": finite, "ours": float(ours.mean())}
        error, flip = _flip(*_for_the_eye(name, theirs, theirs, ours))
        _, noise = _flip(*_for_the_eye(name, theirs, *halves))
        blocks[name] = float(np.abs(block_ratios(ours, theirs, floor_of(name)) - 1.0).max())
        # Where signs differ a ratio of means would say nothing.
        means.append(float((ours.mean() - theirs.mean()) / np.abs(theirs).mean()))
        flips.append(flip)
        noises.append(noise)
        strips.append(np.concatenate([*map(shown, _for_the_eye(name, theirs, ours, theirs)), error], 1))
    _arranged(strips).save(folder / "strip.png")
    worst = max(blocks, key=blocks.get)
    return {
        "looks": names,
        "flip": float(np.mean(flips)),
        "flip_of_halves": float(np.mean(noises)),
        "worst_block": blocks[worst],
        "worst_look": worst,
        "mean": max(means, key=abs),
        "finite": finite,
    }


def _for_the_eye(name: str, whole: np.ndarray, *pictures: np.ndarray) -> list[np.ndarray]:
    """The pictures as light: data from 0 to 1 over their range in `whole`."""
    pictures = [np.pad(one[..., :3], [(0, 0), (0, 0), (0, 3 - min(one.shape[2], 3))]) for one in pictures]
    if floor_of(name) == PASS and name in DATA:
        low, high = float(whole.min()), float(whole.max())
        pictures = [(one - low) / max(high - low, 1e-12) for one in pictures]
    return pictures


def _arranged(strips: list[np.ndarray]) -> Image.Image:
    """The strips as one picture: one strip, or two columns of smaller ones."""
    if len(strips) == 1:
        return Image.fromarray(strips[0])
    height, width = (side // 2 for side in strips[0].shape[:2])
    whole = Image.new("RGB", (2 * width + GAP, -(-len(strips) // 2) * height), "white")
    for number, strip in enumerate(strips):
        small = Image.fromarray(strip).resize((width, height), Image.Resampling.BOX)
        whole.paste(small, (number % 2 * (width + GAP), number // 2 * height))
    return whole


def _flip(reference: np.ndarray, test: np.ndarray) -> tuple[np.ndarray, float]:
    """The map of differences as colours, first row on top, and its mean."""
    pictures = [np.ascontiguousarray(np.maximum(one[::-1], 0.0), np.float32) for one in (reference, test)]
    error, mean, _ = flip_evaluator.evaluate(*pictures, "HDR")
    return (np.clip(np.asarray(error), 0, 1) * 255).astype(np.uint8), float(mean)


def shown(linear: np.ndarray) -> np.ndarray:
    """The picture in sRGB, first row on top."""
    linear = np.clip(linear[::-1], 0.0, 1.0)
    encoded = np.where(linear < 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return (encoded * 255 + 0.5).astype(np.uint8)
