# SPDX-License-Identifier: GPL-3.0-or-later
"""The state of a page: the commits after the one in its footer that touch the sources that it measures."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from datetime import date
from pathlib import Path

from . import Made, Page, kept


@dataclass(frozen=True)
class State:
    """A page with its footer and the history since then."""

    page: Page
    #: The origin; None for a page without a footer.
    made: Made | None
    #: Short hash and subject of each commit since, the newest first; None if the footer's commit is not in this repository.
    since: tuple[str, ...] | None

    @property
    def is_stale(self) -> bool:
        """True if the page should be made again."""
        return self.since is None or len(self.since) > 0


def state(page: Page, root: Path) -> State:
    """The state of a page in a checkout."""
    origin = kept(page.file, root)
    if origin is None or not origin.commit or _git(root, "cat-file", "-e", f"{origin.commit}^{{commit}}") is None:
        return State(page, origin, None)
    said = _git(root, "log", "--format=%h %s", f"{origin.commit}..HEAD", "--", *page.measures)
    return State(page, origin, None if said is None else tuple(said.splitlines()))


def age(day: str, today: date) -> str:
    """Days since a date, in words."""
    days = (today - date.fromisoformat(day)).days
    return "today" if days <= 0 else f"{days} day" + ("s" if days > 1 else "")


def _git(root: Path, *arguments: str) -> str | None:
    """The output of git; None if it fails."""
    try:
        done = subprocess.run(["git", *arguments], cwd=root, capture_output=True, text=True, check=False)
    except OSError:
        return None
    return done.stdout if done.returncode == 0 else None
