# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval farm plan`: a scene becomes a job."""

from __future__ import annotations

import argparse
import shutil
import stat
import sys
from pathlib import Path
from typing import Any

from .. import atomic_files, render_command, scene_options
from ..errors import CommandError, complain
from . import engines, packing, running, sizes
from . import job as jobs
from .job import Job, Part

#: Folder of files that options name, inside of the job's.
_OPTION_FILES = "options"
_MOST_PARTS = 1_000_000


def plan(a: argparse.Namespace) -> tuple[int, Job | None]:
    """Makes the job's folder; the exit status, and the job if it is there."""
    folder = Path(a.output)
    options = scene_options.checked(a)
    picture = Path(a.picture) if a.picture else Path(f"{Path(a.scene).stem}.exr")
    render_command.check_picture(a, picture)
    if picture.name != str(picture):
        raise CommandError(
            f"--picture {picture}: it lies in the job's folder {jobs.PICTURES}: give a name without a folder"
        )
    if a.time_limit:
        raise CommandError(
            "--time-limit: parts that end by a clock do not make the whole: say --samples or --noise-threshold"
        )
    _check_new(folder)
    made = not folder.exists()
    (folder / jobs.SCENE).mkdir(parents=True, exist_ok=True)
    status, told, job = 1, None, None
    try:
        asked = {"farm": {"what": "pack", "target": str((folder / jobs.SCENE).absolute())}}
        status, told = running.in_blender(a.blender, options | asked | {"threads": None}, is_quiet=a.json)
        if told is not None:
            job = _job(a, folder, options, picture, told)
            _write(job, a.engines)
    finally:
        if job is None:
            shutil.rmtree(folder if made else folder / jobs.SCENE, ignore_errors=True)
    for warning in (told or {}).get("warnings", ()):
        complain(warning)
    return status, job


def _check_new(folder: Path) -> None:
    """Raises `CommandError` where a job cannot be made in a folder."""
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise CommandError(f"{folder}: it is there, and not empty: name a new folder")
    if not folder.absolute().parent.is_dir():
        raise CommandError(f"no such folder: {folder.absolute().parent}: make it first")


def _job(a: argparse.Namespace, folder: Path, options: dict[str, Any], picture: Path, told: dict[str, Any]) -> Job:
    from .. import _native

    count = a.parts
    if told["looks_at_all"] and count > 1:
        raise CommandError(
            "a noise threshold after denoising looks at the whole picture, so that it cannot be parted: turn After Denoising off in the "
            "sampling panel, or say --denoise off, --noise-threshold 0 or --parts 1"
        )
    if count > told["tiles"]:
        complain(f"the picture has {told['tiles']} tiles: so many parts are made, and not {count}")
        count = told["tiles"]
    frames = a.frames or [a.frame]
    if count * len(frames) > _MOST_PARTS:
        raise CommandError(f"{count * len(frames)} parts: at most {_MOST_PARTS}: change --parts or --frames")
    slots = sizes.slots_of(told["tiles"], count)
    cut = sizes.cut(slots, count)
    files = [f"{jobs.SCENE}/{name}" for name in told["files"]]
    kept: dict[str, Any] = {name: value for name, value in options.items() if name in jobs.option_names()}
    kept = {name: value for name, value in kept.items() if value is not None and value is not False and value != {}}
    for name in ("lens", "aperture_mask", "calibration"):
        if kept.get(name):
            copies = _copy(Path(kept[name]), folder / _OPTION_FILES / name)
            files += (names := [f"{_OPTION_FILES}/{name}/{one}" for one in copies])
            kept[name] = names[0]
    hashed = {}
    for name in files:
        file = jobs.inside(folder, name)
        # Others may read it, and nobody writes it again.
        file.chmod(stat.S_IMODE(file.stat().st_mode) | stat.S_IRUSR | stat.S_IRGRP | stat.S_IROTH)
        hashed[name] = (file.stat().st_size, jobs.digest_of(file))
    if a.frames:
        picture = Path(f"{picture.stem}_####{picture.suffix}") if "#" not in picture.stem else picture
    return Job(
        folder=folder,
        scene=f"{jobs.SCENE}/{told['scene']}",
        options=kept,
        picture=str(picture),
        engine=_native.__version__,
        processor=_processor(a.processor),
        system=sys.platform,
        blender=told["blender"],
        slots=slots,
        parts=tuple(Part(frame, first, end) for frame in frames for first, end in cut),
        most_seconds=a.max_seconds,
        most_memory_mb=a.max_memory,
        files=hashed,
        about={name: told[name] for name in ("width", "height", "samples", "seed")},
    )


def _processor(asked: str | None) -> str:
    from .. import _native

    if asked is None:
        return _native.PROCESSOR
    level = f"x86-64-{asked}"
    if level != _native.PROCESSOR and not running.has_engines():
        raise CommandError(
            f"--processor {asked}: the only engine that is installed here is for {_native.PROCESSOR}: leave it out"
        )
    return level


def _copy(file: Path, folder: Path) -> list[str]:
    """Copies a lens with its catalogues, or a picture, into a folder; names of the copies, the file's first."""
    files = packing.lens_files(str(file)) if file.suffix.lower() == ".lens" else [str(file)]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        return [Path(shutil.copyfile(one, folder / Path(one).name)).name for one in files]
    except OSError as failed:
        raise CommandError(f"cannot copy {file}: {failed.strerror or failed}") from None


def _write(job: Job, wanted: list[str]) -> None:
    """Writes job.json and the files of the schedulers that are asked for."""
    for name in (jobs.PARTS, jobs.WORK, jobs.PICTURES):
        (job.folder / name).mkdir(exist_ok=True)
    for engine in wanted:
        for name, text in engines.files(engine, job).items():
            atomic_files.write_text(job.folder / name, text)
            if name.endswith(".sh"):
                file = job.folder / name
                file.chmod(file.stat().st_mode | stat.S_IXUSR | stat.S_IXGRP | stat.S_IXOTH)
    # Last: with it the folder is a job.
    atomic_files.write_text(job.folder / jobs.NAME, job.text())
