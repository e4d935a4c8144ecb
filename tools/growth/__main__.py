# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m growth [--only KIND ...] [--most N] [--samples N] [--rounds N]`, tools/ on the path, by a Python with bpy's environment.

Renders scenes in which one number grows by Petzval and by Cycles, each in a process of its own, and writes docs/growth.md; with --only or
--most the page stays as it is.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import time
from pathlib import Path

import pages

from .job import HEIGHT, WIDTH
from .scenes import KINDS, Kind

TOP = Path(__file__).resolve().parents[2]
PAGE = TOP / "docs" / "growth.md"
#: A measurement that takes longer, s, is given up, and no larger one is tried.
LONGEST_S = 300
#: Time and memory below these are the machine's noise: an exponent is not taken from them.
LEAST = {"once_s": 0.1, "again_s": 0.1, "sample_us": 0.0, "memory_mb": 20.0}
#: The columns, and the digits after the point.
COLUMNS = {
    "once_s": "first render, s",
    "again_s": "second render, s",
    "sample_us": "a sample, µs",
    "memory_mb": "memory, MB",
}
DIGITS = {"once_s": 2, "again_s": 2, "sample_us": 2, "memory_mb": 0}
PROGRAMS = ("petzval", "cycles")
#: Samples are timed as a difference of two renders: it says nothing below this part of the time of work done once, which varies.
LEAST_PART = 0.2

Row = dict[str, dict[str, float]]


def main() -> int:
    asked = argparse.ArgumentParser(prog="growth", description="Measures what rendering costs as a scene grows.")
    asked.add_argument("--only", nargs="+", choices=KINDS, metavar="KIND", help=", ".join(KINDS))
    asked.add_argument("--most", type=int, help="no numbers above")
    asked.add_argument("--samples", type=int, default=128, help="by which a sample is timed")
    asked.add_argument("--rounds", type=int, default=2, help="the quickest counts")
    options = asked.parse_args()
    began, made, found = time.monotonic(), pages.made("docs/growth.md"), {}
    for name in options.only or KINDS:
        found[name] = {}
        programs = [one for one in PROGRAMS if one == "petzval" or KINDS[name].by_cycles]
        for number in KINDS[name].values:
            if options.most and number > options.most:
                continue
            row = measured(name, number, programs, options.samples, options.rounds)
            found[name][number] = row
            programs = [one for one in programs if one in row]
            print(name, number, json.dumps(row), flush=True)
            without_lost_samples(row, options.samples)
    if not options.only and not options.most:
        PAGE.write_text(pages.stamped(text(found), made.took(time.monotonic() - began)), encoding="utf-8")
    return 0


def measured(name: str, number: int, programs: list[str], samples: int, rounds: int) -> Row:
    """The least of each figure over the rounds, by program; a program is missing that took too long."""
    row: Row = {}
    for _ in range(rounds):
        for program in programs:
            for figure, value in job(program, name, number, samples).items():
                own = row.setdefault(program, {})
                own[figure] = min(own.get(figure, math.inf), value)
    return row


def without_lost_samples(row: Row, samples: int) -> None:
    """Removes the time of a sample where it is lost in that of work done once."""
    for figures in row.values():
        sampled_s = figures.get("sample_us", 0.0) * 1e-6 * WIDTH * HEIGHT * samples
        if sampled_s < LEAST_PART * figures["once_s"]:
            figures.pop("sample_us", None)


def job(program: str, name: str, number: int, samples: int) -> dict[str, float]:
    command = [sys.executable, "-m", "growth.job", program, name, str(number), str(samples)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST_S, check=False, env=os.environ)
    except subprocess.TimeoutExpired:
        return {}
    if done.returncode:
        raise SystemExit(f"growth: {name} {number} by {program}: {(done.stderr.strip().splitlines() or ['?'])[-1]}")
    return json.loads(next(line for line in reversed(done.stdout.splitlines()) if line.startswith("{")))


def exponent(rows: dict[int, Row], program: str, figure: str) -> str:
    """The power of the number by which a figure grows between the last two numbers; nothing where it is too small to say."""
    pairs = [(n, row[program][figure]) for n, row in rows.items() if figure in row.get(program, {})]
    if len(pairs) < 2:
        return "–"
    (n0, first), (n1, last) = pairs[-2:]
    if min(first, last) <= LEAST[figure]:
        return "–"
    return f"{math.log(last / first) / math.log(n1 / n0):.2f}"


def cell(row: Row, figure: str) -> str:
    parts = [f"{row[one][figure]:.{DIGITS[figure]}f}" if figure in row.get(one, {}) else "–" for one in PROGRAMS]
    return " / ".join(parts)


def table(kind: Kind, rows: dict[int, Row]) -> list[str]:
    shown = [figure for figure in COLUMNS if any(figure in row.get("petzval", {}) for row in rows.values())]
    lines = [f"| {kind.title} | {' | '.join(COLUMNS[one] for one in shown)} |", "| ---: |" + " ---: |" * len(shown)]
    lines += [f"| {n:,} | {' | '.join(cell(row, one) for one in shown)} |" for n, row in rows.items()]
    powers = [" / ".join(exponent(rows, program, one) for program in PROGRAMS) for one in shown]
    return [*lines, f"| *exponent* | {' | '.join(powers)} |"]


def text(found: dict[str, dict[int, Row]]) -> str:
    lines = [
        "# Costs that grow",
        "",
        "Scenes in which one number grows, by Petzval / Cycles, in the same Blender on the same processor. Each is a ground in a grey world under",
        f"a sun, seen through a pinhole at {WIDTH} x {HEIGHT}, with so many of one thing on it. Processor seconds, the least of two runs.",
        "",
        "- **First render**: of one sample a pixel, but where samples grow: all that is done once, and a sample.",
        "- **Second render**: the next frame, before which the camera moves, with Blender's *Persistent Data*.",
        "- **A sample**: of each further sample a pixel; none where it is lost in what is done once.",
        "- **Memory**: the most that the first render takes beside what Blender held before it.",
        "- **Exponent**: the power of the number by which a figure grows over the last step; 1 is in proportion.",
        "  A figure below a tenth of a second or 20 MB has none.",
        "",
    ]
    for name, rows in found.items():
        lines += [*table(KINDS[name], rows), ""]
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
