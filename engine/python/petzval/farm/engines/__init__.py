# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that hand a job to a scheduler. Each scheduler is a module with `files(job) -> {name: text}`, for the job's folder; the folder may be
moved afterwards, so no file names the place where it is."""

from __future__ import annotations

import importlib

from ..job import Job

#: The kinds of files of each scheduler.
ENGINES = {
    "shell": "a shell script that renders all parts, one by one or several at a time",
    "slurm": "an array job for sbatch, the merge after it",
    "openjd": "a template of Open Job Description: Deadline Cloud, OpenCue, openjd run",
    "flamenco": "a job type for Flamenco 3",
    "dask": "a script for the workers of a Dask cluster",
}


def files(engine: str, job: Job) -> dict[str, str]:
    """The files of a scheduler, by their names in the job's folder."""
    written: dict[str, str] = importlib.import_module(f".{engine}", __name__).files(job)
    return written
