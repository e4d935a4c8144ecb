# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m soak [--edits N] [--renders N] [--frames N] [--kills N] [--only KIND ...]`, tools/ on the path, by a Python with bpy.

Does each kind of work in a Blender of its own, prints what it keeps of memory, open files and threads as a table, and fails where that is
beyond the bounds. Runs of fewer than a thousand are not held against them.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import statistics
import subprocess
import sys
from pathlib import Path

TOP = Path(__file__).resolve().parents[2]
#: How often each kind of work is done.
COUNTS = {"edits": 10_000, "renders": 1_000, "frames": 10_080, "kills": 200}
WORDS = {
    "edits": "edits of a 3D view, of {kinds} kinds in turns, each looked at until it has a picture",
    "renders": "final renders in one Blender: cameras, lenses, integrators, passes, denoising, motion blur",
    "frames": "frames of an animation through a lens: one a minute for a week",
}
#: The part by which memory may grow from the second fifth of a run to the last one.
MOST_GROWTH = 0.01
#: Shorter runs tell nothing of growth: Blender and Petzval still take what they keep.
LEAST_HELD = 1_000

Row = dict[str, float]


def main() -> int:
    asked = argparse.ArgumentParser(
        prog="soak", description="What thousands of edits, renders and frames leave behind."
    )
    for kind, count in COUNTS.items():
        asked.add_argument(f"--{kind}", type=int, default=count)
    asked.add_argument(
        "--only", nargs="+", choices=COUNTS, default=list(COUNTS), metavar="KIND", help=", ".join(COUNTS)
    )
    options = asked.parse_args()
    is_right = True
    print("| trial | count | found |\n|---|---:|---|", flush=True)
    for kind in options.only:
        count = getattr(options, kind)
        print(f"{count} {kind} ...", file=sys.stderr, flush=True)
        line, is_kept = killed(count) if kind == "kills" else held(kind, count)
        print(line, flush=True)
        is_right &= is_kept
    return 0 if is_right else 1


def environment() -> dict[str, str]:
    paths = [str(TOP / "tools"), str(TOP / "tests"), *filter(None, [os.environ.get("PYTHONPATH")])]
    return os.environ | {"PYTHONPATH": os.pathsep.join(paths)}


def held(kind: str, count: int) -> tuple[str, bool]:
    """A row of the table, and true if the work kept within the bounds."""
    rows = work(kind, count)
    fifth = len(rows) // 5
    early, late = ({name: statistics.median(row[name] for row in part) for name in rows[0]}
                   for part in (rows[fifth : 2 * fifth], rows[-fifth:]))  # fmt: skip
    growth = late["memory_mb"] / early["memory_mb"] - 1.0
    more = {name: int(late[name] - early[name]) for name in ("handles", "threads")}
    is_kept = count < LEAST_HELD or growth < MOST_GROWTH and all(number <= 0 for number in more.values())
    words = WORDS[kind].format(kinds=rows[0].get("kinds", 0))
    found = (
        f"{early['memory_mb']:.0f} MB in the second fifth, {late['memory_mb']:.0f} MB in the last ({100 * growth:+.2f} %); "
        f"{more['handles']:+d} open files, {more['threads']:+d} threads"
    )
    return f"| {words} | {count} | {found}{'' if is_kept else ': **too much**'} |", is_kept


def work(kind: str, count: int) -> list[Row]:
    """The footprints on the way."""
    done = subprocess.run(
        [sys.executable, "-m", "soak.work", kind, str(count)],
        stdout=subprocess.PIPE, text=True, check=False, env=environment(),
    )  # fmt: skip
    rows = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
    if done.returncode or not rows or rows[-1]["done"] != count:
        raise SystemExit(
            f"soak: {kind} ended after {rows[-1]['done'] if rows else 0} of {count} (status {done.returncode})"
        )
    return rows


def killed(count: int) -> tuple[str, bool]:
    """A row of the table, and true if a render that was killed so often has the picture of one that was not."""
    # A kill comes after a quarter of a second of work, which is some samples: so many that the render does not end before the last one.
    samples = str(max(200, 10 * count))
    command = [
        sys.executable,
        str(TOP / "tools" / "kill_often.py"),
        "--kills",
        str(count),
        "--every",
        "0.2",
        "--samples",
        samples,
    ]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False, env=environment())
    said = re.search(r"kills: (.*)$", done.stdout, re.MULTILINE)
    if said is None:
        raise SystemExit(f"soak: kills ended with status {done.returncode}: {done.stdout.strip()[-500:]}")
    return (
        f"| one render killed (SIGKILL) at random moments, with all kinds of passes, going on each time | {count} | {said[1]} |",
        not done.returncode,
    )


if __name__ == "__main__":
    sys.exit(main())
