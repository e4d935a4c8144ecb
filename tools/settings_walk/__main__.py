# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m settings_walk [--only PATTERN ...] [--samples N] [--looks N] [--page]`, tools/ on the path, by a Python with bpy's environment.

Changes every setting of a stage in Petzval and in Cycles, in jobs of their own, and writes docs/settings.md; with --only the page stays as it
is, and with --page it is written of the last findings of each setting, with the reasons and causes that known.toml has now. Exits with 1
where a setting has no answer.
"""

from __future__ import annotations

import argparse
import fnmatch
import json
import sys
import time
from pathlib import Path

import pages

from . import page
from .known import Known
from .walk import LOOKS, Row, rows, walked
from .worker import Worker

TOP = Path(__file__).resolve().parents[2]
PAGE = "docs/settings.md"
#: The file of the last results.
FOUND = TOP / "output" / "settings.json"
SAMPLES = 32


def main() -> int:
    asked = argparse.ArgumentParser(prog="settings_walk", description="Changes every setting in Petzval and in Cycles.")
    asked.add_argument(
        "--only", nargs="+", metavar="PATTERN", help="settings like 'scene.cycles.max_*'; the page stays as it is"
    )
    asked.add_argument("--samples", type=int, default=SAMPLES, help="of a pixel in the first look")
    asked.add_argument(
        "--looks", type=int, default=LOOKS, help="each with four times the samples, at what is left open"
    )
    asked.add_argument("--page", action="store_true", help="write the page of what was found last")
    options = asked.parse_args()
    known = Known()
    if options.page:
        found, origin = found_last(known), pages.kept(PAGE)
    else:
        began, made = time.monotonic(), pages.made(PAGE)
        found = all_settings(known)
        if options.only:
            found = [row for row in found if is_asked(row, options.only)]
        walked(found, known, options.samples, lambda line: print(line, flush=True), options.looks)
        origin = made.took(time.monotonic() - began)
    print(page.summary(found))
    keep(found)
    if not options.only:
        (TOP / PAGE).write_text(pages.stamped(page.text(found), origin), encoding="utf-8")
    unanswered = [row for row in found if not row.is_answered]
    for row in unanswered:
        print(f"settings: {row.owner}.{row.name}: {row.question}", file=sys.stderr)
    return 1 if unanswered else 0


def is_asked(row: Row, patterns: list[str]) -> bool:
    return any(fnmatch.fnmatchcase(f"{row.owner}.{row.name}", pattern) for pattern in patterns)


def all_settings(known: Known) -> list[Row]:
    first = Worker(1)
    settings = first.ask({"walk": known.values})
    first.close()
    if isinstance(settings, dict):
        raise SystemExit(f"settings: {settings['failed']}")
    return rows(settings, known)


def keep(found: list[Row]) -> None:
    """Keeps the findings, in the place of earlier ones of the same settings."""
    told = (
        {(one["owner"], one["name"]): one for one in json.loads(FOUND.read_text(encoding="utf-8"))}
        if FOUND.exists()
        else {}
    )
    told |= {(row.owner, row.name): {"owner": row.owner, "name": row.name, "found": row.found} for row in found}
    FOUND.parent.mkdir(exist_ok=True)
    FOUND.write_text(json.dumps(list(told.values()), indent=1) + "\n", encoding="utf-8")


def found_last(known: Known) -> list[Row]:
    """All settings with their findings."""
    told = {(one["owner"], one["name"]): one["found"] for one in json.loads(FOUND.read_text(encoding="utf-8"))}
    found = all_settings(known)
    for row in found:
        row.found = told.get((row.owner, row.name), [])
    return found


if __name__ == "__main__":
    sys.exit(main())
