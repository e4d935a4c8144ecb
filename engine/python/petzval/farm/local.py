# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval farm run --local N`: the parts of a job in processes of this machine, N at a time, then the merge."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections import deque
from pathlib import Path

from .. import interrupts, processes
from ..errors import AGAIN, complain
from . import job as jobs

#: A part is given up after so many tries.
TRIES = 3
_POLL_S = 0.05
_INTERRUPTED = 130


def command(folder: Path, *words: str, blender: str | None = None, threads: int | None = None) -> list[str]:
    """The command of a step of a job, in this Python."""
    own = [sys.executable, "-m", "petzval", "farm", words[0], str(folder), *words[1:]]
    own += ["--blender", blender] if blender else []
    return own + (["--threads", str(threads)] if threads is not None else [])


def may_try_again(status: int) -> bool:
    """Whether another try may help: the command says so, or was killed."""
    return status in (AGAIN, _INTERRUPTED) or processes.has_crashed(status)


def run(folder: Path, workers: int, *, blender: str | None, threads: int | None) -> int:
    """Renders all parts that are not finished, and merges; the exit status of the merge."""
    job = jobs.load(folder)
    if threads is None and workers > 1:
        threads = max((os.cpu_count() or 1) // workers, 1)
    due = deque((number, 1) for number in range(len(job.parts)) if not job.is_done(number))
    under_way: dict[int, tuple[subprocess.Popen[bytes], int]] = {}
    asked = threading.Event()
    for number in interrupts.SIGNALS:
        signal.signal(number, lambda *_: asked.set())
    while (due or under_way) and not asked.is_set():
        while due and len(under_way) < workers:
            part, tries = due.popleft()
            own = command(folder, "part", str(part), blender=blender, threads=threads)
            # In a group of its own: Ctrl-C is handed on below, once.
            under_way[part] = (subprocess.Popen(own, stdin=subprocess.DEVNULL, **processes.own_group()), tries)
        for part, (process, tries) in list(under_way.items()):
            status = process.poll()
            if status is None:
                continue
            del under_way[part]
            if status and may_try_again(status) and tries < TRIES:
                due.append((part, tries + 1))
            elif status:
                complain(f"part {part}: given up after {tries} tries, with status {status}")
        asked.wait(_POLL_S)
    if asked.is_set():
        _end([process for process, _ in under_way.values()])
        complain("broken off: the same command goes on from there")
        return _INTERRUPTED
    return subprocess.run(command(folder, "merge", blender=blender), stdin=subprocess.DEVNULL, check=False).returncode


def _end(parts: list[subprocess.Popen[bytes]]) -> None:
    """Asks processes to keep what they have, and to end."""
    for process in parts:
        processes.ask_to_end(process)
    began = time.monotonic()
    for process in parts:
        try:
            process.wait(max(60.0 - (time.monotonic() - began), 0.1))
        except subprocess.TimeoutExpired:
            process.kill()
