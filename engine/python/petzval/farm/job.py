# SPDX-License-Identifier: GPL-3.0-or-later
"""The job: its folder, its file job.json, and the checks of both. Nothing in the file is executed, and no path in it leaves the folder."""

from __future__ import annotations

import argparse
import dataclasses
import hashlib
import json
import os
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

from ..effects import EFFECTS, WORDS
from ..errors import CommandError

#: The file of a job; another layout has another number.
NAME, FORMAT = "job.json", "petzval farm job 1"
#: The largest size of job.json; a million parts take less.
_MOST_BYTES = 256 << 20
_BLOCK = 1 << 20
#: Folders inside of a job's folder: its input, finished parts, parts under way, and pictures.
SCENE, PARTS, WORK, PICTURES = "scene", "parts", "work", "pictures"


@dataclass(frozen=True)
class Part:
    """A part: some slots of the tiles of a frame."""

    #: The frame; None: that of the .blend.
    frame: int | None
    #: The slot where the part begins, and the one before which it ends.
    first: int
    end: int


@dataclass(frozen=True)
class Job:
    """The content of job.json, checked."""

    folder: Path
    #: The .blend, relative to the folder.
    scene: str
    #: The options of `petzval render` by their names, as it has them after its checks; files are relative to the folder.
    options: dict[str, Any]
    #: The picture's name; of an animation with #### for the frame's number.
    picture: str
    engine: str
    #: The processor level that the engine was compiled for.
    processor: str
    #: Python's name of the operating system, whose C library computes sines and powers.
    system: str
    blender: str
    #: Slots into which the tiles of a picture are dealt.
    slots: int
    parts: tuple[Part, ...]
    #: The most that a part may take; None: no limit.
    most_seconds: float | None
    most_memory_mb: float | None
    #: Every file that a part reads, relative to the folder: its size and BLAKE2b.
    files: dict[str, tuple[int, str]]
    #: Facts for the user: size of the picture, samples, seed.
    about: dict[str, Any] = dataclasses.field(default_factory=dict)

    def slots_of(self, number: int) -> tuple[int, int, int]:
        """The tiles of a part, as the engine takes them."""
        part = self.parts[number]
        return part.first, part.end, self.slots

    def film(self, number: int) -> Path:
        """The file of a finished part; view layers have files of their own beside it."""
        return self.folder / PARTS / f"{number:04d}.film"

    def marker(self, number: int) -> Path:
        """The file that is there once a part is finished."""
        return self.folder / PARTS / f"{number:04d}.json"

    def checkpoint(self, number: int) -> Path:
        """The file in which a part is kept while it goes on."""
        return self.folder / WORK / f"{number:04d}.checkpoint"

    def agreement(self, frame: int | None) -> Path:
        """The file that says which scene the parts of a frame are of, so that none is rendered of another one."""
        return self.folder / WORK / f"{'still' if frame is None else frame}.scene"

    def is_done(self, number: int) -> bool:
        """True if a part is finished, and its files are there in their size. Whether they are whole is known when they are merged."""
        try:
            told = json.loads(self.marker(number).read_text(encoding="utf-8"))
            files = told["films"]
            return bool(files) and all(
                (self.folder / PARTS / _plain_name(name)).stat().st_size == size for name, size in files.items()
            )
        except (OSError, ValueError, KeyError, TypeError, AttributeError, CommandError):
            return False

    def frames(self) -> list[int | None]:
        """The frames, in the order of the parts."""
        return list(dict.fromkeys(part.frame for part in self.parts))

    def of_frame(self, frame: int | None) -> list[int]:
        """Numbers of the parts of a frame."""
        return [number for number, part in enumerate(self.parts) if part.frame == frame]

    def text(self) -> str:
        """job.json."""
        limits = {"seconds": self.most_seconds, "memory_mb": self.most_memory_mb}
        told = {
            "format": FORMAT, "scene": self.scene, "picture": self.picture, "options": self.options, "engine": self.engine,
            "processor": self.processor, "system": self.system, "blender": self.blender, "about": self.about, "limits": limits,
        }  # fmt: skip
        lines = [f"  {json.dumps(name)}: {json.dumps(value)}," for name, value in told.items()]
        parts = [json.dumps({"part": i, **dataclasses.asdict(part)}) for i, part in enumerate(self.parts)]
        files = [f"{json.dumps(name)}: {json.dumps(list(told))}" for name, told in self.files.items()]
        lines += [f'  "slots": {self.slots},']
        lines += ['  "parts": [\n    ' + ",\n    ".join(parts) + "\n  ],"]
        lines += ['  "files": {\n    ' + ",\n    ".join(files) + "\n  }"]
        return "{\n" + "\n".join(lines) + "\n}\n"


def load(folder: Path) -> Job:
    """The job of a folder. Raises `CommandError` where it is none, or not as it should be."""
    file = folder / NAME
    try:
        if file.stat().st_size > _MOST_BYTES:
            raise _wrong(file, "it is too long")
        told = json.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise CommandError(
            f"no job in {folder}: there is no {NAME}: name a folder that petzval farm plan made"
        ) from None
    except OSError as error:
        raise CommandError(f"cannot read {file}: {error.strerror or error}") from None
    except (ValueError, RecursionError):
        raise _wrong(file, "it is no JSON") from None
    if not isinstance(told, dict) or told.get("format") != FORMAT:
        raise CommandError(f"{file}: it is no '{FORMAT}': plan it again with this Petzval")
    try:
        return _read(folder, told)
    except (KeyError, TypeError, ValueError) as error:
        raise _wrong(file, f"{type(error).__name__}: {error}") from None


def _read(folder: Path, told: dict[str, Any]) -> Job:
    slots = _natural(told["slots"])
    parts = tuple(
        Part(None if one["frame"] is None else _integer(one["frame"]), _natural(one["first"]), _natural(one["end"]))
        for one in told["parts"]
    )
    if not parts or not all(part.first <= part.end <= slots for part in parts):
        raise ValueError("the parts are not of the slots")
    for frame in {part.frame for part in parts}:
        own = sorted((part.first, part.end) for part in parts if part.frame == frame)
        if [0, *(end for _, end in own)] != [*(first for first, _ in own), slots]:
            raise ValueError(f"the parts of frame {frame} do not make a whole")
    limits = told["limits"]
    job = Job(
        folder=folder,
        scene=_text(told["scene"]),
        options=_options(told["options"]),
        picture=_plain_name(_text(told["picture"])),
        engine=_text(told["engine"]),
        processor=_text(told["processor"]),
        system=_text(told["system"]),
        blender=_text(told["blender"]),
        slots=slots,
        parts=parts,
        most_seconds=_limit(limits["seconds"]),
        most_memory_mb=_limit(limits["memory_mb"]),
        files={_text(name): (_natural(size), _text(digest)) for name, (size, digest) in told["files"].items()},
        about=dict(told["about"]),
    )
    for name in (job.scene, *job.files):
        inside(folder, name)
    if job.scene not in job.files:
        raise ValueError("the scene is not among the files")
    for name in ("lens", "aperture_mask", "calibration"):
        given = job.options.get(name)
        if given is not None and given not in job.files:
            raise ValueError(f"{name} is not among the files")
    return job


def inside(folder: Path, name: str) -> Path:
    """A file of the job's folder by its name in job.json. Raises `CommandError` where that leads out of the folder."""
    path = PurePosixPath(name)
    is_plain = name == str(path) and not path.is_absolute() and not {"..", "."} & set(path.parts)
    if not is_plain or any(letter in name for letter in "\\:\0") or not path.parts:
        raise CommandError(f"{ascii(name)} in {folder / NAME}: it is no path inside of the job's folder")
    file, root = folder / path, os.path.realpath(folder)
    if os.path.commonpath([root, os.path.realpath(file)]) != root:
        raise CommandError(f"{file}: it leads out of the job's folder: put a copy in its place")
    return file


def _plain_name(name: str) -> str:
    """A file's name without a folder."""
    if not name or PurePosixPath(name).name != name or any(letter in name for letter in "\\:\0") or name in {".", ".."}:
        raise CommandError(f"{ascii(name)}: it is no name of a file")
    return name


def check_files(job: Job) -> None:
    """Raises `CommandError` where a file that the parts read is not as it was planned."""
    for name, (size, digest) in job.files.items():
        file = inside(job.folder, name)
        try:
            found = file.stat().st_size
            if found != size:
                raise CommandError(f"{file}: it has {found} bytes instead of {size}: copy the job's folder again")
            if digest_of(file) != digest:
                raise CommandError(f"{file}: it is not what was planned, or damaged: copy the job's folder again")
        except OSError as error:
            raise CommandError(f"{file}: {error.strerror or error}: copy the job's folder again") from None


def digest_of(file: Path) -> str:
    """BLAKE2b of a file."""
    digest = hashlib.blake2b(digest_size=20)
    with file.open("rb") as stream:
        while block := stream.read(_BLOCK):
            digest.update(block)
    return digest.hexdigest()


def option_parser() -> argparse.ArgumentParser:
    """The options of `petzval render` that a job may have."""
    from .. import render_command, scene_options

    parser = argparse.ArgumentParser(add_help=False)
    scene_options.add(parser)
    render_command.add_options(parser)
    return parser


#: Options that are of the machine, or that the job says otherwise.
_NOT_OF_A_JOB = {"scene", "blender", "frame", "threads", "time_limit", "help", "effect"}


def option_names() -> set[str]:
    """The names of the options that a job may have."""
    return {action.dest for action in option_parser()._actions} - _NOT_OF_A_JOB | {"effects"}


def _options(told: dict[str, Any]) -> dict[str, Any]:
    unknown = set(told) - option_names()
    if unknown:
        raise ValueError(f"unknown options: {', '.join(sorted(map(ascii, unknown)))}")
    effects = told.get("effects", {})
    if any(name not in EFFECTS or word not in WORDS for name, word in effects.items()):
        raise ValueError("the effects are none")
    for name, value in told.items():
        flat = (
            [part for one in value for part in (one if isinstance(one, list) else [one])]
            if isinstance(value, list)
            else [value]
        )
        if name != "effects" and not all(one is None or type(one) in (bool, int, float, str) for one in flat):
            raise ValueError(f"{ascii(name)} is no option's value")
    return told


def _integer(value: Any) -> int:
    if type(value) is not int or abs(value) > 1 << 30:
        raise ValueError(f"{ascii(value)} is no whole number")
    return value


def _natural(value: Any) -> int:
    if type(value) is not int or value < 0:
        raise ValueError(f"{ascii(value)} is no natural number")
    return value


def _limit(value: Any) -> float | None:
    if value is not None and (type(value) not in (int, float) or not 0.0 < value < 1e12):
        raise ValueError(f"{ascii(value)} is no limit")
    return None if value is None else float(value)


def _text(value: Any) -> str:
    if type(value) is not str:
        raise ValueError(f"{ascii(value)} is no text")
    return value


def _wrong(file: Path, what: str) -> CommandError:
    return CommandError(f"{file}: it is damaged, or no job: {what}: plan it again")
