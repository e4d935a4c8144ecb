# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender's Persistent Data keeps from one frame to the next: the last scene's trees."""

from __future__ import annotations

from typing import Any

import bpy

#: Scene, view layer, and the engine's scene: one at most, for it may be large.
_kept: tuple[str, str, Any] | None = None


def previous(depsgraph: bpy.types.Depsgraph) -> Any | None:
    """The engine's scene of the last frame of this view layer, where it was to be kept."""
    if not depsgraph.scene_eval.render.use_persistent_data:
        forget()
    if _kept is None or _kept[:2] != _names(depsgraph):
        return None
    return _kept[2]


def keep(depsgraph: bpy.types.Depsgraph, scene: Any) -> None:
    """Keeps the engine's scene for the next frame if the user asks for that."""
    global _kept
    if depsgraph.scene_eval.render.use_persistent_data:
        _kept = (*_names(depsgraph), scene)


def forget() -> None:
    """Gives the memory back."""
    global _kept
    _kept = None


def _names(depsgraph: bpy.types.Depsgraph) -> tuple[str, str]:
    return depsgraph.scene_eval.name, depsgraph.view_layer_eval.name
