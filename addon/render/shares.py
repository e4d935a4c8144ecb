# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of a picture that are rendered on several machines: their films, written and joined."""

from __future__ import annotations

import json
import os
import time
from pathlib import Path
from typing import Any

import bpy

from ..export.errors import ExportError
from ..export.stereo import View
from . import loop
from .checkpoints import Checkpoint, of_view

#: Tries and pauses of reading: another machine's file may be seen before it is whole.
_TRIES, _PAUSE_S = 20, 0.1
#: Pieces that are named.
_MOST_NAMED = 5


def for_job(share: loop.Share | None, part: loop.Part | None) -> dict[str, Any]:
    """The arguments of the engine's `Job` for a part, or for the joining of parts, which renders no tile."""
    if share is None:
        return {}
    return {"share": (0, 0, 1) if part is None else part.slots}


def agree(
    share: loop.Share, checkpoint: Checkpoint, fingerprint: str, depsgraph: bpy.types.Depsgraph, view: View
) -> None:
    """Raises `ExportError` where the scene is not the one of the part that came first: then the parts would not make one picture."""
    from petzval import atomic_files

    if not share.agreement:
        return
    file = of_view(share.agreement, depsgraph, view)
    pieces = checkpoint.pieces()
    try:
        try:
            atomic_files.create_text(Path(file), json.dumps({"fingerprint": fingerprint, "pieces": pieces}))
            return
        except FileExistsError:
            told = _read(file)
    except OSError as failed:
        share.problem = f"cannot write {file}: {failed.strerror or failed}"
        raise ExportError(share.problem) from None
    if told is None:
        os.replace(file, f"{file}.damaged")
        return agree(share, checkpoint, fingerprint, depsgraph, view)
    if told["fingerprint"] == fingerprint:
        return
    others = told["pieces"]
    differing = [name for name in dict.fromkeys([*others, *pieces]) if others.get(name) != pieces.get(name)]
    what = ", ".join(differing[:_MOST_NAMED]) or "lights, settings or places of objects"
    more = f" and {len(differing) - _MOST_NAMED} more" if len(differing) > _MOST_NAMED else ""
    raise ExportError(
        f"the scene is not the one of the parts before: {what}{more} differ: something in it is another in each process (a Bevel modifier, a texture of type "
        f"Noise), was simulated without a baked cache, or is missing on a machine; if the parts before are wrong, delete {file}"
    )


def _read(file: str) -> dict[str, Any] | None:
    """The content of the first part's file; None where it never became whole."""
    for _ in range(_TRIES):
        try:
            with open(file, encoding="utf-8") as stream:
                told = json.load(stream)
            if isinstance(told, dict) and isinstance(told.get("pieces"), dict) and "fingerprint" in told:
                return told
        except ValueError:
            pass
        time.sleep(_PAUSE_S)
    return None


def keep(
    share: loop.Share,
    part: loop.Part,
    job: Any,
    fingerprint: str,
    of: tuple[bpy.types.Depsgraph, View],
    beside: str = "",
) -> None:
    """Writes the film of a part that has ended. `beside`: the name of the render, where it is none of the picture but of something that the
    picture needs."""
    file = of_view(part.film, *of) + beside
    try:
        loop.stoppable(lambda: job.write_film(file, fingerprint + beside), lambda: False)
        part.written.append(file)
    except OSError as failed:
        share.problem = f"cannot write {file}: {failed.strerror or failed}"


def join(share: loop.Share, job: Any, fingerprint: str, of: tuple[bpy.types.Depsgraph, View], beside: str = "") -> None:
    """Joins the films of parts to a render that has ended. `beside` as in `keep`."""
    for part, file, slots in share.joined:
        own = of_view(file, *of) + beside
        refused = loop.stoppable(
            lambda own=own, slots=slots: job.join_film(own, fingerprint + beside, slots), lambda: False
        )
        if refused is None:
            share.taken += 1
        else:
            share.refused.setdefault(part, refused)
            share.is_whole = False


def is_last(depsgraph: bpy.types.Depsgraph, view: View) -> bool:
    """True if no other view layer or view follows in the picture, as far as that is known before its end."""
    # Of an evaluated scene the layer that is rendered comes first.
    used = [layer.name for layer in depsgraph.scene.view_layers if layer.use]
    return depsgraph.view_layer_eval.name == used[-1] and view.index + 1 == view.count
