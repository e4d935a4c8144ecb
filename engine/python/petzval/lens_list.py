# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval lens list`: the lenses that come with Petzval."""

from __future__ import annotations

import argparse
import json
from typing import Any

from . import lens_library

_HEADINGS = ("lens", "mm", "f/ at infinity", "full field °", "film mm", "")


def add_parser(actions: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `list`."""
    parser = actions.add_parser("list", help="the lenses that come with Petzval, by groups", allow_abbrev=False)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Prints the list; returns the exit status."""
    entries = lens_library.entries()
    if arguments.json:
        print(json.dumps({"groups": lens_library.groups(), "lenses": entries}))
        return 0
    rows = {entry["id"]: _row(entry) for entry in entries}
    widths = [max(len(row[i]) for row in [_HEADINGS, *rows.values()]) for i in range(len(_HEADINGS))]
    print(_line(_HEADINGS, widths))
    sections = [("First choice", [entry for entry in entries if entry["is_first_choice"]])]
    for group in lens_library.groups():
        sections.append((group.capitalize(), [entry for entry in entries if entry["group"] == group]))
    sections.append(("Others", [entry for entry in entries if entry["group"] is None]))
    for title, members in sections:
        if members:
            print(f"\n{title}")
            for entry in members:
                print(_line(rows[entry["id"]], widths))
    return 0


def _row(entry: dict[str, Any]) -> tuple[str, ...]:
    texts = lens_library
    return (
        entry["id"],
        texts.focal_text(entry),
        texts.f_number_text(entry),
        texts.field_text(entry),
        texts.film_text(entry),
        entry["name"],
    )


def _line(cells: tuple[str, ...], widths: list[int]) -> str:
    """Names to the left, numbers to the right."""
    sides = "<>>><<"
    return "  ".join(f"{cell:{side}{width}}" for cell, side, width in zip(cells, sides, widths, strict=True)).rstrip()
