# SPDX-License-Identifier: GPL-3.0-or-later
"""The answers that panels show and that take too long to find while they draw: a timer finds one once nothing has changed for a while, and
it is remembered by camera."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import bpy
from bpy.app.handlers import persistent

from .. import redraw

# So long nothing may have changed before it is looked again: less, and a slider that is dragged would stutter.
_QUIET_S = 0.3
# What takes long to find is looked for after so many times as long.
_QUIET_FOR_SLOW = 4.0
# While a render runs, until it is asked again.
_BUSY_S = 1.0
# One for each camera that was shown.
_REMEMBERED = 16

#: Told of every change of a scene.
_all: list[Lookout] = []


@dataclass
class _Kept:
    answer: Any
    asked: tuple
    revision: int


class Lookout:
    """Finds one thing out about cameras in their scenes: `find(camera object, scene, depsgraph)`; `asked(camera object, scene)` is all
    of the question but the scene's objects."""

    def __init__(
        self,
        find: Callable[[bpy.types.Object, bpy.types.Scene, bpy.types.Depsgraph], Any],
        asked: Callable[[bpy.types.Object, bpy.types.Scene], tuple],
    ) -> None:
        self.find, self._asked = find, asked
        self._kept: dict[tuple, _Kept] = {}
        self._wanted: tuple[str, str, tuple[str, str | None]] | None = None
        self._revision, self.changed_at, self.quiet_s = 0, 0.0, _QUIET_S
        # Blender knows a timer by its identity.
        self.timer = self._look

    def for_panel(
        self, holder: bpy.types.Object, scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer
    ) -> tuple[Any, bool] | None:
        """The remembered answer, and whether it is current; asks for a new one soon where there is none or it is out of date."""
        kept = self._kept.get((scene.name, holder.name_full))
        if redraw.is_rendering():
            # As for the lens's data: nothing is asked meanwhile.
            return None if kept is None else (kept.answer, False)
        is_current = kept is not None and kept.revision == self._revision and kept.asked == self._asked(holder, scene)
        if not is_current:
            library = holder.library.filepath if holder.library else None
            self._wanted = (scene.name, view_layer.name, (holder.name, library))
            if not bpy.app.timers.is_registered(self.timer):
                bpy.app.timers.register(self.timer, first_interval=self.quiet_s)
        return None if kept is None else (kept.answer, is_current)

    def forget(self) -> None:
        """Drops the remembered answers."""
        self._kept.clear()
        self._wanted, self.quiet_s = None, _QUIET_S

    def register(self) -> None:
        """Hears of changes from now on."""
        _all.append(self)

    def unregister(self) -> None:
        """Hears of none, and looks no more."""
        _all.remove(self)
        if bpy.app.timers.is_registered(self.timer):
            bpy.app.timers.unregister(self.timer)
        self.forget()

    def changed(self) -> None:
        """Something in a scene is another."""
        self._revision += 1
        self.changed_at = time.monotonic()

    def _look(self) -> float | None:
        """The timer; gives the seconds until it is to be called again."""
        wait = self.changed_at + self.quiet_s - time.monotonic()
        if wait > 0.0:
            return wait
        if bpy.app.is_job_running("RENDER"):
            return _BUSY_S
        wanted, self._wanted = self._wanted, None
        if wanted is not None:
            self._look_at(*wanted)
        return None

    def _look_at(self, scene_name: str, layer_name: str, holder_name: tuple[str, str | None]) -> None:
        # By name: what a timer keeps may have gone meanwhile.
        scene, holder = bpy.data.scenes.get(scene_name), bpy.data.objects.get(holder_name)
        layer = scene.view_layers.get(layer_name) if scene is not None else None
        depsgraph = layer.depsgraph if layer is not None else None
        if holder is None or holder.type != "CAMERA" or depsgraph is None:
            return
        began = time.monotonic()
        while len(self._kept) >= _REMEMBERED:
            del self._kept[next(iter(self._kept))]
        key = (scene.name, holder.name_full)
        self._kept[key] = _Kept(self.find(holder, scene, depsgraph), self._asked(holder, scene), self._revision)
        self.quiet_s = max(_QUIET_S, _QUIET_FOR_SLOW * (time.monotonic() - began))
        redraw.properties()


@persistent
def _scene_changed(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None) -> None:
    if depsgraph is None or depsgraph.mode == "VIEWPORT":
        for one in _all:
            one.changed()


@persistent
def _file_loaded(_file: str) -> None:
    for one in _all:
        one.forget()


_HANDLERS = (
    ("depsgraph_update_post", _scene_changed),
    ("frame_change_post", _scene_changed),
    ("load_post", _file_loaded),
)


def register() -> None:
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def unregister() -> None:
    for name, handler in _HANDLERS:
        handlers = getattr(bpy.app.handlers, name)
        if handler in handlers:
            handlers.remove(handler)
