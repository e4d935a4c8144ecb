# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval farm run --local N`: the parts of a job in N processes of this machine, then the merge."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections import Counter, deque
from pathlib import Path

from .. import interrupts, processes
from ..errors import AGAIN, complain
from . import job as jobs

#: Tries after which a part is given up.
TRIES = 3
_POLL_S = 0.05
_INTERRUPTED = 130


def command(folder: Path, *words: str, blender: str | None = None, threads: int | None = None) -> list[str]:
    """The command of a step of a job, in this Python."""
    own = [sys.executable, "-m", "petzval", "farm", words[0], str(folder), *words[1:]]
    own += ["--blender", blender] if blender else []
    return own + (["--threads", str(threads)] if threads is not None else [])


def may_try_again(status: int) -> bool:
    """True if another try may help: the command says so, or was killed."""
    return status in (AGAIN, _INTERRUPTED) or processes.has_crashed(status)


def run(folder: Path, workers: int, *, blender: str | None, threads: int | None) -> int:
    """Renders all parts that are not finished, and merges; the exit status of the merge."""
    job = jobs.load(folder)
    if threads is None and workers > 1:
        threads = max((os.cpu_count() or 1) // workers, 1)
    due = deque(_dealt(job, [number for number in range(len(job.parts)) if not job.is_done(number)], workers))
    tries: Counter[int] = Counter()
    under_way: list[tuple[subprocess.Popen[bytes], list[int]]] = []
    asked = threading.Event()
    for number in interrupts.SIGNALS:
        signal.signal(number, lambda *_: asked.set())
    while (due or under_way) and not asked.is_set():
        while due and len(under_way) < workers:
            parts = due.popleft()
            own = command(folder, "part", *map(str, parts), blender=blender, threads=threads)
            # In a group of its own: Ctrl-C is handed on below, once.
            under_way.append((subprocess.Popen(own, stdin=subprocess.DEVNULL, **processes.own_group()), parts))
        for one in [one for one in under_way if one[0].poll() is not None]:
            under_way.remove(one)
            due.extend(_left(job, one[1], one[0].returncode, tries))
        asked.wait(_POLL_S)
    if asked.is_set():
        _end([process for process, _ in under_way])
        complain("broken off: the same command goes on from there")
        return _INTERRUPTED
    return subprocess.run(command(folder, "merge", blender=blender), stdin=subprocess.DEVNULL, check=False).returncode


def _dealt(job: jobs.Job, parts: list[int], workers: int) -> list[list[int]]:
    """Parts in a row for each worker, about the same work for all: a worker starts Blender once, and reads the scene of a frame once."""
    work = [end - first for first, end, _ in map(job.slots_of, parts)]
    hands: list[list[int]] = [[] for _ in range(workers)]
    done = 0
    for part, own in zip(parts, work, strict=True):
        hands[int(workers * (done + 0.5 * own) / sum(work))].append(part)
        done += own
    return [hand for hand in hands if hand]


def _left(job: jobs.Job, parts: list[int], status: int, tries: Counter[int]) -> list[list[int]]:
    """Parts that are to be tried again of those that a process took, each by itself: one that ends a process does not end the others' tries."""
    left = [part for part in parts if not job.is_done(part)]
    # The first of them is the one that failed; the others have had no try.
    tries.update(left[:1])
    again = []
    for place, part in enumerate(left):
        if place > 0 or (may_try_again(status) and tries[part] < TRIES):
            again.append([part])
        else:
            complain(f"part {part}: given up after {tries[part]} tries, with status {status}")
    return again


def _end(parts: list[subprocess.Popen[bytes]]) -> None:
    """Asks processes to keep their work, and to end."""
    for process in parts:
        processes.ask_to_end(process)
    began = time.monotonic()
    for process in parts:
        try:
            process.wait(max(60.0 - (time.monotonic() - began), 0.1))
        except subprocess.TimeoutExpired:
            process.kill()
