# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval farm merge`: joins the parts of a job that are there to its pictures, and names those that are missing."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from .. import atomic_files, frame_names
from ..errors import AGAIN, CommandError, complain
from . import job as jobs
from . import running

#: Parts that are named one by one; of more there is a count.
_MOST_NAMED = 20
#: The engine's words for a part that is of another picture: then it may be this machine that is wrong.
_OTHER_PICTURE = "another picture"


def merge(folder: Path, *, blender: str | None, threads: int | None, again: bool, as_json: bool) -> int:
    """Joins the parts that are there; returns the exit status: 0 where all pictures are whole, `AGAIN` where parts are missing."""
    job = jobs.load(folder)
    running.pin_processor(job)
    running.check_machine(job)
    jobs.check_files(job)
    (folder / jobs.PICTURES).mkdir(exist_ok=True)
    frames = [_frame(job, frame) for frame in job.frames()]
    due = [one for one in frames if one["parts"] and (again or not _is_merged(one))]
    refused: dict[int, str] = {}
    if due:
        asked = {"what": "merge", "blender": job.blender, "most_memory_mb": None, "frames": due}
        status, told = running.in_blender(blender, running.options_of(job, threads) | {"farm": asked}, is_quiet=as_json)
        if told is None:
            return status or 1
        refused = {int(part): why for one in told["frames"] for part, why in one["refused"].items()}
        taken = sum(one["taken"] for one in told["frames"])
        if refused and not taken and all(_OTHER_PICTURE in why for why in refused.values()):
            raise CommandError(
                "none of the parts is of the picture that this machine would make: merge where they were rendered, or render them again"
            )
        for part in refused:
            # So that it is rendered again without being asked to.
            job.marker(part).unlink(missing_ok=True)
        for one in due:
            one["parts"] = [part for part in one["parts"] if part[0] not in refused]
            atomic_files.write_json(_note(one), _parts_of(one))
    _tell(job, frames, refused, as_json=as_json)
    return 0 if not any(_missing(job, one) for one in frames) else AGAIN


def status(folder: Path, *, as_json: bool) -> int:
    """Says which parts are there; the exit status, as that of `merge`."""
    job = jobs.load(folder)
    frames = [_frame(job, frame) for frame in job.frames()]
    _tell(job, frames, {}, as_json=as_json)
    return 0 if not any(_missing(job, one) for one in frames) else AGAIN


def _frame(job: jobs.Job, frame: int | None) -> dict[str, Any]:
    """A frame's picture, and the parts of it that are there: number, film and slots."""
    name = Path(job.picture)
    picture = (
        job.folder
        / jobs.PICTURES
        / (name if frame is None or "#" not in name.stem else frame_names.numbered(name, frame))
    )
    numbers = job.of_frame(frame)
    there = [number for number in numbers if job.is_done(number)]
    parts = [(number, str(job.film(number).absolute()), list(job.slots_of(number))) for number in there]
    return {
        "frame": frame, "picture": str(picture.absolute()), "parts": parts, "is_whole": len(there) == len(numbers),
        "agreement": str(job.agreement(frame).absolute()),
    }  # fmt: skip


def _missing(job: jobs.Job, frame: dict[str, Any]) -> list[int]:
    there = {part[0] for part in frame["parts"]}
    return [number for number in job.of_frame(frame["frame"]) if number not in there]


def _note(frame: dict[str, Any]) -> Path:
    """The file that says which parts a picture was made of."""
    picture = Path(frame["picture"])
    return picture.with_name(f".{picture.name}.json")


def _parts_of(frame: dict[str, Any]) -> dict[str, Any]:
    """The parts of a picture, each with the time of its file."""
    return {
        "parts": {str(number): Path(film).with_suffix(".json").stat().st_mtime_ns for number, film, _ in frame["parts"]}
    }


def _is_merged(frame: dict[str, Any]) -> bool:
    """True if a frame's picture is made of just the parts that are there."""
    try:
        return Path(frame["picture"]).is_file() and json.loads(_note(frame).read_text(encoding="utf-8")) == _parts_of(
            frame
        )
    except (OSError, ValueError):
        return False


def _tell(job: jobs.Job, frames: list[dict[str, Any]], refused: dict[int, str], *, as_json: bool) -> None:
    """Prints the parts of each picture, and the command that renders each missing part."""
    missing = [number for one in frames for number in _missing(job, one)]
    if as_json:
        pictures = [
            {
                "picture": one["picture"],
                "frame": one["frame"],
                "parts": [part[0] for part in one["parts"]],
                "missing": _missing(job, one),
            }
            for one in frames
        ]
        print(
            json.dumps({"pictures": pictures, "missing": missing, "refused": {str(k): v for k, v in refused.items()}})
        )
        return
    for one in frames:
        there, of = len(one["parts"]), len(job.of_frame(one["frame"]))
        what = "whole" if there == of else f"{there} of {of} parts"
        print(f"{one['picture']}: {what}")
    for number in missing[:_MOST_NAMED]:
        why = f"{refused[number]}, so it must be rendered again" if number in refused else "it is not there yet"
        complain(f"part {number}: {why}: petzval farm part {job.folder} {number}")
    if len(missing) > _MOST_NAMED:
        complain(
            f"{len(missing) - _MOST_NAMED} more parts are missing: petzval farm status {job.folder} --json names them"
        )
