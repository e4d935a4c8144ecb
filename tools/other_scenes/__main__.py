# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m other_scenes FOLDER [--samples N] [--size WxH] [--only NAME ...] [--look]`, tools/ on the path, by a Python with bpy's
environment.

Renders every .blend under the folder by both programs, each scene in a Blender of its own, and writes docs/other-scenes.md; with --only
the page stays as it is. With --look many scenes are rendered in one process, some seconds each, those without a camera too, and those are
told that are apart. Scripts of the files are never run, and nothing is written beside them.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import json
import math
import os
import select
import subprocess
import sys
import tempfile
import time
import tomllib
from pathlib import Path
from statistics import median

import blend_files
import numpy as np
import pages

from . import compare

TOP = Path(__file__).resolve().parents[2]
PAGE = TOP / "docs" / "other-scenes.md"
#: The known facts about scenes: their sources, and why they differ.
KNOWN = Path(__file__).with_name("known.toml")
PROGRAMS = ("petzval", "cycles")
#: Samples of the short render: the time of work done once is subtracted by it.
FEW = 8
#: Processor time, s, that samples must take to be timed, and no less than work done once, which varies by a tenth of itself and more.
#: Where they take less, a longer render is timed, but of no more than so many times the samples.
LEAST_S = 4.0
MOST_LONGER = 32
#: Processor time of a sample below which it is lost in work done once, even so.
LEAST_US = 0.05
#: Two pictures of each program are enough where they give the noise within this part; else there are more, as long as renders are short, s
#: of processor time.
NOISE_WITHIN = 0.1
MOST_SEEDS = 8
SHORT_S = 8.0
#: Scenes of a first look that one process renders, and the time that each may take, s.
LOOKED_AT_TOGETHER = 8
LONGEST_LOOK_S = 120
#: Renders of each length that are timed.
TURNS = 3
#: A render that takes longer, s, is given up.
LONGEST_S = 1500
#: The reason why a file that is a part of others is left out, as `other_scenes.job` says it.
NO_CAMERA = "it has no camera"
#: The difference beyond noise up to which pictures agree.
ALIKE = 0.01


class Failed(Exception):
    """A scene cannot be compared; the message says why."""


def main() -> int:
    asked = argparse.ArgumentParser(
        prog="other_scenes", description="Compares Petzval with Cycles on scenes by others."
    )
    asked.add_argument("folder", type=Path, help="of .blend files")
    asked.add_argument("--samples", type=int, default=64)
    asked.add_argument("--size", default="240x135")
    asked.add_argument("--only", nargs="+", metavar="NAME", help="files of these names; the page stays as it is")
    asked.add_argument("--look", action="store_true", help="a first look; the page stays as it is")
    options = asked.parse_args()
    scenes = [path for path in blend_files.under(options.folder) if not options.only or path.stem in options.only]
    if not scenes:
        print(f"petzval: no .blend to compare in {options.folder}", file=sys.stderr)
        return 1
    width, height = map(int, options.size.split("x"))
    if options.look:
        return look(scenes, width, height, options.samples)
    began, made, rows = time.monotonic(), pages.made("docs/other-scenes.md"), {}
    seen: dict[str, Path] = {}
    for path in scenes:
        # Repositories hold copies of each other's files.
        if (first := seen.setdefault(hashlib.sha256(path.read_bytes()).hexdigest(), path)) != path:
            print(f"{path.stem:26s} is the same file as {first.relative_to(options.folder)}", flush=True)
            continue
        name = path.stem if path.stem not in rows else f"{path.parent.name}/{path.stem}"
        try:
            rows[name] = compared(path, width, height, options.samples)
        except Failed as why:
            rows[name] = {"left_out": str(why)}
        if rows[name].get("left_out") == NO_CAMERA:
            # A part of another file.
            del rows[name]
            continue
        print(f"{name:26s} {said(rows[name])}", flush=True)
    print(summary(rows))
    if not options.only:
        write(rows, options.size, options.samples, made.took(time.monotonic() - began))
    return 0


def look(scenes: list[Path], width: int, height: int, samples: int) -> int:
    """Prints the difference of the programs in each scene; those that take Blender down are told, too."""
    left, apart = list(scenes), 0
    while left:
        some = left[:LOOKED_AT_TOGETHER]
        command = [sys.executable, "-m", "other_scenes.look", width, height, samples, *some]
        try:
            done = subprocess.run(
                [*map(str, command)],
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                text=True,
                timeout=LONGEST_LOOK_S * len(some),
                env=os.environ
                | {"PYTHONPATH": os.pathsep.join([str(TOP / "tools"), os.environ.get("PYTHONPATH", "")])},
                check=False,
            ).stdout
        except subprocess.TimeoutExpired as late:
            done = (late.stdout or b"").decode()
        found = [json.loads(line) for line in done.splitlines()]
        if len(found) < len(some):
            found.append({"scene": str(some[len(found)]), "left_out": "Blender ended, or took too long"})
        for one in found:
            # Blocks at 64 samples have noise of their own, a part of which is left.
            is_apart = one.get("beyond_noise", 0.0) > max(ALIKE, 0.5 * one.get("of_noise", 0.0))
            apart += is_apart
            what = one.get("left_out") or (
                f"{one['beyond_noise']:7.2%} beyond noise of {one['of_noise']:.2%}, mean {one['mean']:.3f}"
                + " APART" * is_apart
            )
            print(f"{what}  {one['scene']}", flush=True)
        left = left[len(found) :]
    print(f"{len(scenes)} scenes, {apart} of them apart")
    return 0


class Renders:
    """A Blender with a scene, which renders it by both programs."""

    def __init__(self, scene: Path, width: int, height: int, told: Path) -> None:
        """`told`: a file for what Blender prints, which may be more than a pipe holds."""
        environment = os.environ | {
            "PYTHONPATH": os.pathsep.join([str(TOP / "tools"), os.environ.get("PYTHONPATH", "")])
        }
        self._told = told
        with told.open("w") as stderr:
            self._blender = subprocess.Popen(
                [sys.executable, "-m", "other_scenes.job", str(scene), str(width), str(height)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=stderr,
                text=True,
                env=environment,
            )

    def __enter__(self) -> Renders:
        return self

    def __exit__(self, *_: object) -> None:
        self._blender.kill()
        self._blender.communicate()

    def ask(self, **what: object) -> dict:
        """The answer to a request."""
        assert self._blender.stdin is not None and self._blender.stdout is not None
        with contextlib.suppress(BrokenPipeError):
            self._blender.stdin.write(json.dumps(what) + "\n")
            self._blender.stdin.flush()
        if not select.select([self._blender.stdout], [], [], LONGEST_S)[0]:
            raise Failed(f"a render took longer than {LONGEST_S} s")
        if line := self._blender.stdout.readline():
            return json.loads(line)
        told = self._told.read_text(errors="replace")
        if "Failed to read blend file" in told:
            raise Failed("Blender cannot read it")
        raise Failed((told.strip().splitlines() or [f"Blender ended with {self._blender.wait()}"])[-1][:200])


def compared(path: Path, width: int, height: int, samples: int) -> dict:
    """The comparison of both programs on a scene."""
    #: Processor times of renders, by program and samples.
    seconds: dict[tuple[str, int], list[float]] = {}
    with tempfile.TemporaryDirectory() as folder, Renders(path, width, height, Path(folder) / "told.txt") as renders:

        def render(program: str, name: str, count: int, seed: int) -> Path:
            """A picture; its processor time joins those of the same length."""
            out = Path(folder) / f"{program}_{name}.exr"
            took = renders.ask(program=program, picture=str(out), samples=count, seed=seed)["seconds"]
            seconds.setdefault((program, count), []).append(took)
            return out

        seeds = [1, 2]
        pictures = {program: [render(program, str(seed), samples, seed) for seed in seeds] for program in PROGRAMS}
        noises = measured_noise(renders, Path(folder) / "all.npz", pictures)
        while (
            len(seeds) < MOST_SEEDS
            and max(one.error for one in noises.values()) > NOISE_WITHIN
            and max(min(seconds[program, samples]) for program in PROGRAMS) < SHORT_S
        ):
            more = [seeds[-1] + 1, seeds[-1] + 2]
            for program in PROGRAMS:
                pictures[program] += [render(program, str(seed), samples, seed) for seed in more]
            seeds += more
            noises = measured_noise(renders, Path(folder) / "all.npz", pictures)
        # The machine is slower at one time than at another: the programs take turns, and the quickest of each counts.
        for seed in range(1, TURNS + 1):
            for program in PROGRAMS:
                render(program, "few", FEW, seed)
        once = {program: min(seconds[program, FEW]) for program in PROGRAMS}
        most = {}
        for program in PROGRAMS:
            least = max(LEAST_S, once[program])
            longer = least / max(min(seconds[program, samples]) - once[program], least / MOST_LONGER)
            most[program] = max(math.ceil(longer), 1) * samples
        # Pictures that took long enough count, too.
        for seed in range(1, TURNS + 1):
            for program in PROGRAMS:
                if len(seconds.get((program, most[program]), [])) < TURNS:
                    render(program, "long", most[program], seed)
        sample_us = {}
        for program in PROGRAMS:
            taken_s = min(seconds[program, most[program]]) - once[program]
            sample_us[program] = taken_s / (width * height * (most[program] - FEW)) * 1e6
        of = pixels_of(Path(folder) / "all.npz", pictures)
    found = compare.difference(*(of[program] for program in PROGRAMS))
    result = {"beyond_noise": found.beyond_noise, "of_noise": found.of_noise, "mean": found.mean, "seeds": len(seeds)}
    for program, noise in noises.items():
        result[program] = {"sample_us": sample_us[program], "noise": noise.variance}
    ours, theirs = result["petzval"], result["cycles"]
    result["noise_ratio"] = ours["noise"] / max(theirs["noise"], 1e-12)
    result["time_ratio"] = result["noise_ratio"] * ours["sample_us"] / max(theirs["sample_us"], 1e-9)
    return result


def pixels_of(file: Path, pictures: dict[str, list[Path]]) -> dict[str, list[np.ndarray]]:
    """The pixels of each program's pictures, out of the files of the step `read`."""
    found = np.load(file)
    return {program: [found[one.stem].astype(np.float64) for one in own] for program, own in pictures.items()}


def measured_noise(renders: Renders, file: Path, pictures: dict[str, list[Path]]) -> dict[str, compare.Noise]:
    """The noise of each program; their pixels are written to `file`."""
    renders.ask(pixels=str(file), pictures=[str(one) for own in pictures.values() for one in own])
    of = pixels_of(file, pictures)
    mean = np.maximum(np.mean([one for own in of.values() for one in own], axis=0), 0.0)
    return {program: compare.noise(own, mean) for program, own in of.items()}


def is_timed(row: dict) -> bool:
    """True if the times of a row count: a picture of next to nothing takes too little, and without noise there is none to compare."""
    return all(row[one]["sample_us"] >= LEAST_US and row[one]["noise"] > 0.0 for one in PROGRAMS)


def said(row: dict) -> str:
    if "left_out" in row:
        return f"left out: {row['left_out']}"
    ours, theirs = row["petzval"], row["cycles"]
    return (
        f"beyond noise {row['beyond_noise']:.4f} (noise {row['of_noise']:.4f}) mean {row['mean']:.4f} | us a sample "
        f"{ours['sample_us']:.2f} / {theirs['sample_us']:.2f} noise {ours['noise']:.3g} / {theirs['noise']:.3g} | "
        f"time to equal noise {row['time_ratio']:.2f}{'' if row['beyond_noise'] <= ALIKE else '  APART'}"
    )


def summary(rows: dict[str, dict]) -> str:
    found = [row for row in rows.values() if "left_out" not in row]
    if not found:
        return "No scene could be compared."
    alike = sum(row["beyond_noise"] <= ALIKE for row in found)
    ratios = [row["time_ratio"] for row in found if is_timed(row)]
    if not ratios:
        return f"{alike} of {len(found)} scenes agree with Cycles within 1 % beyond noise."
    return (
        f"{alike} of {len(found)} scenes agree with Cycles within 1 % beyond noise. Processor time to equal noise over Cycles', of the "
        f"{len(ratios)} that take long enough to say: {median(ratios):.2f} in the middle, {min(ratios):.2f} at best, {max(ratios):.2f} at worst."
    )


def write(rows: dict[str, dict], size: str, samples: int, now: pages.Made) -> None:
    known = tomllib.loads(KNOWN.read_text())
    lines = [
        "# Scenes by others",
        "",
        f"Scenes that nobody of this project made, rendered by Petzval and by Cycles in the same Blender at {size}, {samples} samples a pixel and",
        f"two seeds each, or up to {MOST_SEEDS} where few pixels have all the noise, through a pinhole: without depth of field, motion blur,",
        "clamps, denoising and adaptive sampling. The files are not part of the project.",
        "",
        "- **Beyond noise**: how far means of 16 x 9 blocks are apart, root mean square over blocks and channels without the worst",
        "  twentieth, less what seeds differ by. Up to 1 % pictures agree.",
        "- **Mean**: of the whole picture, Petzval's over Cycles'.",
        "- **A sample**: microseconds of processor time, Petzval / Cycles, without what is done once; the quickest of three renders or more.",
        "- **Noise**: relative variance of a pixel, Petzval's over Cycles', at equal samples.",
        "- **Time**: processor time to equal noise, Petzval's over Cycles'.",
        "",
        summary(rows),
        "",
        "| scene | beyond noise | mean | a sample, µs | noise | time | cause of a difference over 1 % or a ratio over 1.2 |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for name, row in sorted(rows.items()):
        about = known.get(name, {})
        if "left_out" in row:
            lines.append(f"| {name} | left out: {row['left_out']} | | | | | |")
            continue
        cells = [
            name,
            f"{100 * row['beyond_noise']:.2f} %",
            f"{row['mean']:.3f}",
            f"{row['petzval']['sample_us']:.2f} / {row['cycles']['sample_us']:.2f}",
            f"{row['noise_ratio']:.2f}" if is_timed(row) else "–",
            f"{row['time_ratio']:.2f}" if is_timed(row) else "–",
            about.get("cause", "" if row["beyond_noise"] <= ALIKE else "not found yet"),
        ]
        lines.append(f"| {' | '.join(cells)} |")
    sources = [f"- {name}: {known[name]['from']}" for name in sorted(rows) if "from" in known.get(name, {})]
    lines += ["", "## Where they are from", "", *sources] if sources else []
    PAGE.write_text(pages.stamped("\n".join(lines) + "\n", now), encoding="utf-8")
    (TOP / "output").mkdir(exist_ok=True)
    (TOP / "output" / "other-scenes.json").write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    sys.exit(main())
