# SPDX-License-Identifier: GPL-3.0-or-later
"""A step of a job that needs Blender, in this Python's bpy or in a Blender that is named."""

from __future__ import annotations

import json
import os
import sys
import tempfile
from pathlib import Path
from typing import Any

from .. import interrupts, processors, scene_options
from ..errors import CommandError
from . import job as jobs


def in_blender(
    blender: str | None, options: dict[str, Any], *, is_quiet: bool = False
) -> tuple[int, dict[str, Any] | None]:
    """The exit status of the step, and its answer, if it came to its end. It has printed its own errors. `is_quiet`: nothing that Blender
    says on stdout is seen."""
    sys.stdout.flush()
    out, voice = os.dup(1), os.dup(2)
    if is_quiet:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 1)
        os.close(nowhere)
    try:
        return _in_blender(blender, options)
    finally:
        # Blender's own words have taken the place of stderr.
        sys.stdout.flush()
        for kept, number in ((out, 1), (voice, 2)):
            os.dup2(kept, number)
            os.close(kept)


def _in_blender(blender: str | None, options: dict[str, Any]) -> tuple[int, dict[str, Any] | None]:
    with tempfile.TemporaryDirectory() as folder:
        answer = Path(folder) / "answer.json"
        options = options | {"answer": str(answer)}
        if blender:
            status = scene_options.in_blender(blender, options)
        else:
            interrupts.listen()
            from ..render_in_blender import render

            status = render(options)
        found = json.loads(answer.read_text(encoding="utf-8")) if answer.exists() else None
        return status, found


def options_of(job: jobs.Job, threads: int | None) -> dict[str, Any]:
    """The options of a step of a job, as `petzval render` has them after its checks."""
    parsed = vars(jobs.option_parser().parse_args([str(jobs.inside(job.folder, job.scene))]))
    options = {name: value for name, value in parsed.items() if name not in {"effect", "usage_error"}}
    options |= {"effects": {}, "scene": str(Path(os.path.abspath(jobs.inside(job.folder, job.scene))))}
    options |= job.options
    for name in ("lens", "aperture_mask", "calibration"):
        if options[name] is not None:
            options[name] = str(Path(os.path.abspath(jobs.inside(job.folder, options[name]))))
    return options | {"threads": threads}


def check_machine(job: jobs.Job) -> None:
    """Raises `CommandError` where this machine's engine would make other bits than those of the job."""
    from .. import _native

    if _native.__version__ != job.engine:
        raise CommandError(
            f"the job was planned with Petzval {job.engine}, and this is {_native.__version__}: install that version here"
        )
    if job.system != sys.platform:
        raise CommandError(
            f"the job was planned on {job.system}, and this is {sys.platform}, whose C library has other last digits: leave it to other machines"
        )
    if job.processor != _native.PROCESSOR:
        raise CommandError(
            f"the job is for engines of {job.processor}, and this machine's is for {_native.PROCESSOR}, whose last bits differ: leave it "
            f"to other machines, or plan the job with --processor v2"
        )


def pin_processor(job: jobs.Job) -> None:
    """Has the engine of the job's level loaded, before it is loaded, where the wheel has several."""
    if job.processor in processors.LEVELS and has_engines():
        os.environ[processors.WISH] = job.processor


def has_engines() -> bool:
    """True if this installation has engines for several levels of processors."""
    return not processors.has_one_engine() and bool(processors.engines())
