# SPDX-License-Identifier: GPL-3.0-or-later
"""The data that Blender's Persistent Data keeps from one frame to the next: images, materials, meshes and trees."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import bpy

from .. import export
from ..data.fingerprint import Pieces
from ..export.kept import Changes, Kept
from ..export.report import Report
from ..export.stereo import View


@dataclass
class KeptScene:
    """The engine's builder of one view layer with all that it holds, and its last scene."""

    #: Names of the scene and the view layer.
    of: tuple[str, str]
    builder: Any
    kept: Kept
    #: The settings that all images, materials and meshes depend on; None where these cannot be kept.
    shared_settings: tuple | None
    #: The warnings of the export, of this frame or before.
    report: Report = field(default_factory=Report)
    fingerprints: Pieces = field(default_factory=dict)
    scene: Any = None

    def finish(self, place: tuple[float, float, float], threads: int) -> Callable[[], Any]:
        """A function that gives the engine's scene, and does not need Blender: the trees of the last one are refitted around moved
        objects."""
        if self.shared_settings is None:
            return lambda: self.builder.build(place, threads, self.scene)
        draft = self.builder.draft(place)
        return lambda: draft.build(threads, self.scene, is_final=True)


#: The last kept scene: one at most, for it may be large.
_last: KeptScene | None = None


def begin(depsgraph: bpy.types.Depsgraph, native: Any, view: View, *, is_still: bool, is_watched: bool) -> KeptScene:
    """The kept scene of the last frame or view of a view layer, without the pieces that have changed since; else an empty builder.
    `is_still`: of shapes nothing is sent but how they are now; `is_watched`: fingerprints are wanted. Nothing is kept until `keep`, for a
    render that is stopped has sent a part."""
    global _last
    last, _last = _last, None
    of = depsgraph.scene_eval.name, depsgraph.view_layer_eval.name
    is_persistent = depsgraph.scene_eval.render.use_persistent_data or view.count > 1
    # A limit of memory is held by counting what is sent.
    can_keep = is_persistent and is_still and not depsgraph.scene_eval.petzval.memory_limit
    settings = (export.shared_settings(depsgraph, is_render=True), is_watched) if can_keep else None
    last = last if is_persistent and last is not None and last.of == of else None
    # Between the views of a frame nothing changes.
    is_next_view = view.index > 0
    changes = Changes() if is_next_view else Changes.of(depsgraph)
    frame = depsgraph.scene_eval.frame_current
    behind = set() if last is None else last.kept.behind(frame, of_view=False)
    # What was warned of may be mended: only what is sent says so.
    may_be_mended = (
        last is not None and last.report.warnings and (changes.images or changes.shapes or changes.materials | behind)
    )
    if last is None or settings is None or last.shared_settings != settings or may_be_mended:
        builder = native.SceneBuilder()
        return KeptScene(of, builder, Kept(builder), settings, scene=last and last.scene)
    if not is_next_view and {key for key in last.kept.materials if key > 0} <= changes.materials:
        # A new graph calls everything changed but images, which may have changed before it was made.
        changes.images.update(key.image for key in last.kept.images)
    changes.materials |= behind
    last.kept.begin(changes, frame)
    return last


def keep(depsgraph: bpy.types.Depsgraph, view: View, now: KeptScene, scene: Any) -> None:
    """Keeps the engine's scene for the next view, and for the next frame if the user asks for that."""
    global _last
    if depsgraph.scene_eval.render.use_persistent_data or view.index + 1 < view.count:
        now.scene, _last = scene, now


def forget() -> None:
    """Gives the memory back."""
    global _last
    _last = None
