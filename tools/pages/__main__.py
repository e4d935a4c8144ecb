# SPDX-License-Identifier: GPL-3.0-or-later
"""`python3 -m pages`, tools/ on the path: the generated pages, and the commits since each was made that touch the sources that it measures.

`python3 -m pages` lists them (`make pages`), `again [--only FILE ...]` remakes stale pages, one after the other (`make pages-again`), and
`stamp FILE` puts the footer under a page that was written just now.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Iterable
from datetime import date
from pathlib import Path

from . import PAGES, ROOT, Page, kept, made, stamp
from .history import State, age, state

#: Commits that are listed of a page.
LISTED = 5


def main() -> int:
    parser = argparse.ArgumentParser(prog="pages", description="Generated pages of docs/.")
    actions = parser.add_subparsers(dest="action")
    again_parser = actions.add_parser("again", help="remake stale pages")
    again_parser.add_argument("--only", nargs="+", metavar="FILE", help="of these pages")
    stamp_parser = actions.add_parser("stamp", help="put the footer under a page that was written just now")
    stamp_parser.add_argument("file")
    stamp_parser.add_argument("--began", type=float, metavar="SECONDS", help="since 1970, when its target began")
    options = parser.parse_args()
    named = getattr(options, "only", None) or ([options.file] if options.action == "stamp" else [])
    if unknown := [name for name in named if name not in PAGES]:
        print(f"pages: no generated page: {', '.join(unknown)}: see tools/pages/registry.py", file=sys.stderr)
        return 2
    if options.action == "stamp":
        origin = made(options.file)
        stamp(options.file, origin if options.began is None else origin.took(time.time() - options.began))
        return 0
    if options.action == "again":
        return again([PAGES[name] for name in options.only or PAGES], ROOT)
    print("\n".join(listing((state(page, ROOT) for page in PAGES.values()), date.today())))
    return 0


def listing(states: Iterable[State], today: date) -> list[str]:
    """A row for each page, and below it the commits since."""
    rows = []
    for one in states:
        origin = one.made
        source = "no footer"
        if origin is not None:
            changed = " with uncommitted changes" if origin.is_changed else ""
            source = f"{origin.commit or 'unknown commit'}{changed}  {origin.date}  {age(origin.date, today):>8}"
        rows.append(f"{one.page.file:<22}  {source}  {_said(one)}")
        since = one.since or ()
        rows += [f"    {commit}" for commit in since[:LISTED]]
        if len(since) > LISTED:
            rows.append(f"    and {len(since) - LISTED} more")
    return rows


def _said(one: State) -> str:
    if one.made is None:
        return "remake"
    if one.since is None:
        return "commit unknown here: remake"
    count = len(one.since)
    if not count:
        return "up to date"
    return f"{count} commits since touch what it shows" if count > 1 else "1 commit since touches what it shows"


def again(chosen: Iterable[Page], root: Path) -> int:
    """Runs the make targets of stale pages; 1 if one failed."""
    states = [state(page, root) for page in chosen]
    jobs: dict[tuple[str, ...], list[Page]] = {}
    for one in states:
        if one.is_stale:
            jobs.setdefault((one.page.target, *one.page.options), []).append(one.page)
    said, failed = [], False
    for i, (command, together) in enumerate(jobs.items(), 1):
        files = ", ".join(page.file for page in together)
        minutes = together[0].minutes
        usual = f", about {minutes:.0f} min" if minutes else ""
        print(f"pages: {i} of {len(jobs)}: make {' '.join(command)}: {files}{usual}", flush=True)
        began, before = time.monotonic(), made(together[0], root).commit
        status = subprocess.run([os.environ.get("MAKE", "make"), *command], cwd=root, check=False).returncode
        word = "made again" if status == 0 else f"FAILED with {status}"
        # A recipe that ends well and stamps nothing would leave the page stale for ever.
        heads = (before, made(together[0], root).commit)
        if status == 0 and not all((now := kept(page.file, root)) and now.commit in heads for page in together):
            status, word = 1, "FAILED: it keeps its old footer"
        failed = failed or status != 0
        said.append(f"{time.monotonic() - began:7.0f} s  {files}: {word}")
        print(f"pages: {said[-1].strip()}", flush=True)
    fresh = sum(not one.is_stale for one in states)
    print("\n".join(["", *said, f"{fresh} of {len(states)} pages were up to date"]), flush=True)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
