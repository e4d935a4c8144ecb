# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval farm part`: renders one part of a job. It can be broken off and goes on where it was, may run twice at once, and what is finished
is not rendered again."""

from __future__ import annotations

import time
from pathlib import Path

from .. import atomic_files
from ..errors import AGAIN, CommandError, complain
from . import job as jobs
from . import running


def render(
    folder: Path, number: int, *, blender: str | None, threads: int | None, again: bool, every_s: float | None = None
) -> int:
    """Renders the part; the exit status: 0 where it is finished, `AGAIN` or 130 where another try may help, else it cannot be."""
    job = jobs.load(folder)
    if number >= len(job.parts):
        raise CommandError(f"there is no part {number} in {folder}: they are numbered from 0 to {len(job.parts) - 1}")
    if job.is_done(number) and not again:
        print(f"part {number}: it is finished already")
        return 0
    running.pin_processor(job)
    running.check_machine(job)
    jobs.check_files(job)
    try:
        for place in (job.film(number), job.checkpoint(number)):
            place.parent.mkdir(exist_ok=True)
    except OSError as failed:
        complain(f"cannot write into {folder}: {failed.strerror or failed}")
        return AGAIN
    part = job.parts[number]
    began = time.monotonic()
    asked = {
        "what": "part", "frame": part.frame, "slots": list(job.slots_of(number)), "blender": job.blender,
        "film": str(job.film(number).absolute()), "checkpoint": str(job.checkpoint(number).absolute()), "agreement": str(job.agreement(part.frame).absolute()),
        "most_seconds": job.most_seconds, "most_memory_mb": job.most_memory_mb,
    }  # fmt: skip
    status, told = running.in_blender(
        blender, running.options_of(job, threads) | {"farm": asked, "checkpoint_every": every_s}
    )
    if told is None:
        return status or 1
    films = [Path(file) for file in told["films"]]
    seconds = time.monotonic() - began
    try:
        atomic_files.write_json(
            job.marker(number),
            {"part": number, "films": {one.name: one.stat().st_size for one in films}, "seconds": round(seconds, 3)},
        )
    except OSError as failed:
        complain(
            f"cannot write {job.marker(number)}: {failed.strerror or failed}: is there room, and may you write there"
        )
        return AGAIN
    print(f"part {number}: finished in {seconds:.1f} s")
    return 0
