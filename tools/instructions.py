#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Counts the instructions of a sample in the path kernel, and says how that differs from the count kept in
tools/instructions.json. A report, never a failure: its counts are stable, but a library or compiler may change it.

    tools/instructions.py           counts and compares
    tools/instructions.py --keep    counts and keeps

Needs valgrind, and the example path_kernel as `make instructions` builds it.
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
KEPT = Path(__file__).with_suffix(".json")
SIZE = (96, 54)
CAMERAS = {"pinhole": "pinhole", "thin": "thin lens", "one": "exact, one wavelength", "exact": "exact, spectrum"}


def kernel() -> Path:
    done = subprocess.run(
        ["cargo", "metadata", "--no-deps", "--format-version=1"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return Path(json.loads(done.stdout)["target_directory"]) / "release/examples/path_kernel"


def instructions(program: Path, camera: str, samples: int) -> int:
    size = "x".join(map(str, SIZE))
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", program, camera, str(samples), size]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=True)
    return int(re.search(r"Collected : (\d+)", done.stderr)[1])


def main() -> int:
    if shutil.which("valgrind") is None:
        print("instructions of a sample: not counted, valgrind is not installed")
        return 0
    program = kernel()
    if not program.exists():
        print(f"instructions of a sample: not counted, {program.name} is not built: make instructions")
        return 0
    kept = json.loads(KEPT.read_text()) if KEPT.exists() else {}
    counts = {}
    for word, name in CAMERAS.items():
        try:
            # What is done once falls out of the difference.
            once, thrice = (instructions(program, word, samples) for samples in (1, 3))
        except (subprocess.SubprocessError, TypeError) as error:
            print(f"instructions of a sample: not counted, valgrind failed: {error}")
            return 0
        counts[name] = round((thrice - once) / (2 * SIZE[0] * SIZE[1]))
        before = kept.get(name)
        change = f"{counts[name] / before - 1:+.1%} of the {before} kept" if before else "nothing kept"
        print(f"instructions of a sample, {name}: {counts[name]} ({change})")
    if "--keep" in sys.argv[1:]:
        KEPT.write_text(json.dumps(counts, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
