#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes docs/lens-speed.md: runs the lens benches, tabulates them, and counts the instructions of their inner loop.

tools/lens-speed.py [--no-run] [--quick]    --no-run: tabulates the last run again; --quick: to try, with few repetitions
"""

from __future__ import annotations

import json
import os
import platform
import re
import subprocess
import sys
import time
from pathlib import Path

import pages

TOP = Path(__file__).resolve().parent.parent
PAGE = TOP / "docs" / "lens-speed.md"
BENCH = ["cargo", "bench", "-p", "petzval-benches", "--bench", "lens"]
# All levels of processors are timed: these flags leave none out of the kernels.
ENVIRONMENT = os.environ | ({"RUSTFLAGS": "-C target-cpu=x86-64"} if platform.machine() == "x86_64" else {})
LIMIT = "two roots and two divisions"
LENSES = ("wide angle (figure 3)", "double Gauss", "fisheye", "aspheres", "mirrors")
LANES = ("one", "SSE2", "AVX2", "AVX-512", "best")

HEAD = """# What a ray costs

Nanoseconds a ray and surface on one core, from the film to the scene, for rays that get through. Medians of criterion.
*One*: rays one after the other, as `Tracer::from_film` takes them. The others: bundles
(`Tracer::trace`) with registers of 128, 256 and 512 bits; a bundle takes the widest that the processor has. The time to
copy a ray into the bundle is counted.
"""

READING = """
- **Lanes pay twice.** A ray alone waits at every surface for a square root, a division, another root and another division,
  each needing what came before. In a bundle the registers of a block are independent, so the processor begins the next
  while one waits, and each holds 2 to 16 rays.
- **What bounds it.** A sphere between two glasses cannot be traced without two square roots (of the discriminant and of
  Snell's radicand) and two divisions. The last row of the table is the time of these alone. In f64 they are most of what a
  surface costs: the one unit that does them is busy nearly always. In f32 they are half of it or less, and the 130 or so
  instructions about them count as much.
- **Aspheres** are iterated: each Newton step evaluates the polynomial and its slope, and a register waits for the slowest
  of its rays. This lens has eight such surfaces of eleven, with odd powers, which cost a root a step.
- **The fisheye** has surfaces that lie many radii from the one before; rays are carried to the point nearest the vertex
  there: ten instructions more.
- **The mirrors** are two surfaces, so the copy into the bundle, about 1 ns a ray, counts half in each.
- Nothing is fused (no FMA), so that a number in any lane, on any processor, is the number of the scalar tracer to the last
  bit.
"""


def median_ns(lens: str, kind: str, lanes: str) -> float | None:
    """Nanoseconds a ray and surface of one bench, or None if it was not run."""
    folder = TOP / "target" / "criterion" / lens / kind / lanes / "new"
    try:
        estimates = json.loads((folder / "estimates.json").read_text())
        bench = json.loads((folder / "benchmark.json").read_text())
    except OSError:
        return None
    return estimates["median"]["point_estimate"] / bench["throughput"]["Elements"]


def timings() -> list[str]:
    lanes = [name for name in LANES if any(median_ns(lens, "f32", name) for lens in LENSES)]
    columns = [(kind, name) for kind in ("f64", "f32") for name in lanes]
    lines = ["| lens | " + " | ".join(f"{kind} {name}" for kind, name in columns) + " |"]
    lines.append("|---|" + "---:|" * len(columns))
    for lens in (*LENSES, LIMIT):
        cells = [median_ns(lens, kind, name) for kind, name in columns]
        lines.append(f"| {lens} | " + " | ".join("" if ns is None else f"{ns:.2f}" for ns in cells) + " |")
    return lines


def binary() -> Path:
    out = subprocess.run(
        [*BENCH, "--no-run"], cwd=TOP, capture_output=True, text=True, check=True, env=ENVIRONMENT
    ).stderr
    return TOP / re.search(r"\((\S*lens-\S+)\)", out)[1]


#: The kinds of instructions, by the beginnings of their names; the first that fits counts.
KINDS = (
    ("square roots", ("vsqrt", "sqrtp")),
    ("divisions", ("vdiv", "divp")),
    ("products", ("vmulp", "mulp")),
    ("sums", ("vaddp", "vsubp", "addp", "subp")),
    (
        "comparisons, logic",
        ("vcmp", "vand", "vxor", "vor", "vptest", "vtest", "vpcmp", "kor", "kand", "vpand", "vblend", "cmp", "test"),
    ),
    ("loads, stores, copies", ("vmov", "vbroadcast", "mov", "lea")),
)


def inner_loop(disassembly: str, number: str) -> list[str]:
    """Instructions of the smallest loop with two roots and two divisions of whole registers: the plain sphere's."""
    instructions = re.findall(r"^\s+([0-9a-f]+):\t(?:[0-9a-f]{2} )*\s*(\w+)([^\n]*)", disassembly, re.MULTILINE)
    places = {address: i for i, (address, _, _) in enumerate(instructions)}
    best: list[str] = []
    for i, (_, name, operands) in enumerate(instructions):
        target = re.search(r"\b([0-9a-f]+) <", operands)
        if not name.startswith("j") or not target or not 0 <= (first := places.get(target[1], i)) < i:
            continue
        names = [name for _, name, _ in instructions[first : i + 1]]
        roots = sum(name == f"vsqrtp{number}" for name in names)
        divisions = sum(name == f"vdivp{number}" for name in names)
        if roots == 2 and divisions == 2 and (not best or len(names) < len(best)):
            best = names
    return best


def mixes() -> list[str]:
    """The instruction mix of the inner loops, or nothing where they cannot be read."""
    if platform.machine() != "x86_64":
        return []
    try:
        text = subprocess.run(
            ["objdump", "-d", "--no-show-raw-insn", str(binary())], capture_output=True, text=True, check=True
        ).stdout
    except (OSError, subprocess.CalledProcessError):
        return []
    functions = re.split(r"\n(?=[0-9a-f]{16} <)", text)
    lines = [
        "| instructions for a register and surface | f64 AVX2 (4 rays) | f32 AVX2 (8 rays) | f64 AVX-512 (8) | f32 AVX-512 (16) |"
    ]
    lines.append("|---|---:|---:|---:|---:|")
    loops = []
    for level in ("avx2", "avx512"):
        bodies = "\n".join(f for f in functions if f"vectorize_{level}" in f.split("\n", 1)[0])
        loops += [inner_loop(bodies, number) for number in ("d", "s")]
    left = [list(loop) for loop in loops]
    for kind, prefixes in KINDS:
        counts = [sum(name.startswith(prefixes) for name in loop) for loop in left]
        left = [[name for name in loop if not name.startswith(prefixes)] for loop in left]
        lines.append(f"| {kind} | " + " | ".join(map(str, counts)) + " |")
    lines.append("| the rest | " + " | ".join(str(len(loop)) for loop in left) + " |")
    lines.append("| in all | " + " | ".join(str(len(loop)) for loop in loops) + " |")
    return lines


def main() -> int:
    began, page = time.monotonic(), str(PAGE.relative_to(TOP))
    # The last run's numbers keep its footer.
    is_run = "--no-run" not in sys.argv[1:]
    origin = pages.made(page) if is_run else pages.kept(page)
    if is_run:
        quick = ["--", "--quick"] if "--quick" in sys.argv[1:] else []
        subprocess.run([*BENCH, *quick], cwd=TOP, check=True, env=ENVIRONMENT)
        origin = origin.took(time.monotonic() - began)
    compiler = subprocess.run(["rustc", "--version"], capture_output=True, text=True, check=True).stdout.split(" (")[0]
    parts = [HEAD, f"Compiled by {compiler}.\n", "\n".join(timings()) + "\n"]
    if mix := mixes():
        parts.append(
            "The loop over a block at a sphere between two glasses, read off the disassembly (with the few that only\nnear-critical rays run):\n"
        )
        parts.append("\n".join(mix) + "\n")
    PAGE.write_text(pages.stamped("\n".join(parts) + READING, origin))
    print(f"petzval: wrote {page}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
