# SPDX-License-Identifier: GPL-3.0-or-later
"""The files that a running render is kept in, and the test that a later render is of the same picture."""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import os
import time
from pathlib import Path
from typing import Any

import bpy

from petzval.description import CameraDescription, flat

from ..data.fingerprint import Pieces, Watched, feed
from ..export.stereo import View
from ..native import engine
from . import loop
from .persistent import KeptScene

#: Time from the end of one writing to the next, s: with the time of writing, less than ten seconds of work are lost.
EVERY_S = 8.0
#: Days after which a stopped render in the user's own folder is no longer resumed.
KEPT_DAYS = 30.0


def of(depsgraph: bpy.types.Depsgraph, view: View, *, is_part: bool) -> Checkpoint | None:
    """The checkpoint of a view of a view layer; None where nothing is to be kept, and the picture is no part of another one."""
    file = _file(depsgraph, view)
    is_part = is_part or loop.WATCH.share is not None
    return None if file is None and not is_part else Checkpoint(file)


def _file(depsgraph: bpy.types.Depsgraph, view: View) -> str | None:
    """The file in which the render of a view of a view layer is kept; None where it is not."""
    scene = depsgraph.scene_eval
    asked = loop.WATCH.checkpoint
    if asked is None:
        if not scene.petzval.use_checkpoints:
            return None
        asked = str(_own_file(scene))
    return of_view(asked, depsgraph, view) if asked else None


def of_view(file: str, depsgraph: bpy.types.Depsgraph, view: View) -> str:
    """The file of a view of a view layer: each has its own, and the only one has the name as it is."""
    scene, layer = depsgraph.scene_eval, depsgraph.view_layer_eval
    is_alone = sum(one.use for one in scene.view_layers) < 2
    of_layer = file if is_alone else f"{file}.{_short(layer.name)}"
    return of_layer if view.count < 2 else f"{of_layer}.{_short(view.name)}"


def _own_file(scene: bpy.types.Scene) -> Path:
    """A file for each scene of each .blend, among the user's own."""
    folder = Path(bpy.utils.user_resource("DATAFILES", path=os.path.join("petzval", "checkpoints"), create=True))
    stem = Path(bpy.data.filepath).stem or "untitled"
    own = folder / f"{stem}-{_short(bpy.data.filepath + scene.name)}.checkpoint"
    _remove_old(folder, own)
    return own


def _remove_old(folder: Path, own: Path) -> None:
    """Removes checkpoints in the user's own folder that no render has touched for `KEPT_DAYS`, but for this render's."""
    for file in folder.glob("*.checkpoint"):
        with contextlib.suppress(OSError):
            if file != own and time.time() - file.stat().st_mtime > KEPT_DAYS * 86_400.0:
                file.unlink()


def _short(text: str) -> str:
    return hashlib.blake2b(text.encode(), digest_size=6).hexdigest()


#: Settings that differ between parts of one picture.
_OF_A_PART = ("samples", "sample_offset", "seed", "threads")
#: Names of settings that say where a camera's lens is, and not which it is.
_PLACES = ("object_name", "lens_path", "lens.aperture_mask", "calibration", "calibration.path")
#: Characters of a value that is told as it is; of a longer one a short digest.
_LONGEST_VALUE = 40


class Checkpoint:
    """The fingerprint of all that the engine is told of one render, and the file in which it is kept, if it is."""

    def __init__(self, file: str | None) -> None:
        self.file = file
        self._scene = hashlib.blake2b(digest_size=32)
        self._told: Watched | None = None
        self._pieces: Pieces = {}

    def watched(self, scene: KeptScene) -> Watched:
        """The engine's `SceneBuilder`, all of whose calls leave their mark in the fingerprint or in those of its pieces."""
        self._told = Watched(scene.builder, self._scene, scene.fingerprints)
        return self._told

    def add(self, pieces: Pieces) -> None:
        """Adds the fingerprints of all images, materials and meshes, sent now or before."""
        self._pieces = dict(sorted(pieces.items()))
        for piece in self._pieces.items():
            feed(self._scene, piece)

    def pieces(self) -> dict[str, str]:
        """Short digests of the images, materials and meshes, by their names."""
        names = {} if self._told is None else self._told.names
        return {
            f"{kind} {index} '{names.get((kind, index), '')}'": digest.hex()[:16]
            for (kind, index), digest in self._pieces.items()
        }

    def fingerprint(self, settings: Any, camera: Any, *others: Any) -> str:
        """The fingerprint of a job of these settings, camera, and whatever else decides its picture."""
        digest = self._scene.copy()
        # The number of threads does not; the lens does, with the glasses of other files that it names, wherever it lies.
        feed(digest, dataclasses.replace(settings, threads=0))
        feed(digest, (_placeless(camera), _lens(camera), _calibration(camera)))
        feed(digest, _placeless(others))
        return digest.hexdigest()

    def arguments(self, fingerprint: str) -> tuple[str, str, float] | None:
        """The engine's `checkpoint` for a job of that fingerprint; None where the render is not kept."""
        if self.file is None:
            return None
        every = EVERY_S if loop.WATCH.checkpoint_every_s is None else loop.WATCH.checkpoint_every_s
        return self.file, fingerprint, every

    def picture(self, settings: Any, camera: Any, **others: Any) -> dict[str, str]:
        """The data that decide the picture, whichever of its samples are taken: names with short values or digests. Parts of one picture
        have the same."""
        told = {}
        for kind, whole, left_out in (("camera", camera, _PLACES), ("settings", settings, _OF_A_PART)):
            told |= {
                f"{kind}.{name}": _short_value(value) for name, value in flat(whole).items() if name not in left_out
            }
        digests = {
            "lens": _lens(camera),
            "calibration": _calibration(camera),
            "aperture mask": camera.lens.aperture_mask,
            **others,
        }
        return (
            {"scene": self._scene.hexdigest()[:16]} | {name: _digest(value) for name, value in digests.items()} | told
        )


def _placeless(value: Any) -> Any:
    """A value whose cameras do not say where their lenses lie."""
    if isinstance(value, CameraDescription):
        calibration = value.calibration and dataclasses.replace(value.calibration, path="")
        return dataclasses.replace(value, lens_path="", calibration=calibration)
    if isinstance(value, (tuple, list)):
        return [_placeless(one) for one in value]
    if isinstance(value, dict):
        return {name: _placeless(one) for name, one in value.items()}
    return value


def _lens(camera: Any) -> str | None:
    """All numbers of a camera's lens and its glasses, as text; None without a lens."""
    return engine().Lens(camera.lens_path).identity() if camera.lens_path else None


def _calibration(camera: Any) -> str | None:
    """A digest of a camera's file of calibrations; None without one, or where it cannot be read, which is said when the camera is made."""
    if camera.calibration is None:
        return None
    try:
        with open(camera.calibration.path, "rb") as file:
            return hashlib.file_digest(file, lambda: hashlib.blake2b(digest_size=16)).hexdigest()
    except OSError:
        return None


def _digest(value: Any) -> str:
    digest = hashlib.blake2b(digest_size=8)
    feed(digest, value)
    return digest.hexdigest()


def _short_value(value: Any) -> str:
    text = value if isinstance(value, str) else repr(value)
    return text if len(text) <= _LONGEST_VALUE and not {";", "="} & set(text) else _digest(value)
