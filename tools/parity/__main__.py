# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m parity [--samples N] [--most N] [--only NAME ...] [--scenes FOLDER]`, in the environment .venv-bench, tools/ on
the path.

Renders every parity scene by Petzval and by Cycles, and writes docs/parity.md with its pictures. With --only the page stays
as it is. With --scenes other people's scenes are rendered after that, into docs/parity-others.md. A scene that has been rendered
with the same numbers is not rendered again unless --again says so.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import blend_files
import pages

from . import MARK, compare, page

TOP = Path(__file__).resolve().parents[2]
WORK = TOP / "output" / "parity"
#: A scene that takes longer, s, is given up.
LONGEST_S = 1800


def main() -> int:
    asked = argparse.ArgumentParser(prog="parity", description="Compares Petzval with Cycles, scene by scene.")
    asked.add_argument("--samples", type=int, default=64, help="a pixel, in each program, to begin with")
    asked.add_argument("--most", type=int, default=256, help="samples where blocks are noisy")
    asked.add_argument("--size", default="128x96", help="of a picture")
    asked.add_argument("--only", nargs="+", metavar="NAME", help="these scenes alone; the page stays as it is")
    asked.add_argument("--scenes", default=os.environ.get("PETZVAL_SCENES"), help="a folder of .blend files to try too")
    asked.add_argument("--again", action="store_true", help="render also what has been rendered")
    options = asked.parse_args()
    size = tuple(map(int, options.size.split("x")))
    python = next((p for v in ("52", "45") if (p := TOP / f".venv-bpy{v}" / "bin" / "python").exists()), None)
    if python is None:
        print("petzval: no environment with bpy: make build", file=sys.stderr)
        return 1
    run = Run(python, [*size, options.samples, options.most], options.again)
    try:
        scenes = run.listed()
    except subprocess.CalledProcessError as error:
        print(f"petzval: the scenes cannot be listed: {error.stderr.strip().splitlines()[-1]}", file=sys.stderr)
        return 1
    chosen = options.only or scenes
    unknown = [name for name in chosen if name not in scenes]
    if unknown:
        print(f"petzval: no parity scene {', '.join(unknown)}: see tests/scenes/parity_scenes", file=sys.stderr)
        return 1
    began = time.monotonic()
    results = run.all({name: WORK / name for name in chosen})
    if not options.only:
        limits = run.limits(WORK / "limits")
        now = run.made.took(time.monotonic() - began)
        page.write(TOP / "docs", WORK, scenes, results, limits, size, options.samples, options.most, now)
    if options.scenes and not options.only:
        paths = blend_files.under(Path(options.scenes))
        others = run.all({str(path): WORK / "others" / path.stem for path in paths})
        others = {Path(path).stem: found for path, found in others.items()}
        page.write_others(TOP / "docs", others, size, options.samples, options.most)
    return int(any("failed" in one for one in results.values()))


def say(name: str, found: dict) -> None:
    keys = [key for key in ("skipped", "failed", "black") if key in found]
    numbers = [
        f"{key} {found[key]:.4f}" for key in ("flip", "flip_of_halves", "worst_block", "noise", "mean") if key in found
    ]
    print(f"{name:26s}", *(f"{key}: {found[key]}" for key in keys), *numbers, flush=True)


class Run:
    """Renders scenes, one after the other in one process, and in another when that ends."""

    def __init__(self, python: Path, numbers: list[int], again: bool) -> None:
        self.python, self.numbers, self.again = python, [*map(str, numbers)], again
        self.made = pages.made("docs/parity.md")
        paths = [TOP / "tools", TOP / "tests", TOP / "tests" / "scenes", *filter(None, [os.environ.get("PYTHONPATH")])]
        self.environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, paths))}

    def listed(self) -> dict[str, dict]:
        """The parity scenes: chapter, title, tolerance, why, by name."""
        code = (
            "import json, os; from dataclasses import asdict; from parity_scenes import SCENES\n"
            f"print({MARK!r} + json.dumps({{name: {{**asdict(one), 'fill': None}} for name, one in SCENES.items()}}), flush=True)\n"
            "os._exit(0)"
        )
        done = subprocess.run(
            [self.python, "-c", code], capture_output=True, text=True, env=self.environment, check=True
        )
        return _marked(done.stdout)

    def all(self, scenes: dict[str, Path]) -> dict[str, dict]:
        """Renders and compares each in its folder, and returns the findings; a scene that cannot be rendered has the reason."""
        results = {scene: self._kept(folder) for scene, folder in scenes.items()}
        left = {scene: folder for scene, folder in scenes.items() if results[scene] is None}
        while left:
            for scene, found in self._rendered(dict(left)):
                results[scene] = found
                say(Path(scene).stem, found)
                left.pop(scene)
        return results

    def limits(self, folder: Path) -> dict[str, dict]:
        """The scenes in which Cycles is not exact: of `parity.limits`."""
        kept = folder / "found.json"
        if kept.exists() and not self.again:
            return json.loads(kept.read_text())
        folder.mkdir(parents=True, exist_ok=True)
        command = [self.python, "-m", "parity.limits", str(folder)]
        done = subprocess.run(command, capture_output=True, text=True, env=self.environment)
        found = _marked(done.stdout)
        if found is None:
            raise SystemExit(
                f"petzval: where Cycles is not exact: {(done.stderr.strip().splitlines() or ['nothing said'])[-1]}"
            )
        found = {name: one | {"made": self.made} for name, one in found.items()}
        kept.write_text(json.dumps(found, indent=1) + "\n")
        return found

    def _kept(self, folder: Path) -> dict | None:
        kept = folder / "found.json"
        found = json.loads(kept.read_text()) if kept.exists() and not self.again else {}
        # One that does not say where it came from would leave the page without a footer that is true.
        return found if found.get("numbers") == self.numbers and "made" in found else None

    def _rendered(self, scenes: dict[str, Path]):
        """Scenes and their findings, in one process: up to the first that fails."""
        for folder in scenes.values():
            folder.mkdir(parents=True, exist_ok=True)
        pairs = [part for scene, folder in scenes.items() for part in (scene, str(folder))]
        command = [self.python, "-m", "parity.job", *self.numbers, *pairs]
        with tempfile.TemporaryFile("w+") as errors:
            job = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, text=True, env=self.environment)
            for scene, folder in scenes.items():
                late = threading.Timer(LONGEST_S, job.kill)
                late.start()
                found = next(filter(None, map(_marked, job.stdout)), None)
                late.cancel()
                if found is None:
                    errors.seek(0)
                    last = (errors.read().strip().splitlines() or ["it said nothing, or was not done in time"])[-1]
                    yield scene, {"failed": f"exit {job.wait()}: {last}", "made": self.made}
                    return
                if "skipped" not in found:
                    found |= compare.compare(folder)
                found |= {"numbers": self.numbers, "made": self.made}
                (folder / "found.json").write_text(json.dumps(found, indent=1) + "\n")
                yield scene, found
            job.wait()


def _marked(said: str) -> dict | None:
    line = next((line for line in said.splitlines() if line.startswith(MARK)), None)
    return json.loads(line[len(MARK) :]) if line else None


if __name__ == "__main__":
    sys.exit(main())
