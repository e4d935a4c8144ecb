# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers of the instances of a scene, the same in all pictures of a data set, and their classes."""

from __future__ import annotations

import fnmatch
import json
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import atomic_files
from ..errors import CommandError
from .spec import ClassSpec

#: The largest number of 16-bit masks.
_MOST = 65535


class Instances:
    """The table of instances. It numbers each when it is first seen, from 1, and is kept beside the pictures."""

    def __init__(self, file: Path, of_scene: str, classes: tuple[ClassSpec, ...]) -> None:
        """`of_scene`: the hash of the scene whose table may be gone on with."""
        self._file, self._of_scene, self._classes = file, of_scene, classes
        self._numbers: dict[str, int] = {}
        self.rows: list[dict[str, Any]] = []
        #: Classes to which something of the scene belongs.
        self.met: set[str] = set()
        try:
            kept = json.loads(file.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return
        if kept.get("scene") == of_scene:
            self.rows = kept["instances"]
            self._numbers = {row["key"]: row["id"] for row in self.rows}

    def number(self, key: str, about: dict[str, Any]) -> int:
        """The number of an instance; `about` stands in its row: object, instancer, persistent_id."""
        found = self._numbers.get(key)
        if found is None:
            found = len(self.rows) + 1
            self._numbers[key] = found
            self.rows.append({"id": found, "key": key, **about})
        return found

    def classified(self, class_of: dict[str, ClassSpec | None]) -> None:
        """Names the class of each row, by the names of objects."""
        for row in self.rows:
            one = class_of.get(row["object"]) or class_of.get(row["instancer"] or "")
            row["class"], row["class_id"] = (one.name, one.id) if one is not None else (None, 0)

    def save(self) -> None:
        """Writes the table."""
        if len(self.rows) > _MOST:
            raise CommandError(
                f"the scene has {len(self.rows)} instances, and 16-bit masks tell {_MOST} apart: leave out instances"
            )
        atomic_files.write_json(self._file, {"scene": self._of_scene, "instances": self.rows}, indent=1)

    @property
    def category_of(self) -> dict[int, int]:
        """Numbers of classes by those of instances; 0: none."""
        return {row["id"]: row["class_id"] for row in self.rows}

    def classes_of(self, ids: npt.NDArray[np.uint16]) -> npt.NDArray[np.uint16]:
        """A mask of classes from one of instances."""
        table = np.zeros(len(self.rows) + 1, np.uint16)
        for number, category in self.category_of.items():
            table[number] = category
        return table[ids]


def class_of_object(one: Any, classes: tuple[ClassSpec, ...]) -> ClassSpec | None:
    """The first class that an object of Blender belongs to."""
    collections = [group.name for group in one.users_collection]
    materials = [slot.material.name for slot in one.material_slots if slot.material is not None]
    for made in classes:
        if (
            _any(made.objects, [one.name])
            or _any(made.collections, collections)
            or _any(made.materials, materials)
            or (made.pass_index is not None and one.pass_index == made.pass_index)
            or (made.property is not None and _has_property(one, *made.property))
        ):
            return made
    return None


def _any(patterns: tuple[str, ...], names: list[str]) -> bool:
    return any(fnmatch.fnmatchcase(name, pattern) for pattern in patterns for name in names)


def _has_property(one: Any, name: str, value: str) -> bool:
    return name in one and (not value or str(one[name]) == value)


def unmatched(objects: list[Any], made: ClassSpec) -> list[str]:
    """The conditions of a class that hold for nothing in the scene."""
    names = [one.name for one in objects]
    collections = [group.name for one in objects for group in one.users_collection]
    materials = [slot.material.name for one in objects for slot in one.material_slots if slot.material is not None]
    found = [
        f"{kind} '{pattern}'"
        for kind, patterns, there in (
            ("objects", made.objects, names), ("collections", made.collections, collections), ("materials", made.materials, materials),
        )
        for pattern in patterns
        if not _any((pattern,), there)
    ]  # fmt: skip
    if made.pass_index is not None and all(one.pass_index != made.pass_index for one in objects):
        found.append(f"pass-index {made.pass_index}")
    if made.property is not None and not any(_has_property(one, *made.property) for one in objects):
        found.append(f"property '{made.property[0]}'")
    return found
