# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m denoising [--scenes FOLDER] [--only NAME ...] [--samples N ...] [--reference N] [--height PIXELS]`, in the environment
.venv-bench, tools/ on the path.

Renders the demo and the gallery through lenses, and the .blend files under the folder through a pinhole, there beside Cycles; holds each
picture against a converged one of the same program; writes docs/denoising.md. With --only the page stays as it is.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

import blend_files
import numpy as np
import pages

from . import page
from .measure import Error, error

TOP = Path(__file__).resolve().parents[2]
GALLERY = TOP / "tests" / "scenes" / "gallery"
#: The sources of scenes by others.
KNOWN = TOP / "tools" / "other_scenes" / "known.toml"
#: Guides by Cycles' name of the choice.
GUIDES = {"none": "RGB", "both": "RGB_ALBEDO_NORMAL"}
#: Seeds of the pictures and of their references.
SEED, REFERENCE_SEED = 1, 1001
#: The picture of the page: the demo as `make demo` renders it, smaller. Its parts are shown larger: left, top, right, bottom of the whole.
SHOWN_SIZE, SHOWN_SAMPLES = (640, 360), 24
SHOWN_PARTS = ((0.43, 0.3, 0.63, 0.6), (0.02, 0.72, 0.22, 1.0))
#: A render that takes longer, s, is given up.
LONGEST_S = 1500


@dataclass
class Scene:
    """A scene and its camera."""

    name: str
    #: The .blend, or the script of the gallery that makes it.
    path: Path
    #: Options of `petzval render`.
    camera: tuple[str, ...]
    #: A view of the gallery's scene.
    view: str = ""
    aspect: float = 16.0 / 9.0
    is_by_others: bool = False


def _lens(name: str, path: Path, lens: str, *options: str, **more) -> Scene:
    return Scene(name, path, ("--lens", str(TOP / "lenses" / f"{lens}.lens"), *options), **more)


LENSES = (
    _lens("demo, f/3.4", TOP / "tests" / "scenes" / "demo.blend", "wide-angle-smith-f3.4"),
    _lens(
        "room, f/1.35", GALLERY / "room.py", "double-gauss-f1.35", "--film", "48x32", "--focus-distance", "3000", aspect=1.5
    ),
    _lens(
        "chess, film swung by 10 degrees", GALLERY / "chess.py", "double-gauss-f2-tronnier", "--focal-length", "80",
        "--film", "40x20", "--focus-distance", "800", "--swing", "10", view="row", aspect=2.0,
    ),
    _lens(
        "garden, f/8, five blades", GALLERY / "lights.py", "wide-angle-smith-f3.4", "--focal-length", "100",
        "--focus-distance", "1250", "--f-number", "8", "--blades", "5", view="points", aspect=1.5,
    ),
    _lens(
        "garden, mirror lens", GALLERY / "lights.py", "reflex-nikkor-500-f8", "--focus-distance", "9000",
        view="far", aspect=1.5,
    ),
)  # fmt: skip


@dataclass
class Result:
    """The measurements of a scene."""

    scene: Scene
    #: The errors by program, samples, quality and guides.
    errors: dict[tuple[str, int, str, str], Error] = field(default_factory=dict)
    #: Processor time of samples and denoising, s, likewise.
    seconds: dict[tuple[str, int, str, str], float] = field(default_factory=dict)
    #: The reason why it was left out.
    left_out: str = ""


class Failed(Exception):
    """A scene cannot be measured; the message says why."""


def main() -> int:
    asked = argparse.ArgumentParser(prog="denoising", description="Measures denoised pictures of few samples.")
    asked.add_argument("--scenes", type=Path, help="a folder of .blend files by others")
    asked.add_argument("--only", nargs="+", metavar="NAME", help="scenes whose names begin so; the page stays as it is")
    asked.add_argument("--samples", type=int, nargs="+", default=[16, 32, 64])
    asked.add_argument("--reference", type=int, default=2048, help="samples of converged pictures")
    asked.add_argument("--height", type=int, default=180, help="of a picture, pixels")
    asked.add_argument("--json", type=Path, help="write what was found there, too")
    options = asked.parse_args()
    python = next((p for v in ("52", "45") if (p := TOP / f".venv-bpy{v}" / "bin" / "python").exists()), None)
    if python is None:
        print("petzval: no environment with bpy: make build", file=sys.stderr)
        return 1
    scenes = [*LENSES, *by_others(options.scenes)]
    if options.only:
        scenes = [one for one in scenes if one.name.startswith(tuple(options.only))]
    if not scenes:
        print("petzval: no such scene", file=sys.stderr)
        return 1
    began, made = time.monotonic(), pages.made("docs/denoising.md")
    studio = Studio(python, options.samples, options.reference, options.height)
    results = []
    for scene in scenes:
        result = studio.measured(scene)
        results.append(result)
        print(page.said(result, options.samples), flush=True)
    if options.json:
        rows = [
            {
                "scene": one.scene.name,
                "what": key,
                "flip": error.flip,
                "rel_mse": error.rel_mse,
                "seconds": one.seconds.get(key),
            }
            for one in results
            for key, error in one.errors.items()
        ]
        options.json.write_text(json.dumps(rows, indent=0) + "\n")
    if not options.only:
        origins = {name: one["from"] for name, one in tomllib.loads(KNOWN.read_text()).items() if "from" in one}
        text = page.text(results, options.samples, options.reference, options.height, SHOWN_SAMPLES, origins)
        out = TOP / "docs" / "denoising.md"
        studio.picture(LENSES[0], TOP / "docs" / page.PICTURE)
        out.write_text(pages.stamped(text, made.took(time.monotonic() - began)), encoding="utf-8")
    return 0


def by_others(folder: Path | None) -> list[Scene]:
    """The .blend files under a folder, seen by a pinhole."""
    paths = blend_files.under(folder) if folder else []
    return [Scene(path.stem, path, ("--camera", "pinhole"), is_by_others=True) for path in paths]


def settings(program: str, samples: int, scene: Scene) -> tuple[tuple[str, str], ...]:
    """Qualities and guides that are measured: of the many scenes by others all of them only at the samples that are compared."""
    is_whole = program == "petzval" and (samples == page.OURS or not scene.is_by_others)
    return page.ROWS if is_whole else (("off", "none"), ("high", "both"))


class Studio:
    """Renders pictures and holds them against converged ones."""

    def __init__(self, python: Path, samples: list[int], reference: int, height: int) -> None:
        self.python, self.samples, self.reference, self.height = python, samples, reference, height
        self.job = (python, "-m", "denoising.job")

    def run(self, *command: object) -> float:
        """Processor seconds of a command that ends well."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run(
            [*map(str, command)],
            capture_output=True,
            text=True,
            errors="replace",
            timeout=LONGEST_S,
            env=environment(),
            check=False,
        )
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if done.returncode:
            raise Failed((done.stderr.strip().splitlines() or [f"exit {done.returncode}"])[-1][:200])
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    def measured(self, scene: Scene) -> Result:
        """All pictures of a scene."""
        result = Result(scene)
        with tempfile.TemporaryDirectory() as folder:
            try:
                self._measure(result, Path(folder))
            except (Failed, subprocess.TimeoutExpired) as why:
                result.left_out = str(why)
        return result

    def _measure(self, result: Result, folder: Path) -> None:
        scene = result.scene
        base = folder / "base.blend"
        if scene.path.suffix == ".py":
            self.run(self.python, scene.path, base, *([scene.view] if scene.view else []))
        elif scene.is_by_others:
            # As `make other-scenes` compares them: without depth of field, motion blur and clamps.
            self.run(self.python, "-m", "other_scenes.job", "prepare", scene.path, base)
        else:
            base = scene.path
        blends = {guides: folder / f"{guides}.blend" for guides in GUIDES}
        for guides, copy in blends.items():
            self.run(*self.job, "guided", base, copy, GUIDES[guides])
        size = (round(self.height * scene.aspect), self.height)
        once: dict[str, float] = {}

        def render(program: str, samples: int, quality: str, guides: str, seed: int = SEED) -> Path:
            out = folder / f"{program}-{samples}-{quality}-{guides}-{seed}.exr"
            blend = blends[guides]
            if program == "petzval":
                command = [self.python, "-m", "petzval", "render", blend, *scene.camera]
                command += ["--resolution", f"{size[0]}x{size[1]}", "--samples", samples, "--seed", seed]
                command += ["--noise-threshold", "0", "--denoise", quality, "--checkpoint", "off", "-o", out]
            else:
                command = [*self.job, "cycles", blend, out, *size, samples, seed, quality]
            taken = self.run(*command)
            # What is done once, and takes most of the time of a small picture, is that of a picture of one sample.
            result.seconds[program, samples, quality, guides] = taken - once.get(program, 0.0)
            return out

        for program in ("petzval", "cycles") if scene.is_by_others else ("petzval",):
            render(program, 1, "off", "none")
            once[program] = result.seconds.pop((program, 1, "off", "none"))
            reference = render(program, self.reference, "off", "none", REFERENCE_SEED)
            result.seconds.pop((program, self.reference, "off", "none"))
            wanted = {
                (program, samples, *how): render(program, samples, *how)
                for samples in self.samples
                for how in settings(program, samples, scene)
            }
            found = folder / "found.npz"
            self.run(*self.job, "read", base, found, reference, *wanted.values())
            pixels = np.load(found)
            for key, path in wanted.items():
                result.errors[key] = error(pixels, reference.stem, path.stem)

    def picture(self, scene: Scene, out: Path) -> None:
        """Draws a scene without and with denoising beside each other, whole and in parts."""
        with tempfile.TemporaryDirectory() as folder:
            exrs = [Path(folder) / f"{quality}.exr" for quality in ("off", "high")]
            for exr in exrs:
                command = [self.python, "-m", "petzval", "render", scene.path, *scene.camera]
                command += ["--resolution", "x".join(map(str, SHOWN_SIZE)), "--samples", SHOWN_SAMPLES, "--seed", SEED]
                self.run(*command, "--noise-threshold", "0", "--denoise", exr.stem, "--checkpoint", "off", "-o", exr)
            found = Path(folder) / "found.npz"
            self.run(*self.job, "read", scene.path, found, *exrs)
            pixels = np.load(found)
            page.beside([pixels[f"{exr.stem} shown"] for exr in exrs], SHOWN_PARTS).save(out, quality=90)


def environment() -> dict[str, str]:
    own = os.environ.get("PYTHONPATH")
    return os.environ | {"PYTHONPATH": os.pathsep.join([str(TOP / "tools"), *([own] if own else [])])}


if __name__ == "__main__":
    sys.exit(main())
