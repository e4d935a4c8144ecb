#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables of docs/coatings.md: the reflectance of recipes and the transmittance in the middle of the shipped lenses, by the example
`coatings` of the optics crate, and T-numbers, by `petzval lens transmission`. Run by `make coatings` in an environment that has petzval,
with that example's path."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pages

ROOT = Path(__file__).resolve().parent.parent
PAGE = "docs/coatings.md"
HEAD = (
    "| lens | f-number | T, as its file has it | T, bare | T, MgF2 | T, triple "
    "| bare: 450 | 550 | 650 nm | MgF2: 450 | 550 | 650 nm |"
)


def petzval(*arguments: object) -> str:
    """The output of the command."""
    command = [sys.executable, "-m", "petzval", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"coatings: petzval {' '.join(map(str, arguments))}: {done.stderr.strip()}")
    return done.stdout


def t_number(folder: Path, lens: str, *coating: str) -> str:
    """T-number of a lens with a coating."""
    out = folder / "transmission.json"
    petzval("lens", "transmission", lens, *coating, "--fields", 0, "-o", out)
    return f"{json.loads(out.read_text())['t_number']:.2f}"


def lenses(parts: list[str], folder: Path) -> list[str]:
    """The table of lenses. `parts`: the rows of the example, with the light that arrives in the middle."""
    rows = [HEAD, "|---|" + "---:|" * (HEAD.count("|") - 2)]
    f_numbers = {entry["id"]: entry["f_number"] for entry in json.loads(petzval("lens", "list", "--json"))["lenses"]}
    for row in parts:
        lens, _, *arriving = (cell.strip() for cell in row.strip("|").split("|"))
        t_numbers = [t_number(folder, lens)]
        t_numbers += [t_number(folder, lens, "--coating", name) for name in ("none", "MgF2", "triple")]
        # The example has those of a triple layer, too.
        rows.append(f"| {lens} | {f_numbers[lens]:.2f} | {' | '.join([*t_numbers, *arriving[:6]])} |")
    return rows


def main() -> int:
    began, origin = time.monotonic(), pages.made(PAGE)
    said = subprocess.run([sys.argv[1]], capture_output=True, text=True, check=True).stdout
    recipes, parts = (table.splitlines() for table in said.strip().split("\n\n"))
    with tempfile.TemporaryDirectory() as name:
        table = lenses(parts[2:], Path(name))
    path = ROOT / PAGE
    text = pages.filled(path.read_text(encoding="utf-8"), "recipes", recipes)
    path.write_text(pages.filled(text, "lenses", table), encoding="utf-8")
    pages.stamp(PAGE, origin.took(time.monotonic() - began))
    print(f"petzval: wrote {PAGE}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
