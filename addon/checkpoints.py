# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a render is kept while it goes on, and how it is known that a later one is of the same picture."""

from __future__ import annotations

import dataclasses
import hashlib
import os
from pathlib import Path
from typing import Any

import bpy

from . import loop
from .fingerprint import Watched, feed

#: From the end of one writing to the next: with the time of writing, less than ten seconds of work are lost.
EVERY_S = 8.0


def of(depsgraph: bpy.types.Depsgraph) -> Checkpoint | None:
    """That of a view layer; None where nothing is to be kept."""
    scene, layer = depsgraph.scene_eval, depsgraph.view_layer_eval
    asked = loop.WATCH.checkpoint
    if asked is None:
        if not scene.petzval.use_checkpoints:
            return None
        asked = str(_own_file(scene))
    if not asked:
        return None
    # Each layer has its own, and the only one has the name as it is.
    is_alone = sum(one.use for one in scene.view_layers) < 2
    return Checkpoint(asked if is_alone else f"{asked}.{_short(layer.name)}")


def _own_file(scene: bpy.types.Scene) -> Path:
    """A file for each scene of each .blend, among the user's own."""
    folder = bpy.utils.user_resource("DATAFILES", path=os.path.join("petzval", "checkpoints"), create=True)
    stem = Path(bpy.data.filepath).stem or "untitled"
    return Path(folder) / f"{stem}-{_short(bpy.data.filepath + scene.name)}.checkpoint"


def _short(text: str) -> str:
    return hashlib.blake2b(text.encode(), digest_size=6).hexdigest()


class Checkpoint:
    """The file of one render, and the fingerprint of all that the engine is told of it."""

    def __init__(self, file: str) -> None:
        self.file = file
        self._digest = hashlib.blake2b(digest_size=32)

    def watched(self, builder: Any) -> Watched:
        """The engine's `SceneBuilder`, all of whose calls leave their mark in the fingerprint."""
        return Watched(builder, self._digest)

    def arguments(self, settings: Any, camera: Any, *others: Any) -> tuple[str, str, float]:
        """The engine's `checkpoint` for a job of these settings, camera, and whatever else decides its picture."""
        # The number of threads does not; the lens's file does, by what it says.
        feed(self._digest, dataclasses.replace(settings, threads=0))
        lens = Path(camera.lens_path or "")
        feed(self._digest, (camera, lens.read_bytes() if lens.is_file() else None))
        feed(self._digest, others)
        every = EVERY_S if loop.WATCH.checkpoint_every_s is None else loop.WATCH.checkpoint_every_s
        return self.file, self._digest.hexdigest(), every
