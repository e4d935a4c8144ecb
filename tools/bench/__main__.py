# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m bench [--quick] [--page]`, in the environment .venv-bench, tools/ on the path: the program of `make bench`.

--quick    a few samples of the small scene, to try; the page goes to output/bench/
--page     writes the page of the last full run again
"""

from __future__ import annotations

import argparse
import importlib.metadata
import json
import re
import sys
import time
from pathlib import Path

import pages

from . import kernels, measure, plot, report, scene
from .programs import TOP, WORK, Bench, Failed


def main() -> int:
    asked = argparse.ArgumentParser(prog="bench", description="Compares Petzval with Cycles and Mitsuba.")
    asked.add_argument(
        "--quick", action="store_true", help="a few samples of the small scene; the page goes to output/"
    )
    asked.add_argument("--page", action="store_true", help="write the page of the last run again")
    options = asked.parse_args()
    plan = measure.QUICK if options.quick else measure.FULL
    results = WORK / ("quick.json" if options.quick else "full.json")
    if not options.page:
        try:
            found = _measured(plan)
        except Failed as error:
            print(f"petzval: {error}", file=sys.stderr)
            return 1
        results.write_text(json.dumps(found, indent=1) + "\n")
    elif not results.exists():
        print(f"petzval: nothing measured yet: no {results}", file=sys.stderr)
        return 1
    _write(json.loads(results.read_text()), plan, WORK if options.quick else TOP / "docs")
    return 0


def _measured(plan: measure.Plan) -> dict:
    began, made = time.monotonic(), pages.made("docs/performance.md")
    (WORK / "pictures").mkdir(parents=True, exist_ok=True)
    scene.write(WORK / "scenes")
    bench = Bench()
    camera = scene.CAMERA
    bench.set_up(
        (*plan.scenes, *plan.places),
        camera["focus_m"],
        camera["focal_length_mm"],
        camera["f_number"],
        with_llvm=plan is measure.FULL,
    )
    found = measure.Experiments(bench, plan).all()
    if plan is measure.FULL:
        kernels.run(TOP)
    found["kernels"] = kernels.read(TOP)
    found["about"] = {
        "made": made.took(time.monotonic() - began),
        "versions": _versions(bench),
        "triangles": {name: scene.read(WORK / "scenes" / name)[0]["triangles"] for name in plan.scenes},
        "missing": bench.missing,
    }
    return found


def _write(found: dict, plan: measure.Plan, folder: Path) -> None:
    plot.draw(found, report.TARGETS, folder / "images" / "performance-noise")
    page = folder / "performance.md"
    text = report.page(found, plan, found["about"], "images/performance-noise.png")
    made = found["about"].get("made")
    page.write_text(pages.stamped(text, pages.Made(*made) if made else pages.kept("docs/performance.md")))
    print(f"petzval: wrote {page.relative_to(TOP)}")


def _versions(bench: Bench) -> str:
    cargo = (TOP / "Cargo.toml").read_text()
    petzval = re.search(r'^version = "(.*)"', cargo, re.MULTILINE)
    parts = [f"Petzval {petzval[1] if petzval else '?'}", f"Blender {bench.versions.get('Blender', '?')}"]
    parts.append(f"Mitsuba {importlib.metadata.version('mitsuba')}")
    if "LLVM" in bench.versions:
        version = re.search(r"LLVM(?:-|\.so\.)(\d+)", bench.versions["LLVM"])
        parts.append(f"LLVM {version[1] if version else '?'}")
    return ", ".join(parts)


if __name__ == "__main__":
    sys.exit(main())
