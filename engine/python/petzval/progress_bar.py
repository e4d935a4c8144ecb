# SPDX-License-Identifier: GPL-3.0-or-later
"""One line on a terminal: the part that is done, and the time that the rest will take."""

from __future__ import annotations

import time
from typing import TextIO


class ProgressBar:
    """A progress bar: called with the part that is done, 0 to 1, and words on it; drawn no more often than can be read."""

    _WIDTH = 30
    _LEAST_SECONDS = 0.1

    def __init__(self, terminal: TextIO) -> None:
        self._terminal = terminal
        self._working_since: float | None = None
        self._drawn = 0.0
        self._last = ""

    def __call__(self, part: float, text: str) -> None:
        now = time.monotonic()
        if part > 0.0 and self._working_since is None:
            self._working_since = now
        if now - self._drawn < self._LEAST_SECONDS and part < 1.0:
            return
        self._drawn = now
        rest = ""
        if self._working_since is not None and part > 0.01:
            rest = f"{(now - self._working_since) * (1.0 - part) / part:.0f} s left"
        done = int(part * self._WIDTH)
        self._last = f"[{'#' * done}{'.' * (self._WIDTH - done)}] {part:4.0%}  {text}  {rest}"
        # Blender's own lines go to the same terminal: each time on a cleared line.
        self._terminal.write(f"\r\x1b[K{self._last}")
        self._terminal.flush()

    def end(self) -> None:
        """The line stays, and the next begins."""
        if self._last:
            self._terminal.write("\n")
            self._terminal.flush()
