# SPDX-License-Identifier: GPL-3.0-or-later
"""Sends a scene that is edited to the engine: the first time all of it, then what changed."""

from __future__ import annotations

import hashlib
from typing import Any

import bpy

from .. import export
from ..data.fingerprint import Watched
from ..export import dicing
from ..export.kept import Changes, Kept
from ..export.report import Report

#: Calls of the builder that `Kept` counts itself.
_PIECES = frozenset(
    {"add_mesh", "add_curves", "add_points", "add_image", "add_material", "forget_mesh", "forget_image", "forget_material"}
)  # fmt: skip


class SceneSync:
    """What the engine was told of the scene that a view shows."""

    def __init__(self, native: Any) -> None:
        self._native = native
        self._builder: Any = None
        self._kept: Kept | None = None
        self._of: tuple | None = None
        self._last: tuple | None = None
        #: What could not be handed over.
        self.report = Report()

    def update(
        self,
        depsgraph: bpy.types.Depsgraph,
        changed: Changes,
        space: bpy.types.SpaceView3D | None,
        origin: tuple[float, float, float],
    ) -> Any | None:
        """A `SceneDraft` of the scene as it is now; None where it is what it was. `space`: the view whose own choice of objects counts.
        Raises `ExportError` and the engine's."""
        of = self._whole(depsgraph)
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
        kept.begin(changed)
        kept.builder = Watched(self._builder, digest, _PIECES)
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

    @staticmethod
    def _whole(depsgraph: bpy.types.Depsgraph) -> tuple:
        """What everything that was sent hangs on: where it changes, all is sent again."""
        layer = depsgraph.view_layer_eval
        cycles = getattr(depsgraph.scene_eval, "cycles", None)
        return (
            depsgraph.scene.session_uid,
            layer.name,
            layer.material_override,
            bpy.data.filepath,
            getattr(depsgraph.scene_eval, "cycles_curves", None) and depsgraph.scene_eval.cycles_curves.shape,
            depsgraph.scene_eval.render.hair_type,
            depsgraph.scene_eval.render.hair_subdiv,
            cycles is not None,
            dicing.of_scene(depsgraph.scene_eval, is_render=False),
        )
