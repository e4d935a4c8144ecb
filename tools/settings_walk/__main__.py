# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m settings_walk [--only PATTERN ...] [--samples N] [--looks N]`, tools/ on the path, by a Python with bpy's environment.

Changes every setting of a stage in Petzval and in Cycles, in jobs of their own, and writes docs/settings.md; with --only the page stays as it
is. Exits with 1 where a setting has no answer.
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
from .walk import LOOKS, rows, walked
from .worker import Worker

TOP = Path(__file__).resolve().parents[2]
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
    options = asked.parse_args()
    began, made, known = time.monotonic(), pages.made("docs/settings.md"), Known()
    first = Worker(1)
    settings = first.ask({"walk": known.values})
    first.close()
    if isinstance(settings, dict):
        raise SystemExit(f"settings: {settings['failed']}")
    if options.only:
        settings = [
            one
            for one in settings
            if any(fnmatch.fnmatchcase(f"{one[0]}.{one[1]}", pattern) for pattern in options.only)
        ]
    found = rows(settings, known)
    walked(found, known, options.samples, lambda line: print(line, flush=True), options.looks)
    (TOP / "output").mkdir(exist_ok=True)
    kept = [{"owner": row.owner, "name": row.name, "verdict": row.verdict, "found": row.found} for row in found]
    (TOP / "output" / "settings.json").write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    print(page.summary(found))
    if not options.only:
        text = pages.stamped(page.text(found), made.took(time.monotonic() - began))
        (TOP / "docs" / "settings.md").write_text(text, encoding="utf-8")
    unanswered = [row for row in found if not row.is_answered]
    for row in unanswered:
        print(f"settings: {row.owner}.{row.name}: {row.question}", file=sys.stderr)
    return 1 if unanswered else 0


if __name__ == "__main__":
    sys.exit(main())
