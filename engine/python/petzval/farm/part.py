# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval farm part`: renders parts of a job, in one process. It can be broken off and goes on where it was, may run twice at once, and a
part that is finished is not rendered again."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..errors import AGAIN, CommandError, complain
from . import job as jobs
from . import running


def render(
    folder: Path,
    numbers: list[int],
    *,
    blender: str | None,
    threads: int | None,
    again: bool,
    every_s: float | None = None,
) -> int:
    """Renders parts, those of a frame one after another; the exit status: 0 where all are finished, `AGAIN` or 130 where another try may help,
    else one of them cannot be."""
    job = jobs.load(folder)
    due = []
    for number in dict.fromkeys(numbers):
        if number >= len(job.parts):
            raise CommandError(
                f"there is no part {number} in {folder}: they are numbered from 0 to {len(job.parts) - 1}"
            )
        if job.is_done(number) and not again:
            print(f"part {number}: it is finished already")
        else:
            due.append(number)
    if not due:
        return 0
    running.pin_processor(job)
    running.check_machine(job)
    jobs.check_files(job)
    try:
        for place in (job.film(due[0]), job.checkpoint(due[0])):
            place.parent.mkdir(exist_ok=True)
    except OSError as failed:
        complain(f"cannot write into {folder}: {failed.strerror or failed}")
        return AGAIN
    asked = {
        "what": "part", "blender": job.blender, "frames": _by_frame(job, due),
        "most_seconds": job.most_seconds, "most_memory_mb": job.most_memory_mb,
    }  # fmt: skip
    status, told = running.in_blender(
        blender, running.options_of(job, threads) | {"farm": asked, "checkpoint_every": every_s}
    )
    return 0 if told is not None else status or 1


def _by_frame(job: jobs.Job, numbers: list[int]) -> list[dict[str, Any]]:
    """The parts to render of each frame, with their files."""
    frames: dict[int | None, list[int]] = {}
    for number in numbers:
        frames.setdefault(job.parts[number].frame, []).append(number)
    files = {"film": job.film, "checkpoint": job.checkpoint, "marker": job.marker}
    return [
        {
            "frame": frame, "agreement": str(job.agreement(frame).absolute()),
            "parts": [
                {"number": number, "slots": list(job.slots_of(number))}
                | {name: str(of(number).absolute()) for name, of in files.items()}
                for number in of_frame
            ],
        }
        for frame, of_frame in frames.items()
    ]  # fmt: skip
