#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ghosts beside brute force, their cost, and two pictures full of stray light: tables and pictures of docs/ghosts.md. Run by
`make ghosts` in an environment that has petzval, bpy, numpy and Pillow."""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

import numpy as np
import pages
from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
PAGE, IMAGES = ROOT / "docs/ghosts.md", ROOT / "docs/images"
#: Lens, f-number, angle of the source, and rays of brute force.
HELD = (
    ("cooke-triplet-50mm", "4", "0", 400_000),
    ("double-gauss-f2-tronnier", "4", "8", 200_000),
    ("flektogon-1954", "8", "20", 400_000),
    ("fisheye-nikkor-16-f2.8", "4", "10", 200_000),
    ("nikkor-z-24-70-f4", "5.6", "12", 100_000),
    ("phone-4.1-f1.8", "1.8", "15", 100_000),
    ("questar-3.5", "15", "0.2", 400_000),
)
#: Scene, lens, focal length, f-number, blades.
SCENES = {
    "night": ("takumar-35-1970", "35", "8", "6"),
    "sun": ("flektogon-1954", "35", "11", "5"),
}
#: A small picture of few samples through a lens of many surfaces, whose ghosts take long beside its samples.
FORETOLD = (
    ("nikkor-z-50-f1.8", "8", "320x180", 16),
    ("takumar-35-1970", "8", "320x180", 16),
    ("nikkor-z-50-f1.8", "8", "960x540", 64),
)
#: The size of the renders that are timed, whose last ones are the page's pictures: at 1536 x 1024 with 256 samples the page took an hour.
RESOLUTION = "1152x768"
COATINGS = ("none", "mgf2", "triple")


def petzval(*arguments: object) -> str:
    done = subprocess.run(
        [sys.executable, "-m", "petzval", *map(str, arguments)], capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise SystemExit(done.stderr)
    return done.stdout


def held() -> list[str]:
    rows = [
        "| lens | f-number | source | ghosts | on the film, mm² | brute force, mm² | apart |",
        "|---|---:|---:|---:|---:|---:|---:|",
    ]
    for lens, f_number, angle, rays in HELD:
        found = json.loads(
            petzval("lens", "ghosts", lens, "--f-number", f_number, "--angle", angle, "--brute-force", rays, "--json")
        )
        brute = found["brute_force"]
        expected, error = brute["on_film_mm2"][2], brute["error_mm2"][2]
        apart = 100.0 * (found["on_film_mm2"] / expected - 1.0)
        rows.append(
            f"| {lens} | {f_number} | {angle}° | {len(found['ghosts'])} | {found['on_film_mm2']:.4e} | "
            f"{expected:.4e} ± {error:.0e} | {apart:+.2f} % |"
        )
    return rows


def rendered(folder: Path, scene: Path, name: str, *options: object) -> tuple[np.ndarray, dict]:
    lens, focal, f_number, blades = SCENES[name]
    out, stats = folder / "picture.png", folder / "stats.json"
    petzval(
        "render", scene, "--lens", lens, "--focal-length", focal, "--f-number", f_number, "--blades", blades,
        *options, "-o", out, "--stats", stats,
    )  # fmt: skip
    return np.asarray(Image.open(out).convert("RGB")), json.loads(stats.read_text())


def priced(folder: Path, scenes: dict[str, Path], rounds: int, samples: int) -> tuple[list[str], dict[str, np.ndarray]]:
    """The table of prices, and the last picture of each scene."""
    taken = {}
    rows = [
        "| picture | samples | sources | ghosts | without, s | ghosts, s | glare, s | diffraction, s | ghosts' part |",
        "|---|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for name, scene in scenes.items():
        runs = []
        for _ in range(rounds):
            taken[name], told = rendered(folder, scene, name, "--resolution", RESOLUTION, "--samples", samples)
            runs.append(told)
        times = {
            key: median(run["seconds"]["strays"][key] for run in runs) for key in ("ghosts", "glare", "diffraction")
        }
        without = median(run["seconds"]["render"] for run in runs)
        ghosts = runs[0]["ghosts"]
        rows.append(
            f"| {name}, {RESOLUTION} | {samples} | {ghosts['sources']} | {ghosts['simulated']} of {ghosts['found']} | {without:.0f} | "
            f"{times['ghosts']:.1f} | {times['glare']:.1f} | {times['diffraction']:.1f} | "
            f"{100.0 * times['ghosts'] / without:.1f} % |"
        )
    return rows, taken


def foretold(folder: Path, scene: Path, rounds: int) -> list[str]:
    """The table of the plan's forecast of the time of stray light, and the measured time."""
    rows = [
        "| lens | picture | samples, s | foretold after them, s | after them, s | ghosts | left out, of the tolerance |",
        "|---|---|---:|---:|---:|---:|---:|",
    ]
    for lens, f_number, resolution, samples in FORETOLD:
        asked = (scene, "--lens", lens, "--f-number", f_number, "--resolution", resolution)
        plans, runs = [], []
        for _ in range(rounds):
            plans.append(json.loads(petzval("plan", *asked, "--json")))
            out, stats = folder / "picture.exr", folder / "stats.json"
            petzval("render", *asked, "--samples", samples, "-o", out, "--stats", stats)
            runs.append(json.loads(stats.read_text()))
        said = median(plan["predicted"]["after_seconds"] for plan in plans)
        took = median(sum(run["seconds"]["strays"].values()) for run in runs)
        ghosts, without = runs[0]["ghosts"], median(run["seconds"]["render"] for run in runs)
        rows.append(
            f"| {lens}, f/{f_number} | {resolution}, {samples} samples | {without:.1f} | {said:.1f} | {took:.1f} | "
            f"{ghosts['simulated']} of {ghosts['found']} | {ghosts['left_out'] / ghosts['tolerance']:.2f} |"
        )
    return rows


def pictures(folder: Path, scenes: dict[str, Path], taken: dict[str, np.ndarray], samples: int) -> None:
    for name, picture in taken.items():
        Image.fromarray(picture).save(IMAGES / f"stray-{name}.jpg", quality=88)
    strips = []
    for coating in COATINGS:
        options = ("--resolution", "768x512", "--samples", max(samples // 2, 8), "--coating", coating)
        strips.append(rendered(folder, scenes["sun"], "sun", *options)[0])
    Image.fromarray(np.concatenate(strips, axis=1)).save(IMAGES / "ghosts-coatings.jpg", quality=88)


def write(mark: str, rows: list[str]) -> None:
    PAGE.write_text(pages.filled(PAGE.read_text(), mark, rows))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", choices=("held", "price", "foretold"))
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--rounds", type=int, default=2)
    options = parser.parse_args()
    began, origin = time.monotonic(), pages.made("docs/ghosts.md")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        scenes = {}
        for kind in SCENES:
            scenes[kind] = folder / f"{kind}.blend"
            made = [sys.executable, str(ROOT / "tests/scenes/stray_scenes.py"), kind, str(scenes[kind])]
            subprocess.run(made, check=True, capture_output=True)
        if options.only in (None, "held"):
            write("held", held())
        if options.only in (None, "price"):
            rows, taken = priced(folder, scenes, options.rounds, options.samples)
            write("price", rows)
            if options.only is None:
                pictures(folder, scenes, taken, options.samples)
        if options.only in (None, "foretold"):
            write("foretold", foretold(folder, scenes["night"], options.rounds))
    # What is renewed in part stays as old as the rest.
    if options.only is None:
        pages.stamp("docs/ghosts.md", origin.took(time.monotonic() - began))


if __name__ == "__main__":
    main()
