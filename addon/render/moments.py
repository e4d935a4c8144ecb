# SPDX-License-Identifier: GPL-3.0-or-later
"""Camera and scene at other moments of one picture: while the shutter is open, a frame before and a frame after."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import bpy

from petzval.description import CameraDescription, Matrix4, ShutterDescription, changed

from ..export import camera as camera_export
from ..export import shutter as shutters
from ..export import stereo, velocity
from ..export.motion import Frame, Motion
from ..export.report import Report
from . import loop

# Pictures of a lens that changes while the shutter is open: enough for changes of a few f-stops, or of a focus pull
# across a scene, to look smooth.
_SHUTTER_STEPS = 16


class Moments:
    """The dependency graph of one picture, moved to other frames and back."""

    def __init__(
        self,
        host: bpy.types.RenderEngine,
        depsgraph: bpy.types.Depsgraph,
        view: stereo.View,
        report: Report,
        check_stop: Callable[[], None],
    ) -> None:
        """`check_stop` raises `loop.Stopped` if the user stops the render."""
        self.host = host
        self.depsgraph = depsgraph
        self.view = view
        self.report = report
        self.check_stop = check_stop

    @property
    def scene(self) -> bpy.types.Scene:
        """The scene at the graph's frame."""
        return self.depsgraph.scene_eval

    def over_the_shutter(
        self, shutter: shutters.Shutter | None, camera: CameraDescription, width: int, height: int
    ) -> tuple[shutters.Blur | None, ShutterDescription | None, list[CameraDescription]]:
        """Everything at its keys, how the shutter opens, and the camera at even times while it is open: none of these where the
        lens does not change meanwhile."""
        if shutter is None:
            return None, None, []
        eye = self.eye()
        count = max(shutters.most_keys(self.depsgraph, eye and eye.holder), 3)
        blur, keys = shutters.Blur(self.report, shutter.length * velocity.frame_s(self.scene)), []

        mask = {"lens.aperture_mask": camera.lens.aperture_mask}

        def describe() -> CameraDescription:
            return changed(self.described(width, height), mask)

        def look(_: int) -> None:
            self.check_stop()
            keys.append(describe())
            blur.read(self.depsgraph)

        def look_at_lens(_: int) -> None:
            moving.append(dataclasses.replace(describe(), matrix_world=camera.matrix_world))

        moving: list[CameraDescription] = []
        try:
            shutters.sweep(shutter, count, self.frame_set, look)
            if any(dataclasses.replace(key, matrix_world=camera.matrix_world) != camera for key in keys):
                half = 0.5 * shutter.length / _SHUTTER_STEPS
                between = shutters.Shutter(shutter.begin + half, shutter.length - 2.0 * half)
                shutters.sweep(between, _SHUTTER_STEPS, self.frame_set, look_at_lens)
        finally:
            self.frame_set(*shutters.split(shutter.middle))
        return blur, self._opened(keys), moving

    def _opened(self, keys: list[CameraDescription]) -> ShutterDescription:
        """The opening of the shutter, and the camera's matrices at its keys."""
        eye = self.eye()
        own = 0 if eye is None else shutters.key_count(eye.holder)
        matrices = [key.matrix_world for key in keys[:: (len(keys) - 1) // (own - 1)]] if own else []
        if matrices.count(matrices[0] if matrices else None) == len(matrices):
            matrices = []
        rolling = shutters.rolling(self.scene)
        if rolling is not None and self.scene.petzval.integrator == "BIDIRECTIONAL":
            self.report.warn(
                f"Scene '{self.scene.name}': bidirectional paths know of no rolling shutter, all rows are open at once"
            )
            rolling = None
        return ShutterDescription(shutters.openness(self.scene.render), rolling, matrices)

    def beside(
        self, camera: CameraDescription, width: int, height: int, *, is_asked: bool
    ) -> tuple[tuple[CameraDescription, CameraDescription] | None, Motion | None]:
        """The camera and everything else a frame before and a frame after, where the Vector pass asks for it."""
        # Blender's rule: with motion blur the pass is all zero.
        if self.scene.render.use_motion_blur or not is_asked:
            return None, None
        now, subframe = self.scene.frame_current, self.scene.frame_subframe
        asked = loop.WATCH.beside

        def at(frame: float, matrix: Matrix4 | None) -> tuple[CameraDescription, Frame]:
            self.check_stop()
            self.frame_set(*shutters.split(frame))
            then = self.described(width, height)
            moved = {} if matrix is None else {"matrix_world": matrix}
            return changed(then, {"lens.aperture_mask": camera.lens.aperture_mask, **moved}), Frame.read(self.depsgraph)

        both = [(now + subframe + step, None) for step in (-1, 1)]
        if asked is not None:
            both = [(one.frame, one.camera_matrix) for one in asked]
        try:
            (first, before), (last, after) = (at(*one) for one in both)
        finally:
            self.frame_set(now, subframe)
        return (first, last), Motion(before, after, velocity.frame_s(self.scene), self.report)

    def eye(self) -> stereo.Eye | None:
        """The camera that sees the view in the graph's frame."""
        return stereo.eye_of_render(self.host, self.scene, self.view)

    def described(self, width: int, height: int) -> CameraDescription:
        """The camera as the engine takes it, without an aperture mask."""
        eye = self.eye()
        holder = self.scene.camera if eye is None else eye.holder
        return camera_export.describe(holder, self.scene, width, height, self.report, eye=eye)

    def frame_set(self, frame: int, subframe: float) -> None:
        """Moves the graph to a frame."""
        self.host.frame_set(frame, subframe)
