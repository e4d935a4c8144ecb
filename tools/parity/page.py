# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/parity.md and its pictures."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pages
from PIL import Image

from .compare import shown

#: The chapters in the order of the scenes; others are called by their module.
CHAPTERS = {
    "surfaces": "Surfaces",
    "textures": "Textures and colours",
    "coordinates": "What nodes know of the place",
    "lamps": "Lamps",
    "worlds": "Worlds",
    "volumes": "Volumes",
    "shapes": "Shapes",
    "hair": "Hair and curves",
    "points": "Points",
    "views": "Cameras",
    "motion": "Motion blur",
    "frames": "Frames of animations",
    "passes": "Holes, caught shadows and view layers",
    "light_passes": "Passes of light",
    "data_passes": "Passes of data",
}
#: Blocks that differ by less than that are alike.
ALIKE = 0.01


def write(
    docs: Path,
    work: Path,
    scenes: dict,
    results: dict,
    limits: dict,
    size: tuple[int, int],
    samples: int,
    most: int,
    now: pages.Made,
) -> None:
    """The page, from the findings. `limits`: of `parity.limits`; `now`: the origin of scenes that were rendered just now."""
    pictures = docs / "images" / "parity"
    pictures.mkdir(parents=True, exist_ok=True)
    for old in pictures.glob("*.jpg"):
        if old.stem not in scenes and old.stem not in limits:
            old.unlink()
    lines = [
        "# Petzval beside Cycles",
        "",
        "The scenes of `tests/scenes/parity_scenes`, one feature each, made by script and rendered by both engines inside of",
        _taken(results, size, samples, most),
        "From the left: Petzval, Cycles, and where the eye would see a difference (FLIP, from black over purple to",
        "yellow); of passes and of an animation's frames two to a row, in the order of their names.",
        "",
        "- **FLIP**: the mean difference to the eye (Andersson et al. 2021, for high dynamic range), 0 to 1. *Of halves*: between two",
        "  Cycles pictures of half the samples and different seeds; noise alone gives that much.",
        "- **Worst block**: means of 4 x 3 blocks of the picture, by channel, ours over Cycles'; of all passes or frames the worst.",
        "  A block of a pass is compared with the pass's mean where it has less than that. *Noise*: what the seeds of both programs",
        "  differ by, in the worst block.",
        "- **Mean**: of the whole picture; the worst of all passes or frames.",
        "",
    ]
    lines += _summary(scenes, results)
    for chapter in dict.fromkeys(one["chapter"] for one in scenes.values()):
        names = [name for name, one in scenes.items() if one["chapter"] == chapter and name in results]
        title = CHAPTERS.get(chapter, chapter.replace("_", " ").capitalize())
        lines += [f"## {title}", "", "| scene | Petzval, Cycles, difference | FLIP | of halves | worst block | noise | mean |", "|---|---|---:|---:|---:|---:|---:|"]  # fmt: skip
        lines += [_row(scenes[name], name, results[name], work, pictures) for name in names]
        lines.append("")
    lines += _limits(limits, work / "limits", pictures)
    origin = _oldest({**results, **limits}, now)
    (docs / "parity.md").write_text(pages.stamped("\n".join(lines).rstrip() + "\n", origin))


def _limits(limits: dict, work: Path, pictures: Path) -> list[str]:
    """The chapter of scenes in which Cycles is not exact."""
    lines = [
        "## Where Cycles is not exact",
        "",
        "Scenes of `tests/scenes/cycles_limits.py`, each rendered several ways. One way of each is the truth: by the law of refraction, by the same",
        "shape made otherwise, or by Cycles with the approximation switched off. Petzval does not imitate the approximation.",
        "`make other-scenes` switches shadow caustics off.",
        "",
    ]
    for name, found in limits.items():
        with np.load(work / f"{name}.npz") as kept:
            strip = _side_by_side([kept[key] for key in kept.files])
        strip.save(pictures / f"{name}.jpg", quality=86, optimize=True)
        lines += [f"### {found['title']}", "", found["evidence"], "", f"![{name}](images/parity/{name}.jpg)", ""]
        lines += ["| from the left | mean of the picture | over the truth |", "|---|---:|---:|"]
        for label, mean, is_truth in found["ways"]:
            over = "the truth" if is_truth else f"{mean / found['truth']:.3f}" if found["truth"] else "–"
            lines.append(f"| {label} | {mean:.4g} | {over} |")
        lines.append("")
    return lines


def _side_by_side(looks: list[np.ndarray]) -> Image.Image:
    """Pictures of one scene at one exposure, twice as large: the 99th percentile of the brightest is white."""
    white = max(float(np.percentile(look, 99.0)) for look in looks) or 1.0
    gap = np.ones((looks[0].shape[0], 2, 3))
    parts = [part for look in looks for part in (look / white, gap)][:-1]
    strip = Image.fromarray(shown(np.concatenate(parts, 1)))
    return strip.resize((2 * strip.width, 2 * strip.height), Image.Resampling.NEAREST)


def _oldest(results: dict, now: pages.Made) -> pages.Made:
    """The origin of the page: that of its oldest scene, for scenes that were rendered before are not rendered again."""
    before = [pages.Made(*one["made"]) for one in results.values() if tuple(one["made"]) != now._replace(time="")]
    return min(before, key=lambda one: one.date, default=now)


def _taken(results: dict, size: tuple[int, int], samples: int, most: int) -> str:
    """The settings of the pictures in words, after "inside of"."""
    version = next((one["blender"] for one in results.values() if "blender" in one), "?")
    return (
        f"Blender {version}: a pinhole, {size[0]} x {size[1]} pixels, {samples} samples and up to {most} where blocks are noisy or\n"
        "apart, 16 bounces, nothing clamped or denoised."
    )


def _summary(scenes: dict, results: dict) -> list[str]:
    good = {name: one for name, one in results.items() if "flip" in one}
    within = sum(one["worst_block"] < ALIKE for one in good.values())
    near = sum(one["flip"] < 1.25 * one["flip_of_halves"] for one in good.values())
    minutes = {whose: sum(one[f"{whose}_s"] for one in good.values()) / 60 for whose in ("petzval", "cycles")}
    lines = [
        f"Of {len(results)} scenes {within} agree within 1 % in each of 12 blocks and each channel, noise included; in {near} the",
        "difference to the eye is less than 1.25 times that of noise alone. All took",
        f"{minutes['petzval']:.0f} minutes of processor time in Petzval and {minutes['cycles']:.0f} in Cycles, scenes made ready included.",
        "",
    ]
    apart = {name: one for name, one in good.items() if one["worst_block"] >= ALIKE}
    if apart:
        lines += ["More than 1 % apart in some block:", ""]
    for name, one in apart.items():
        why = scenes[name]["why"] or "noise"
        lines.append(
            f"- {scenes[name]['title']}: {_percent(one['worst_block'])}, noise {_percent(one['noise'])}; {why}"
        )
    return [*lines, ""] if apart else lines


def _row(scene: dict, name: str, found: dict, work: Path, pictures: Path) -> str:
    if "flip" not in found:
        return f"| {scene['title']} | {found.get('failed', 'black')} | | | | | |"
    Image.open(work / name / "strip.png").convert("RGB").save(pictures / f"{name}.jpg", quality=86, optimize=True)
    title = scene["title"] + (f". *{scene['why'][0].upper()}{scene['why'][1:]}.*" if scene["why"] else "")
    worst = _percent(found["worst_block"])
    if len(found["looks"]) > 1:
        title += f". {', '.join(found['looks'])}"
        worst += f" ({found['worst_look']})"
    numbers = (
        f"{found['flip']:.4f} | {found['flip_of_halves']:.4f} | {worst} | {_percent(found['noise'])} "
        f"| {_percent(found['mean'], '+')}"
    )
    return f"| {title} | ![{name}](images/parity/{name}.jpg) | {numbers} |"


def _percent(share: float, sign: str = "") -> str:
    return f"{100 * share:{sign}.1f} %"


def write_others(docs: Path, others: dict, size: tuple[int, int], samples: int, most: int) -> None:
    """The page of scenes that are not part of the project."""
    lines = [
        "# Scenes by other people, beside Cycles",
        "",
        "Not part of the project; what Petzval says that it does not show. As [the small scenes](parity.md), inside of",
        _taken(others, size, samples, most),
        'Written by `make parity PARITY_OPTIONS="--scenes FOLDER"`.',
        "",
        "| scene | FLIP | of halves | worst block | noise | mean | says |",
        "|---|---:|---:|---:|---:|---:|---|",
    ]
    for name, found in others.items():
        if "flip" in found:
            numbers = (
                f"{found['flip']:.4f} | {found['flip_of_halves']:.4f} | {_percent(found['worst_block'])} "
                f"| {_percent(found['noise'])} | {_percent(found['mean'], '+')}"
            )
        else:
            numbers = f"{found.get('skipped') or found.get('failed') or 'black in Cycles'} | | | |"
        said = _said(found.get("warnings", []))
        lines.append(f"| {name} | {numbers} | {said} |")
    (docs / "parity-others.md").write_text("\n".join(lines) + "\n")


def _said(warnings: list[str]) -> str:
    """The first few messages, without the paths of this machine."""
    # A path in brackets after a name; a drive's letter, or a slash.
    lines = [re.sub(r" \([^()]*[/\\\\][^()]*\)", "", line).replace("|", "/") for line in warnings]
    more = f"; and {len(lines) - 4} more" if len(lines) > 4 else ""
    return "; ".join(lines[:4]) + more
