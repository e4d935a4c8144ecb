#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the cost of each camera and pipeline, in time and in noise: renders the demo scene by each, in turns, and writes
docs/camera-price.md. Run by `make price` in an environment that has petzval and bpy. `--quick` tries it at a small size."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

import pages

ROOT = Path(__file__).resolve().parent.parent
SCENE = ROOT / "tests/scenes/demo.blend"
LENS = ["--lens", str(ROOT / "lenses/wide-angle-smith-f3.4.lens")]
SIZE = "240x135"
SAMPLES = 32
ROUNDS = 5
#: The samples of the picture that errors are measured against, by the pipeline with the least noise.
REFERENCE_SAMPLES = 1024
#: Brightest part of the squared errors that is left out: a few caustics would decide it all.
TRIMMED = 1e-3

RUNS = {
    "pinhole": ["--camera", "pinhole"],
    "thin lens": ["--camera", "thin", "--f-number", "3.4"],
    "exact, one wavelength": [*LENS, "--spectrum", "587.56"],
    "exact, three wavelengths, hero": [*LENS, "--spectrum", "rgb"],
    "exact, spectrum, film-first": [*LENS, "--pipeline", "film"],
    "exact, spectrum, scene-first": [*LENS, "--pipeline", "scene"],
    "exact, spectrum, hero": [*LENS, "--pipeline", "hero"],
}
SPECTRAL = [name for name in RUNS if "spectrum" in name]

HEAD = """# What a camera costs

The demo scene, {size} pixels, {samples} samples a pixel, one thread; renders in turns, medians of {rounds} rounds of the
engine's own time. The lens is the wide angle of the paper's figure 3, wide open.

| camera and pipeline | µs a sample | over pinhole | over one wavelength | rays lost |
|---|---:|---:|---:|---:|
"""
NOISE = """
Noise of the pipelines that see the whole spectrum, against a picture of {reference} samples: the relative mean squared
error (the highest {trimmed:.1%} of the pixels left out), and the time to reach the error that film-first has, in its time.

| pipeline | relMSE | time to equal error |
|---|---:|---:|
"""


def render(options: list[str], folder: str, samples: int, seed: int, threads: int) -> tuple[dict, Path]:
    picture = Path(folder) / "picture.exr"
    stats = Path(folder) / "stats.json"
    command = [sys.executable, "-m", "petzval", "render", str(SCENE), *options, "--resolution", SIZE]
    command += ["--samples", str(samples), "--seed", str(seed), "--threads", str(threads)]
    command += ["-o", str(picture), "--stats", str(stats)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return json.loads(stats.read_text()), picture


def pixels(path: Path):
    """Scene-linear RGB."""
    import bpy
    import numpy as np

    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    flat = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(flat)
    bpy.data.images.remove(image)
    return flat.reshape(-1, 4)[:, :3].astype(np.float64)


def relative_error(picture, reference) -> float:
    import numpy as np

    # The usual guard of one hundredth keeps black pixels from deciding.
    squares = ((picture - reference) ** 2 / (reference**2 + 1e-2)).mean(axis=1)
    return float(np.sort(squares)[: int(len(squares) * (1.0 - TRIMMED))].mean())


def main() -> None:
    global SIZE, SAMPLES, ROUNDS, REFERENCE_SAMPLES
    if "--quick" in sys.argv[1:]:
        SIZE, SAMPLES, ROUNDS, REFERENCE_SAMPLES = "48x27", 2, 1, 8
    began, origin = time.monotonic(), pages.made("docs/camera-price.md")
    times: dict[str, list[float]] = {name: [] for name in RUNS}
    lost: dict[str, float] = {}
    errors: dict[str, list[float]] = {name: [] for name in SPECTRAL}
    with tempfile.TemporaryDirectory() as folder:
        reference = pixels(render(RUNS["exact, spectrum, hero"], folder, REFERENCE_SAMPLES, 1000, 0)[1])
        for turn in range(ROUNDS):
            for name, options in RUNS.items():
                stats, picture = render(options, folder, SAMPLES, turn, 1)
                times[name].append(stats["seconds"]["render"])
                lost[name] = stats["camera_rays_lost"] / stats["camera_rays"]
                if name in errors:
                    errors[name].append(relative_error(pixels(picture), reference))
                print(f"petzval: round {turn + 1} of {ROUNDS}: {name}: {times[name][-1]:.2f} s", flush=True)
    width, height = map(int, SIZE.split("x"))
    count = width * height * SAMPLES
    # Ratios within a round, then their median: the machine may be slower in one round than in another.
    over = {name: {base: median(a / b for a, b in zip(times[name], times[base], strict=True))
                   for base in ("pinhole", "exact, one wavelength")} for name in RUNS}  # fmt: skip
    text = HEAD.format(size=SIZE.replace("x", " x "), samples=SAMPLES, rounds=ROUNDS)
    for name in RUNS:
        by_pinhole, by_one = over[name].values()
        each = median(times[name]) / count * 1e6
        text += f"| {name} | {each:.2f} | {by_pinhole:.2f} | {by_one:.2f} | {100 * lost[name]:.1f} % |\n"
    text += NOISE.format(reference=REFERENCE_SAMPLES, trimmed=TRIMMED)
    base_error = median(errors["exact, spectrum, film-first"])
    for name in SPECTRAL:
        error = median(errors[name])
        paired = zip(times[name], times["exact, spectrum, film-first"], strict=True)
        equal = median(a / b for a, b in paired) * error / base_error
        text += f"| {name.removeprefix('exact, spectrum, ')} | {error:.4f} | {equal:.2f} |\n"
    (ROOT / "docs/camera-price.md").write_text(pages.stamped(text, origin.took(time.monotonic() - began)))
    print("petzval: wrote docs/camera-price.md", flush=True)
    # bpy with a render engine may crash when Python ends by itself.
    sys.stdout.flush()
    os._exit(0)


main()
