# SPDX-License-Identifier: GPL-3.0-or-later
"""The memory, the open files and the threads of this process, as Linux counts them."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Footprint:
    """The footprint of a process at one moment."""

    memory_mb: float
    handles: int
    threads: int

    @classmethod
    def now(cls) -> Footprint:
        own = Path("/proc/self")
        pages = int((own / "statm").read_text().split()[1])
        handles, threads = (len(os.listdir(own / name)) for name in ("fd", "task"))
        return cls(pages * os.sysconf("SC_PAGE_SIZE") / 1e6, handles, threads)
