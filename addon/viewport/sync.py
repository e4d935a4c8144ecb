# SPDX-License-Identifier: GPL-3.0-or-later
"""Sends a scene that is edited to the engine: the first time all of it, then the changes."""

from __future__ import annotations

import hashlib
from typing import Any

import bpy

from .. import export
from ..data.fingerprint import Watched
from ..export.kept import Changes, Kept
from ..export.report import Report


class SceneSync:
    """The scene of a view, as the engine was last told."""

    def __init__(self, native: Any) -> None:
        self._native = native
        self._builder: Any = None
        self._kept: Kept | None = None
        self._of: tuple | None = None
        self._last: tuple | None = None
        #: The warnings of the export.
        self.report = Report()

    def update(
        self,
        depsgraph: bpy.types.Depsgraph,
        changed: Changes,
        space: bpy.types.SpaceView3D | None,
        origin: tuple[float, float, float],
    ) -> Any | None:
        """A `SceneDraft` of the scene as it is now; None where nothing has changed. `space`: the view whose own choice of objects counts.
        Raises `ExportError` and the engine's."""
        of = export.shared_settings(depsgraph, is_render=False)
        if of != self._of:
            self.forget()
            self._builder = self._native.SceneBuilder()
            self._kept, self._of = Kept(self._builder), of
        try:
            return self._tell(depsgraph, changed, space, origin)
        except BaseException:
            # Half of it was sent.
            self.forget()
            raise

    def _tell(self, depsgraph, changed, space, origin) -> Any | None:
        kept, digest = self._kept, hashlib.blake2b(digest_size=16)
        frame = depsgraph.scene_eval.frame_current
        changed.materials |= kept.behind(frame, of_view=True)
        kept.begin(changed, frame)
        # `Kept` counts pieces itself.
        kept.builder = Watched(self._builder, digest, pieces=None)
        export.send_scene(depsgraph, kept.builder, self.report, lambda: None, kept=kept, seen_in=space)
        kept.sweep()
        for warning in self._builder.warnings():
            self.report.warn(warning)
        told = digest.digest(), kept.changes, origin
        # The draft takes what was told, used or not.
        draft = self._builder.draft(origin)
        if told == self._last:
            return None
        self._last = told
        return draft

    def forget(self) -> None:
        """Begins anew."""
        self._builder = self._kept = self._of = self._last = None
        self.report = Report()
