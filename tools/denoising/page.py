# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/denoising.md, and a line for each scene while it is measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from statistics import median
from typing import TYPE_CHECKING

import numpy as np
import pages
from PIL import Image

if TYPE_CHECKING:
    from .__main__ import Result

#: Quality and guides of a row of the first table.
ROWS = (
    ("off", "none"),
    ("fast", "none"),
    ("fast", "both"),
    ("balanced", "none"),
    ("balanced", "both"),
    ("high", "none"),
    ("high", "both"),
)
#: The picture of the demo, from docs/.
PICTURE = "images/denoising-demo.jpg"
#: Between pictures, pixels.
GAP = 6
#: The samples of Petzval and of Cycles that are compared.
OURS, THEIRS = 32, 64


def said(result: Result, samples: Sequence[int]) -> str:
    """A line."""
    if result.left_out:
        return f"{result.scene.name:32s} left out: {result.left_out}"
    words = []
    for program in ("petzval", "cycles"):
        for count in samples:
            pair = [result.errors.get((program, count, *how)) for how in (("off", "none"), ("high", "both"))]
            if all(pair):
                words.append(f"{program} {count}: {pair[0].flip:.4f} -> {pair[1].flip:.4f}")
    return f"{result.scene.name:32s} FLIP {', '.join(words)}"


def text(
    results: Sequence[Result],
    samples: Sequence[int],
    reference: int,
    height: int,
    shown: int,
    origins: Mapping[str, str],
) -> str:
    """The page without its footer."""
    found = [one for one in results if not one.left_out]
    ours = [one for one in found if not one.scene.is_by_others]
    others = [one for one in found if one.scene.is_by_others]
    lines = [
        "# Denoised pictures beside converged ones",
        "",
        f"Pictures of few samples, {height} pixels high, as Petzval makes them and denoised by Open Image Denoise, beside pictures of {reference}",
        "samples by the same program with another seed, not denoised. How to use it: [denoising](how-to/denoising.md); how it works:",
        "[design](design/denoising.md).",
        "",
        "- **FLIP**: the difference that an eye sees, 0 to 1, of the pictures as the scene's view shows them.",
        "- **relMSE**: the relative mean square error of radiance, without the worst thousandth of the pixels.",
        f"- **Seconds**: of a processor, for samples and denoising, without what is done once; by the engine of `make {pages.build()}`.",
        "- **Guides**: none, or albedo and normal, filtered before (Prefilter: Accurate).",
        "",
        f"![The demo without and with denoising, whole and two parts of it]({PICTURE})",
        "",
        f"The demo with {shown} samples, as `make demo` renders it but smaller: without denoising, and with High.",
        "",
    ]
    if ours:
        lines += ["## Through lenses", "", "The demo and scenes of the gallery. FLIP · relMSE.", ""]
        for one in ours:
            lines += [f"### {one.scene.name[0].upper()}{one.scene.name[1:]}", "", *_by_quality([one], samples), ""]
    if others:
        lines += [
            "## Scenes by others",
            "",
            f"{len(others)} scenes that nobody of this project made, through a pinhole, as [scenes by others](other-scenes.md) compares them. FLIP · relMSE",
            "in the middle of all, and seconds in the sum.",
            "",
            *_by_quality(others, samples),
            "",
            *_beside(others, samples),
            "",
        ]
        left_out = [one for one in results if one.left_out]
        if left_out:
            lines += ["Left out:", "", *(f"- {one.scene.name}: {one.left_out}" for one in left_out), ""]
        sources = [f"- {one.scene.name}: {origins[one.scene.name]}" for one in others if one.scene.name in origins]
        lines += ["### Where they are from", "", *sources, ""] if sources else []
    return "\n".join(lines).rstrip() + "\n"


def beside(pictures: Sequence[np.ndarray], parts: Sequence[tuple[float, float, float, float]]) -> Image.Image:
    """Pictures, values from 0 to 1, in columns; under each of them parts of it, as wide as it is: left, top, right, bottom."""
    columns = []
    for picture in pictures:
        whole = Image.fromarray(np.round(255.0 * np.clip(picture, 0.0, 1.0)).astype(np.uint8))
        width, height = whole.size
        cells = [whole]
        for left, top, right, bottom in parts:
            part = whole.crop((round(left * width), round(top * height), round(right * width), round(bottom * height)))
            cells.append(part.resize((width, round(part.height * width / part.width)), Image.Resampling.NEAREST))
        columns.append(cells)
    width = columns[0][0].width
    heights = [cell.height for cell in columns[0]]
    size = (len(columns) * (width + GAP) - GAP, sum(heights) + GAP * (len(heights) - 1))
    out = Image.new("RGB", size, "white")
    for i, cells in enumerate(columns):
        for k, cell in enumerate(cells):
            out.paste(cell, (i * (width + GAP), sum(heights[:k]) + k * GAP))
    return out


def _by_quality(results: Sequence[Result], samples: Sequence[int]) -> list[str]:
    """A table: rows of quality and guides, columns of samples."""
    head = [f"{count} samples" for count in samples]
    timed = OURS if OURS in samples else samples[-1]
    lines = [
        f"| denoising | guides | {' | '.join(head)} | seconds at {timed} |",
        f"| --- | --- |{' ---: |' * (len(samples) + 1)}",
    ]
    for quality, guides in ROWS:
        cells = []
        for count in samples:
            errors = [one.errors.get(("petzval", count, quality, guides)) for one in results]
            middle = (
                [f"{median(one.flip for one in errors):.3f} · {_short(median(one.rel_mse for one in errors))}"]
                if all(errors)
                else ["–"]
            )
            cells += middle
        seconds = sum(one.seconds["petzval", timed, quality, guides] for one in results)
        name = "–" if quality == "off" else guides
        lines.append(f"| {quality} | {name} | {' | '.join(cells)} | {seconds:.1f} |")
    return lines


def _beside(results: Sequence[Result], samples: Sequence[int]) -> list[str]:
    """A table of scenes beside Cycles."""
    if not {OURS, THEIRS} <= set(samples):
        return []
    columns = (
        ("petzval", OURS, "off", "none"),
        ("petzval", OURS, "high", "both"),
        ("cycles", OURS, "high", "both"),
        ("cycles", THEIRS, "high", "both"),
    )
    no_worse = sum(one.errors[columns[1]].flip <= one.errors[columns[3]].flip for one in results)
    lines = [
        "### Beside Cycles with its own denoiser",
        "",
        f"FLIP of both, denoised at High with both guides. **Petzval's {OURS} samples are at least as near to the converged picture as Cycles' {THEIRS} in",
        f"{no_worse} of {len(results)} scenes.**",
        "",
        f"| scene | Petzval {OURS}, off | Petzval {OURS} | Cycles {OURS} | Cycles {THEIRS} | seconds, Petzval {OURS} / Cycles {THEIRS} |",
        "| --- | ---: | ---: | ---: | ---: | ---: |",
    ]
    for one in results:
        flips = [f"{one.errors[key].flip:.3f}" for key in columns]
        seconds = [f"{max(one.seconds[key], 0.0):.1f}" for key in (columns[1], columns[3])]
        lines.append(f"| {one.scene.name} | {' | '.join(flips)} | {' / '.join(seconds)} |")
    return lines


def _short(number: float) -> str:
    """Two significant digits."""
    return f"{number:#.2g}".rstrip(".")
