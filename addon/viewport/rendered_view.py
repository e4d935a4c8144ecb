# SPDX-License-Identifier: GPL-3.0-or-later
"""One 3D view in rendered shading: hands on Blender's events, and has the picture drawn."""

from __future__ import annotations

import dataclasses
import os
import traceback
import weakref
from collections.abc import Callable
from typing import Any

import bpy

from .. import redraw
from ..data import effects
from ..export import denoising
from ..export import settings as render_settings
from ..export.errors import ExportError
from ..export.kept import Changes
from ..export.report import Report
from ..native import EngineMissing, engine
from ..render import messages, staging
from . import view
from .screen import Screen
from .session import Session, Wanted
from .sync import SceneSync

#: Time between two looks for a new picture, s.
_LOOK_S = 0.04
#: The distance of a camera from the scene's origin, Blender units, beyond which that is set anew, for single precision's sake.
_FAR = 100.0


class RenderedView:
    """Belongs to a `RenderEngine` of a view for as long as that lives."""

    def __init__(self, host: bpy.types.RenderEngine) -> None:
        self._host = weakref.ref(host)
        self._native = engine()
        self._sync = SceneSync(self._native)
        self._screen = Screen()
        self._origin: tuple[float, float, float] | None = None
        # What went wrong, by what was done: an edit, or a look.
        self._told: dict[str, str] = {}
        self._drawn: Any = None
        self._timer = _timer_of(weakref.ref(self))
        self.session = Session(self._native)
        # Blender drops its engine, and with it this, where the view is left.
        weakref.finalize(self, self.session.close)

    def update(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        """The scene was changed, or is looked at for the first time."""
        self._guarded("edit", lambda: self._send(context, depsgraph))
        self._watch()

    def draw(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        """The region is to be drawn."""
        seen = self._guarded("look", lambda: self._look(context, depsgraph))
        picture = self.session.picture
        if seen is not None and picture is not None:
            self._screen.draw(self._host(), depsgraph.scene, picture, seen.frame)
        self._drawn = picture
        self._tell(depsgraph.scene)
        self._watch()

    def _send(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        place = tuple(context.region_data.view_matrix.inverted_safe().translation)
        self._sent(context, depsgraph, Changes.of(depsgraph), place if self._is_far(place) else self._origin)

    def _sent(
        self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph, changed: Changes, origin: tuple
    ) -> None:
        self._origin = origin
        draft = self._sync.update(depsgraph, changed, context.space_data, origin)
        if draft is not None:
            self.session.build(draft)

    def _is_far(self, place: tuple[float, float, float]) -> bool:
        return self._origin is None or max(abs(a - b) for a, b in zip(place, self._origin, strict=True)) > _FAR

    def _look(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> view.View | None:
        scene, report = depsgraph.scene_eval, Report()
        seen = view.of(context, depsgraph, self._pixel_size(scene), report)
        if seen is None:
            return None
        how = denoising.of_view(scene)
        settings = dataclasses.replace(
            render_settings.describe(scene, *seen.size, is_viewport=True),
            window=tuple(seen.window),
            threads=_threads(scene.render),
            blue_noise=False,
            independent_pixels=how is not None,
            sample_offset=0,
            # Light paths from lamps would know of no part of a picture, and of no other view.
            integrator="PATH",
        )
        start = scene.cycles.preview_denoising_start_sample if how else 1
        wanted = Wanted(seen.camera, settings, effects.wishes(scene.petzval), how, start)
        place = staging.place(seen.camera)
        # What is wished of the effects is measured from the scene's origin.
        if self._is_far(place) or (wanted.has_wishes and place != self._origin):
            self._sent(context, depsgraph, Changes(), place)
        self.session.look(wanted)
        for warning in report.warnings:
            self._sync.report.warn(warning)
        return seen

    def _pixel_size(self, scene: bpy.types.Scene) -> float:
        """The pixel size: Petzval's own where it was set, or Blender's, which may go by the screen."""
        if scene.petzval.is_property_set("preview_pixel_size"):
            return float(scene.petzval.preview_pixel_size)
        return float(self._host().get_preview_pixel_size(scene))

    def _guarded(self, what: str, work: Callable[[], Any]) -> Any:
        """The result of the work; an error is shown in the view until the same work succeeds."""
        try:
            found = work()
        except Exception as error:
            if not isinstance(error, (ExportError, EngineMissing, self._native.PetzvalError)):
                traceback.print_exc()
            self._told[what] = " ".join(str(error).split()) or type(error).__name__
            return None
        self._told.pop(what, None)
        return found

    @property
    def warnings(self) -> list[str]:
        """The warnings of the export and of the engine."""
        told = self._sync.report.warnings
        return [*told, *(one for one in self.session.warnings if one not in told)]

    def _tell(self, scene: bpy.types.Scene) -> None:
        picture, host = self.session.picture, self._host()
        if messages.keep_viewport(scene.name, self.warnings):
            redraw.properties()
        problem = next(iter(self._told.values()), self.session.error)
        if problem:
            host.update_stats("", problem)
        elif picture is None:
            host.update_stats("", "Building BVH")
        else:
            most = picture.wanted.settings.samples
            host.update_stats("", f"Sample {picture.samples}" + (f"/{most}" if most < 1 << 16 else ""))

    def _watch(self) -> None:
        if self.session.is_busy and not bpy.app.timers.is_registered(self._timer):
            bpy.app.timers.register(self._timer, first_interval=_LOOK_S)

    def poll(self) -> float | None:
        """Has the view drawn anew where there is something new; the seconds to the next look, None where nothing more is to come."""
        host = self._host()
        if host is None:
            self.session.close()
            return None
        # Asked before the picture, which may come in between.
        is_busy = self.session.is_busy
        if self.session.picture is not self._drawn or self.session.error:
            host.tag_redraw()
        return _LOOK_S if is_busy else None


def _threads(render: bpy.types.RenderSettings) -> int:
    """The number of threads by the scene's setting; else all but one, which Blender's window needs."""
    return render.threads if render.threads_mode == "FIXED" else max((os.cpu_count() or 1) - 1, 1)


def _timer_of(view: weakref.ref[RenderedView]) -> Callable[[], float | None]:
    """A function for Blender's timers, which know one by its identity and keep it alive."""

    def poll() -> float | None:
        found = view()
        return None if found is None else found.poll()

    return poll
