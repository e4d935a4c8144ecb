# SPDX-License-Identifier: GPL-3.0-or-later
"""The record of each finished picture: a file of its own beside the pictures, written after all else."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from .. import atomic_files


@dataclass
class Record:
    """One picture of the data set."""

    key: str
    name: str
    camera: str
    frame: int
    time_s: float
    #: Camera to world, Blender's axes and units.
    pose: list[list[float]]
    metres_per_unit: float
    width: int
    height: int
    #: The intrinsics by `cameras.Intrinsics.as_json`; None where none were asked for.
    intrinsics: dict[str, Any] | None
    #: Distances of this picture's places, as the parameters project them, from the middles of their pixels, pixels: the median and the
    #: largest; None where either is not known.
    reprojection_px: list[float] | None = None
    #: Files by the kind of their content, relative to the folder of the data set, with their sizes.
    files: dict[str, str] = field(default_factory=dict)
    sizes: dict[str, int] = field(default_factory=dict)
    annotations: list[dict[str, Any]] = field(default_factory=list)
    points: list[list[float]] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)


def key_of(facts: Any) -> str:
    """A hash of all that decides a picture."""
    return hashlib.sha256(json.dumps(facts, sort_keys=True, default=str).encode()).hexdigest()


def hash_of_file(file: Path) -> str:
    """The hash of a file's content."""
    with file.open("rb") as opened:
        return hashlib.file_digest(opened, "sha256").hexdigest()


def _file(folder: Path, name: str) -> Path:
    return folder / "records" / f"{name}.json"


def write(folder: Path, record: Record) -> None:
    """Says that a picture is whole: after its files are."""
    record.sizes = {file: (folder / file).stat().st_size for file in record.files.values()}
    atomic_files.write_json(_file(folder, record.name), asdict(record))


def whole(folder: Path, name: str, key: str) -> Record | None:
    """The record of a picture that is there with all its files, made of the same; None: it has to be rendered."""
    try:
        record = Record(**json.loads(_file(folder, name).read_text(encoding="utf-8")))
        is_whole = all((folder / file).stat().st_size == size for file, size in record.sizes.items())
    except (OSError, ValueError, TypeError):
        return None
    return record if is_whole and record.key == key else None


def forget(folder: Path, name: str) -> None:
    """A picture that is rendered anew is not whole meanwhile."""
    _file(folder, name).unlink(missing_ok=True)
