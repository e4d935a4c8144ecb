# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that a .blend reads, copied into a job's folder, where Blender is.

The files keep their places relative to one another: their common folder becomes the job's folder `scene`. So relative paths lead where they
led, also inside of linked libraries, and a .blend is copied byte by byte. One that names files by absolute paths is saved with relative ones.
"""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ..description import INSTALLED_LENSFUN

#: Kinds of datablocks whose files no render reads.
_UNREAD = {"Sound", "Text", "Library"}
#: Settings of a camera that name files of which Blender knows nothing: its lens, its calibration.
_OF_CAMERA = ("lens_file", "calibration_file")
#: The first bytes of a compressed .blend, and the last (zstd_seekable_compression_format.md: Seekable_Magic_Number).
_ZSTANDARD, _SEEKABLE = b"\x28\xb5\x2f\xfd", b"\xb1\xea\x92\x8f"
#: Bytes of a block's header, at most (BHead in Blender's DNA: 32 since Blender 5).
_MOST_OF_A_HEADER = 32
#: A disk cache's folder beside the .blend, by the .blend's name.
_DISK_CACHE = "blendcache_{}"


def open_blend(bpy: Any, file: str) -> None:
    """Opens a .blend. Raises `OSError` with Blender's reason."""
    try:
        bpy.ops.wm.open_mainfile(filepath=file, load_ui=False, use_scripts=False)
    except RuntimeError as failed:
        raise OSError(f"{file}: {_reason(failed)}") from None


def save_blend(bpy: Any, file: str, **options: Any) -> None:
    """Saves a copy of the open .blend, with its paths as they are; `options` as `save_as_mainfile` has them. Raises `OSError` with Blender's reason."""
    try:
        bpy.ops.wm.save_as_mainfile(filepath=file, copy=True, relative_remap=False, check_existing=False, **options)
    except RuntimeError as failed:
        raise OSError(f"{file}: {_reason(failed)}") from None
    if not _is_whole(file):
        raise OSError(f"{file}: it could not be written to its end: is the disk full?")


def _is_whole(file: str) -> bool:
    """True of a .blend that ends as Blender ends one: with the block ENDB, or compressed with the table of a seekable Zstandard file. Blender says
    nothing of a compressed file that the disk had no room for."""
    with open(file, "rb") as read:
        begin = read.read(7)
        size = read.seek(0, os.SEEK_END)
        read.seek(max(0, size - _MOST_OF_A_HEADER))
        end = read.read()
    return end.endswith(_SEEKABLE) if begin.startswith(_ZSTANDARD) else b"ENDB" in end


def _reason(failed: RuntimeError) -> str:
    """The text of an operator's error, in one line."""
    return " ".join(str(failed).removeprefix("Error: ").split())


class _File:
    """A path that a .blend names."""

    def __init__(self, path: str, *, is_sequence: bool) -> None:
        self.path = os.path.normpath(path)
        self.is_sequence = is_sequence

    def files(self) -> list[str]:
        """The files that it stands for: one, all of a folder, all pictures of a sequence or all tiles of a UDIM."""
        folder, name = os.path.split(self.path)
        if os.path.isdir(self.path):
            return sorted(os.path.join(at, one) for at, _, names in os.walk(self.path) for one in names)
        if "<UDIM>" in name or "<UVTILE>" in name:
            pattern = re.escape(name).replace("<UDIM>", r"\d{4}").replace("<UVTILE>", r"u\d+_v\d+")
            return self._matching(folder, pattern)
        if self.is_sequence and (digits := list(re.finditer(r"\d+", name))):
            last = digits[-1]
            pattern = rf"{re.escape(name[: last.start()])}-?\d+{re.escape(name[last.end() :])}"
            return self._matching(folder, pattern)
        return [self.path] if os.path.isfile(self.path) else []

    @staticmethod
    def _matching(folder: str, pattern: str) -> list[str]:
        if not os.path.isdir(folder):
            return []
        found = (os.path.join(folder, one) for one in sorted(os.listdir(folder)) if re.fullmatch(pattern, one))
        return [one for one in found if os.path.isfile(one)]


class Packer:
    """Packs the .blend that is open."""

    def __init__(self, bpy: Any, scene_file: str) -> None:
        self._bpy = bpy
        self._main = os.path.normpath(scene_file)
        #: The .blends, and all other files; in the order in which they were found.
        self._blends: dict[str, bool] = {}
        self._files: dict[str, None] = {}
        self.warnings: list[str] = []

    def pack(self, target: Path) -> tuple[str, list[str]]:
        """Copies everything into `target`; names of the .blend and of all files, relative to it. Those of .blends come first. Another .blend is open
        afterwards, where there are libraries. Raises `OSError`."""
        self._collect(self._main)
        libraries = {
            self._absolute(one.filepath, one.parent) for one in self._bpy.data.libraries if not self._is_packed(one)
        }
        for library in sorted(libraries):
            if not os.path.isfile(library):
                self.warnings.append(f"no such library: {library}: what is linked from it is missing in the picture")
                continue
            open_blend(self._bpy, library)
            self._collect(library)
        every = [*self._blends, *self._files]
        try:
            root = os.path.commonpath([os.path.dirname(one) for one in every])
        except ValueError:
            raise OSError("its files are on several drives: put them on one") from None
        names = {one: os.path.relpath(one, root).replace(os.sep, "/") for one in every}
        self._check_case(names)
        for file, name in names.items():
            place = target / name
            place.parent.mkdir(parents=True, exist_ok=True)
            if self._blends.get(file):
                self._save_relative(file, place)
            else:
                shutil.copyfile(file, place)
        return names[self._main], list(names.values())

    def _collect(self, blend: str) -> None:
        """Notes the files of the .blend that is open."""
        self._blends[blend] = self._has_absolute_paths()
        for one in self._named():
            found = one.files()
            if not found and not os.path.isdir(one.path):
                self.warnings.append(f"no such file: {one.path}: it is missing in the picture")
            self._files |= dict.fromkeys(file for file in found if file not in self._blends)
        cache = os.path.join(os.path.dirname(blend), _DISK_CACHE.format(Path(blend).stem))
        self._files |= dict.fromkeys(_File(cache, is_sequence=False).files() if os.path.isdir(cache) else [])

    def _named(self) -> Iterator[_File]:
        """The paths that the .blend that is open names, those of linked data left to their library."""
        for block, paths in self._bpy.data.file_path_map(include_libraries=False).items():
            if block.library is not None or type(block).__name__ in _UNREAD or self._is_packed(block):
                continue
            is_sequence = getattr(block, "source", "") in {"SEQUENCE", "TILED"} or getattr(block, "is_sequence", False)
            for path in paths:
                yield _File(self._absolute(path, None), is_sequence=is_sequence)
        for camera in self._bpy.data.cameras:
            if camera.library is None:
                lens, calibration = (self._file_of(camera, name) for name in _OF_CAMERA)
                own = [*lens_files(lens), *([calibration] if calibration else [])]
                yield from (_File(one, is_sequence=False) for one in own)

    def _file_of(self, camera: Any, name: str) -> str:
        """A file that a camera's setting names; empty where it is a lens that comes with Petzval, or none."""
        chosen = getattr(camera.petzval, name).strip()
        if name == "calibration_file" and (chosen == INSTALLED_LENSFUN or os.path.isdir(self._absolute(chosen, None))):
            self.warnings.append(
                f"camera '{camera.name}': the lensfun database '{chosen}' is not packed, and other machines may have another one: name one "
                ".xml file of it"
            )
            return ""
        path = self._absolute(chosen, None) if chosen else ""
        return path if path and os.path.isfile(path) else ""

    def _has_absolute_paths(self) -> bool:
        paths = self._bpy.data.file_path_map(include_libraries=True).items()
        own = [path for block, paths in paths if block.library is None and not self._is_packed(block) for path in paths]
        own += [one.filepath for one in self._bpy.data.libraries if one.parent is None]
        cameras = [camera.petzval for camera in self._bpy.data.cameras if camera.library is None]
        own += [getattr(camera, name) for camera in cameras for name in _OF_CAMERA]
        return any(os.path.isabs(path) and not path.startswith("//") for path in own)

    def _save_relative(self, file: str, place: Path) -> None:
        """Saves a .blend with relative paths to the same files."""
        open_blend(self._bpy, file)
        self._bpy.ops.file.make_paths_relative()
        for camera in self._bpy.data.cameras:
            for name in _OF_CAMERA if camera.library is None else ():
                if os.path.isabs(own := self._file_of(camera, name)):
                    setattr(camera.petzval, name, self._bpy.path.relpath(own, start=os.path.dirname(file)))
        save_blend(self._bpy, str(place))

    def _absolute(self, path: str, library: Any) -> str:
        return os.path.normpath(str(self._bpy.path.abspath(path, library=library)))

    @staticmethod
    def _is_packed(block: Any) -> bool:
        return getattr(block, "packed_file", None) is not None or bool(getattr(block, "packed_files", ()))

    @staticmethod
    def _check_case(names: dict[str, str]) -> None:
        """Raises `OSError` where two files would be one in a folder that does not tell upper from lower case."""
        seen: dict[str, str] = {}
        for file, name in names.items():
            if (other := seen.setdefault(name.casefold(), file)) != file:
                raise OSError(f"{file} and {other} differ by upper and lower case alone: rename one")


def lens_files(lens: str) -> list[str]:
    """A lens file with the catalogues of glasses that it names, which lie beside it."""
    if not lens:
        return []
    try:
        text = Path(lens).read_text(encoding="utf-8", errors="replace")
    except OSError:
        return [lens]
    names = re.findall(r"^#\s*catalogue:\s*(\S+)\s*$", text, flags=re.MULTILINE)
    beside = [os.path.join(os.path.dirname(lens), name) for name in names if os.path.basename(name) == name]
    return [lens, *(file for file in dict.fromkeys(beside) if os.path.isfile(file))]
