# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/parity.md and its pictures."""

from __future__ import annotations

import re
from pathlib import Path

from PIL import Image

CHAPTERS = {
    "surfaces": "Surfaces",
    "textures": "Textures and colours",
    "coordinates": "What nodes know of the place",
    "lamps": "Lamps",
    "worlds": "Worlds",
    "shapes": "Shapes",
    "views": "Cameras",
    "motion": "Motion",
    "passes": "Holes, caught shadows and view layers",
}


def write(docs: Path, work: Path, scenes: dict, results: dict, others: dict, size: tuple[int, int], samples: int):
    """The page, from what was found."""
    pictures = docs / "images" / "parity"
    pictures.mkdir(parents=True, exist_ok=True)
    for old in pictures.glob("*.jpg"):
        if old.stem not in scenes:
            old.unlink()
    version = next((one["blender"] for one in results.values() if "blender" in one), "?")
    lines = [
        "# Petzval beside Cycles",
        "",
        "The scenes of `tests/scenes/parity_scenes`, one feature each, made by script and rendered by both engines inside of",
        f"Blender {version}: a pinhole, {size[0]} x {size[1]} pixels, {samples} samples, 16 bounces, nothing clamped or denoised. Written by",
        "`make parity`. From the left: Petzval, Cycles, and where the eye would see a difference (FLIP, from black over purple to",
        "yellow).",
        "",
        "- **FLIP**: the mean difference to the eye (Andersson et al. 2021, for high dynamic range), 0 to 1. *Of halves*: between two",
        "  Cycles pictures of half the samples and different seeds; noise alone gives that much.",
        "- **Worst block**: means of 4 x 3 blocks of the picture, by channel, ours over Cycles'. The tests allow 1 %, and noise.",
        "- **Mean**: of the whole picture.",
        "",
    ]
    lines += _summary(results)
    for chapter, title in CHAPTERS.items():
        names = [name for name, one in scenes.items() if one["chapter"] == chapter and name in results]
        if not names:
            continue
        lines += [f"## {title}", "", "| scene | Petzval, Cycles, difference | FLIP | of halves | worst block | mean |", "|---|---|---:|---:|---:|---:|"]  # fmt: skip
        lines += [_row(scenes[name], name, results[name], work, pictures) for name in names]
        lines.append("")
    if others:
        lines += _others(others)
    (docs / "parity.md").write_text("\n".join(lines).rstrip() + "\n")


def _summary(results: dict) -> list[str]:
    good = [one for one in results.values() if "flip" in one]
    within = sum(one["worst_block"] < 0.01 for one in good)
    near = sum(one["flip"] < 1.25 * one["flip_of_halves"] for one in good)
    return [
        f"Of {len(results)} scenes {within} agree within 1 % in each of 12 blocks and each channel, noise included;",
        f"in {near} the difference to the eye is less than 1.25 times that of noise alone.",
        "",
    ]


def _row(scene: dict, name: str, found: dict, work: Path, pictures: Path) -> str:
    if "flip" not in found:
        return f"| {scene['title']} | {found.get('failed', 'black')} | | | | |"
    Image.open(work / name / "strip.png").convert("RGB").save(pictures / f"{name}.jpg", quality=88, optimize=True)
    title = scene["title"] + (f". *{scene['why'][0].upper()}{scene['why'][1:]}.*" if scene["why"] else "")
    numbers = f"{found['flip']:.4f} | {found['flip_of_halves']:.4f} | {_percent(found['worst_block'])} | {_percent(found['mean'], '+')}"
    return f"| {title} | ![{name}](images/parity/{name}.jpg) | {numbers} |"


def _percent(share: float, sign: str = "") -> str:
    return f"{100 * share:{sign}.1f} %"


def _others(others: dict) -> list[str]:
    lines = [
        "## Scenes by other people",
        "",
        "Not part of the project; what Petzval says that it does not show.",
        "",
        "| scene | FLIP | of halves | worst block | mean | says |",
        "|---|---:|---:|---:|---:|---|",
    ]
    for name, found in others.items():
        if "flip" in found:
            numbers = f"{found['flip']:.4f} | {found['flip_of_halves']:.4f} | {_percent(found['worst_block'])} | {_percent(found['mean'], '+')}"
        else:
            numbers = f"{found.get('skipped') or found.get('failed') or 'black in Cycles'} | | |"
        said = _said(found.get("warnings", []))
        lines.append(f"| {name} | {numbers} | {said} |")
    return lines + [""]


def _said(warnings: list[str]) -> str:
    """The first few, without the paths of this machine."""
    # A path in brackets after a name; a drive's letter, or a slash.
    lines = [re.sub(r" \([^()]*[/\\\\][^()]*\)", "", line).replace("|", "/") for line in warnings]
    more = f"; and {len(lines) - 4} more" if len(lines) > 4 else ""
    return "; ".join(lines[:4]) + more
