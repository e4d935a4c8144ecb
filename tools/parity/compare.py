# SPDX-License-Identifier: GPL-3.0-or-later
"""How far apart two pictures are: by means of blocks, and to the eye (FLIP, Andersson et al. 2020 and 2021)."""

from __future__ import annotations

from pathlib import Path

import flip_evaluator
import numpy as np
from PIL import Image

from .blocks import block_ratios


def compare(folder: Path) -> dict:
    """Of the pictures that `job` left in a folder."""
    ours = np.load(folder / "petzval.npy")[..., :3]
    halves = [np.load(folder / f"cycles-{half}.npy")[..., :3] for half in range(2)]
    theirs = 0.5 * (halves[0] + halves[1])
    if not theirs.any():
        return {"black": True, "finite": bool(np.isfinite(ours).all()), "ours": float(ours.mean())}
    error, flip = _flip(theirs, ours)
    _, noise = _flip(halves[0], halves[1])
    apart = np.abs(block_ratios(ours, theirs) - 1.0)
    Image.fromarray(np.concatenate([_shown(ours), _shown(theirs), error], 1)).save(folder / "strip.png")
    return {
        "flip": flip,
        "flip_of_halves": noise,
        "worst_block": float(apart.max()),
        "mean": float(ours.mean() / theirs.mean() - 1.0),
        "finite": bool(np.isfinite(ours).all()),
    }


def _flip(reference: np.ndarray, test: np.ndarray) -> tuple[np.ndarray, float]:
    """The map of differences as colours, first row on top, and its mean."""
    pictures = [np.ascontiguousarray(np.maximum(one[::-1], 0.0), np.float32) for one in (reference, test)]
    error, mean, _ = flip_evaluator.evaluate(*pictures, "HDR")
    return (np.clip(np.asarray(error), 0, 1) * 255).astype(np.uint8), float(mean)


def _shown(linear: np.ndarray) -> np.ndarray:
    """In sRGB, first row on top."""
    linear = np.clip(linear[::-1], 0.0, 1.0)
    encoded = np.where(linear < 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return (encoded * 255 + 0.5).astype(np.uint8)
