# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m kernel_bounds`, tools/ on the path: proves the bounds by Gappa and writes their table into docs/proofs.md."""

from __future__ import annotations

import argparse
import re
import shutil
import sys

import pages

from .draws import drawn, largest_errors
from .evaluation import exactly
from .scripts import ROOT, Case, cases, failures, proved

PAGE = ROOT / "docs/proofs.md"
MEASURED = ROOT / "docs/numerics.md"
MISSING = "kernel_bounds: there is no gappa, which proves the bounds of the kernels: apt install gappa"


def measured(table: str, category: str) -> list[str]:
    """Worst / data of docs/numerics.md, in f64 and f32."""
    part = MEASURED.read_text(encoding="utf-8").partition(f"\n## {table}\n")[2].partition("\n## ")[0]
    (row,) = (line for line in part.splitlines() if line.startswith(f"| {category} |"))
    cells = [cell.strip() for cell in row.split("|")]
    return [cells[4], cells[7]]


def short(error: float) -> str:
    """Two digits; 0 for what the decimals alone have lost."""
    if error < 1e-9:
        return "0"
    return f"{error:.1f}" if error < 10 else f"{error:.0f}"


def in_words(text: str) -> str:
    """Powers of two as such."""
    powers = {f"{2.0**-n:.10f}".rstrip("0"): f"2^-{n}" for n in range(2, 11)} | {"0.5": "1/2", "0.0999": "0.1"}
    text = re.sub(r"0\.\d+", lambda found: powers.get(found[0], found[0]), text)
    return re.sub(
        r"2\^-(\d+)", lambda found: "2⁻" + found[1].translate(str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")), text
    )


def table(all_cases: list[Case]) -> list[str]:
    """The rows of the table: both precisions of a domain side by side."""
    rows = [
        "| kernel | domain | error, in u | f64 proved | f64 largest drawn | f32 proved | f32 largest drawn | worst / data, f64 | f32 |",
        "|---|---|---|---:|---:|---:|---:|---:|---:|",
    ]
    found: dict[tuple[str, str, str], dict[str, str]] = {}
    for case in all_cases:
        with exactly():
            errors = largest_errors(case, drawn(case))
        title, domain = case.head("title"), in_words(case.head("domain"))
        place, _, category = case.head("measured").partition(", ")
        for name, (_, of) in case.goals.items():
            row = found.setdefault((title, domain, f"{name}, {of}"), {})
            row[case.precision] = f"{case.claims[name]} | {short(errors[name])}"
            row["measured"] = (
                " | ".join(measured(place, category)) if name == place.lower().removesuffix("s") else " | "
            )
    for (title, domain, what), row in found.items():
        rows.append(
            f"| {title} | {domain} | {what} | {row.get('f64', ' | ')} | {row.get('f32', ' | ')} | {row['measured']} |"
        )
    return rows


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="kernel_bounds",
        description="Proves the bounds of the kernels' rounding errors by Gappa, into docs/proofs.md.",
    )
    parser.add_argument(
        "--only", nargs="+", metavar="KERNEL", help="these scripts of engine/proof/gappa; nothing is written"
    )
    parser.add_argument(
        "--best", action="store_true", help="print the bounds that Gappa finds by itself, and write nothing"
    )
    parser.add_argument("--print", metavar="CASE", help="print the script of a case, as --best names it, for gappa")
    parser.add_argument("--if-there", action="store_true", help="without gappa, say so and succeed")
    options = parser.parse_args()
    chosen = [case for case in cases() if not options.only or case.kernel in options.only]
    if options.print:
        named = [case for case in chosen if case.name == options.print]
        print(named[0].script() if named else f"kernel_bounds: there is no case {options.print}", end="")
        return 0 if named else 2
    if not shutil.which("gappa"):
        print(MISSING, file=sys.stderr)
        return 0 if options.if_there else 1
    if options.best:
        for case in chosen:
            print(f"{case.name}: " + ", ".join(f"{name} {bound}" for name, bound in proved(case).items()), flush=True)
        return 0
    if wrong := [line for case in chosen for line in failures(case)]:
        print("\n".join(f"kernel_bounds: {line}" for line in wrong), file=sys.stderr)
        return 1
    print(f"petzval: gappa proves the bounds of {len(chosen)} cases of kernels")
    if not options.only:
        PAGE.write_text(pages.filled(PAGE.read_text(encoding="utf-8"), "kernels", table(chosen)), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
