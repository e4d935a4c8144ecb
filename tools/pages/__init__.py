# SPDX-License-Identifier: GPL-3.0-or-later
"""The generated pages of docs/: their names, the sources that each of them measures, and the line at a page's end that says where it came
from.

That line is the page's footer: the make target, the commit, the date, the machine and the time taken. `registry` lists the pages,
`history` finds the commits since then, `python3 -m pages` (tools/ on the path) prints them and remakes stale pages. Standard library only:
tools of any environment import this.
"""

from __future__ import annotations

import platform
import re
import subprocess
from datetime import date
from pathlib import Path
from typing import NamedTuple

from .registry import PAGES, Page

__all__ = [
    "PAGES",
    "ROOT",
    "Made",
    "Page",
    "build",
    "filled",
    "footer",
    "machine",
    "kept",
    "made",
    "provenance",
    "stamp",
    "stamped",
    "without_footer",
]

ROOT = Path(__file__).resolve().parents[2]
UNRECORDED = "machine not recorded"

_FOOTER = re.compile(
    r"\n+---\n\n\*(?:(?P<part>[A-Z][a-z ]*) made|Made) by `make (?P<target>[a-z-]+)` from (?:commit (?P<commit>[0-9a-f]{12})|an unknown commit)"
    r"(?P<changed> with uncommitted changes)? on (?P<date>\d{4}-\d\d-\d\d): (?P<machine>.+?)(?:, (?P<time>\d+ (?:s|min)))?\.\*\s*\Z"
)


class Made(NamedTuple):
    """The origin of a page."""

    target: str
    #: HEAD when it was made, 12 digits; empty outside of a checkout.
    commit: str
    #: Tracked files that the page measures differed from the commit.
    is_changed: bool
    date: str
    machine: str
    #: The time that the target ran, with its unit; empty if unknown.
    time: str = ""
    #: The generated part of a page that is otherwise written by hand: "Tables", "Pictures"; empty for the whole page.
    part: str = ""

    def took(self, seconds: float) -> Made:
        """The origin with the time that the target took."""
        return self._replace(time=f"{seconds:.0f} s" if seconds < 100.0 else f"{seconds / 60.0:.0f} min")


def machine() -> str:
    """The processor's model and the number of cores."""
    try:
        names = re.findall(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())
    except OSError:
        names = []
    if names:
        return f"{names[0]}, {len(names)} cores"
    return platform.processor() or platform.machine()


def build(root: Path = ROOT) -> str:
    """The make target that has built the engine of the checkout: `wheels`, with all optimisations, or `build`."""
    package = root / "engine" / "python" / "petzval"
    # One engine beside the package goes before those of a wheel, which an earlier build may have left.
    is_whole = (package / "_engines").is_dir() and not (package / "_native.abi3.so").exists()
    return "wheels" if is_whole else "build"


def made(page: Page | str, root: Path = ROOT) -> Made:
    """The origin of a page that is made now: to be asked for before it is measured, for meanwhile others may commit."""
    page = page if isinstance(page, Page) else PAGES[page]
    commit = _git(root, "rev-parse", "HEAD")[:12]
    changed = _git(root, "status", "--porcelain", "--untracked-files=no", "--", *page.measures) if commit else ""
    return Made(page.target, commit, bool(changed), str(date.today()), machine(), part=page.part)


def footer(origin: Made) -> str:
    """The footer as it stands at the end of a page."""
    subject = f"{origin.part} made" if origin.part else "Made"
    source = f"commit {origin.commit}" if origin.commit else "an unknown commit"
    source += " with uncommitted changes" if origin.is_changed else ""
    time = f", {origin.time}" if origin.time else ""
    return f"---\n\n*{subject} by `make {origin.target}` from {source} on {origin.date}: {origin.machine}{time}.*\n"


def without_footer(text: str) -> str:
    """A page's text before its footer."""
    return _FOOTER.sub("", text).rstrip() + "\n"


def stamped(text: str, origin: Made | None) -> str:
    """A page's text with this footer instead of the one that it has; None removes it."""
    return without_footer(text) + (f"\n{footer(origin)}" if origin else "")


def provenance(text: str) -> Made | None:
    """The origin in a page's footer; None without a footer."""
    found = _FOOTER.search(text)
    if not found:
        return None
    return Made(
        found["target"],
        found["commit"] or "",
        found["changed"] is not None,
        found["date"],
        found["machine"],
        found["time"] or "",
        found["part"] or "",
    )


def kept(page: str, root: Path = ROOT) -> Made | None:
    """The origin in the footer of the page on the disk: that of a page that is renewed in part, which stays the older one."""
    path = root / page
    return provenance(path.read_text(encoding="utf-8")) if path.exists() else None


def stamp(page: str, origin: Made, root: Path = ROOT) -> None:
    """Puts the footer under a page that has been written."""
    path = root / page
    path.write_text(stamped(path.read_text(encoding="utf-8"), origin), encoding="utf-8")


def filled(text: str, mark: str, rows: list[str]) -> str:
    """A page's text with these rows between the comments `<!-- MARK -->` and `<!-- end of MARK -->`."""
    begin, end = f"<!-- {mark} -->\n", f"<!-- end of {mark} -->"
    if text.count(begin) != 1 or text.count(end) != 1:
        raise SystemExit(f"pages: no place for {mark}")
    head, rest = text.split(begin)
    return head + begin + "".join(f"{row}\n" for row in rows) + end + rest.partition(end)[2]


def _git(root: Path, *arguments: str) -> str:
    """The output of git; empty where there is no checkout."""
    try:
        done = subprocess.run(["git", *arguments], cwd=root, capture_output=True, text=True, check=False)
    except OSError:
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""
