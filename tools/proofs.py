#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A proof of every shipped lens, checked: the table of docs/proofs.md. Run by `make proofs` in an environment that has petzval."""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pages

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/proofs.md"
HEAD = (
    "| lens | passes | stopped | undecided | columns | cells | prover s | checker s | followed | not confirmed |",
    "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|",
)


def petzval(*arguments: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "petzval", *map(str, arguments)], capture_output=True, text=True, check=False
    )


def row(lens: Path, options: argparse.Namespace, folder: Path) -> str:
    """The lens's row: shares of the fates, and the checker's result."""
    file = folder / "certificate.json"
    done = petzval("lens", "prove", lens, "-o", file, "--seconds", options.seconds, "--undecided", options.undecided)
    if done.returncode:
        why = done.stderr.strip().splitlines()[-1].removeprefix("petzval: ").partition(": ")[2]
        return f"| {lens.stem} | {why} | | | | | | | | |"
    found = json.loads(file.read_text())
    began = time.monotonic()
    checked = petzval("lens", "prove", lens, "--check", file, "--sample", options.sample)
    if checked.returncode:
        raise SystemExit(f"{lens.stem}: {checked.stderr}")
    words = checked.stdout.split("; ")[-1].split()
    followed, confirmed = int(words[0]), int(words[3])
    cells = sum(len(column[4]) for column in found["columns"])
    shares = " | ".join(f"{100 * found[key]:z.3f} %" for key in ("passes", "stopped", "undecided"))
    return (
        f"| {lens.stem} | {shares} | {len(found['columns'])} | {cells} | {found['seconds']:.0f} | "
        f"{time.monotonic() - began:.0f} | {followed} | {followed - confirmed} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="+", metavar="NAME", help="these lenses, printed and not written")
    parser.add_argument("--seconds", type=float, default=600.0, help="for each lens; default: 600")
    parser.add_argument("--undecided", type=float, default=0.001, help="default: 0.001")
    parser.add_argument("--sample", type=int, default=300, help="cells that the checker follows; default: 300")
    options = parser.parse_args()
    began, origin = time.monotonic(), pages.made("docs/proofs.md")
    lenses = sorted((ROOT / "lenses").glob("*.lens"))
    lenses = [lens for lens in lenses if not options.only or lens.stem in options.only]
    rows = list(HEAD)
    with tempfile.TemporaryDirectory() as folder:
        for lens in lenses:
            rows.append(row(lens, options, Path(folder)))
            print(rows[-1], flush=True)
    rows = [f"At most {options.seconds:g} s a lens, to leave {100 * options.undecided:g} %:", "", *rows]
    if not options.only:
        PAGE.write_text(pages.filled(PAGE.read_text(), "lenses", rows))
        pages.stamp("docs/proofs.md", origin.took(time.monotonic() - began))


if __name__ == "__main__":
    main()
