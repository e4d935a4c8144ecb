# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m figures [--size smallest|small|full|large] [--only KEY ...] [--keep] [--check]`, where petzval and bpy are, tools/ on the path.

Takes the photographs into output/figures, reads them, and writes docs/figures.md and its pictures; with --check or --only no page is
written, with --keep pictures rendered with the same wishes are not rendered again.
"""

from __future__ import annotations

import argparse
import importlib
import json
import pkgutil
import sys
import time
from pathlib import Path

import pages

from . import __path__ as here
from . import page
from .figure import Contradiction, Figure
from .photograph import ROOT, SIZES, Studio


def figures() -> list[Figure]:
    """All figures, in the order of the page."""
    names = sorted(one.name for one in pkgutil.iter_modules(here) if one.name.startswith("fig"))
    return [importlib.import_module(f"{__package__}.{name}").FIGURE for name in names if name != "figure"]


def main() -> int:
    asked = argparse.ArgumentParser(prog="figures", description="Photographs the figures, and checks them.")
    asked.add_argument("--size", choices=SIZES, default="full")
    asked.add_argument("--only", nargs="+", metavar="KEY", help="these alone; the page stays as it is")
    asked.add_argument("--keep", action="store_true", help="what was rendered with the same wishes")
    asked.add_argument("--check", action="store_true", help="write no page")
    asked.add_argument("--output", type=Path, help="a folder for photographs; default: output/figures/SIZE")
    options = asked.parse_args()
    folder = options.output or ROOT / "output" / "figures" / options.size
    studio = Studio(folder, options.size, again=not options.keep)
    chosen = figures()
    if options.only:
        unknown = set(options.only) - {one.key for one in chosen}
        if unknown:
            print(f"petzval: no figure {', '.join(sorted(unknown))}: there are {', '.join(one.key for one in chosen)}")
            return 2
        chosen = [one for one in chosen if one.key in options.only]
    wrong, chapters = [], []
    # Of photographs that were kept nobody knows the commit: the page stays as old as it was.
    start, origin = time.monotonic(), pages.kept("docs/figures.md") if options.keep else pages.made("docs/figures.md")
    for figure in chosen:
        began = time.monotonic()
        shots = [shot for shot in figure.shots if not (options.check and shot.is_only_shown)]
        taken = {shot.name: studio.take(shot) for shot in shots}
        try:
            caption = figure.read(taken)
        except Contradiction as error:
            wrong.append(f"{figure.key}: {error}")
            print(f"petzval: {figure.key}: {error}", file=sys.stderr, flush=True)
            caption = None
        else:
            print(f"petzval: {figure.key}: {' '.join(caption.sentences)}")
            (folder / f"{figure.key}.json").write_text(json.dumps(vars(caption), indent=1))
            chapters.append(page.chapter(figure, caption))
        if not options.check:
            target = folder if options.only or wrong else ROOT / "docs/images/figures"
            page.save(page.montage(figure, taken, folder), target / f"{figure.key}.jpg")
        print(f"petzval: {figure.key}: {time.monotonic() - began:.0f} s", flush=True)
    if wrong:
        return 1
    if not (options.only or options.check):
        if not options.keep:
            origin = origin.took(time.monotonic() - start)
        text = page.HEAD + "\n" + "\n".join(chapters)
        (ROOT / "docs/figures.md").write_text(pages.stamped(text, origin))
        print("petzval: wrote docs/figures.md")
    return 0


if __name__ == "__main__":
    sys.exit(main())
