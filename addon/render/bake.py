# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake of one object: Blender lays out the points of its surface, the engine renders them, Blender writes the values to images."""

from __future__ import annotations

import dataclasses
from typing import Any

import bpy
import numpy as np

from petzval.description import BakeDescription, CameraDescription, DenoisingDescription, SettingsDescription

from ..data import denoiser, passes
from ..export import baking, denoising, memory, world
from ..export import camera as camera_export
from ..export import settings as render_settings
from ..export.report import Report
from ..native import engine
from . import loop, messages, staging

#: The camera of a scene without one.
_NOWHERE = CameraDescription("", tuple(tuple(float(i == j) for j in range(4)) for i in range(4)), "PINHOLE")
#: The kinds of bake that are denoised where pictures are.
_DENOISED = {"COMBINED", "SHADOW"}
#: Parts of the engine that a kind of bake keeps, at most: each is a film of its own.
_MOST_PARTS = 10


class Bake:
    """All images of one object. The scene is read once."""

    def __init__(self, host: bpy.types.RenderEngine, depsgraph: bpy.types.Depsgraph, holder: bpy.types.Object) -> None:
        self._host, self._depsgraph = host, depsgraph
        self.holder = holder
        self._scene = depsgraph.scene_eval
        self._report = Report()
        self._camera = self._find_camera()
        #: The prepared scenes; True: that of shadow catchers alone.
        self._stages: dict[bool, Any] = {}
        self._images = 0

    def image(self, kind: str, pass_filter: int, width: int, height: int) -> None:
        """Bakes one image. Raises `loop.Stopped` where the user stops it: then the image stays as it was."""
        native, self._images = engine(), self._images + 1
        # Blender knows the image by the layer's name.
        name = f"bake {self._images}"
        begun = self._host.begin_result(0, 0, width, height, layer=name)
        points = baking.points(begun.layers[0], width * height)
        self._host.end_result(begun, cancel=True)
        if (points.triangles < 0).all():
            return
        settings = render_settings.describe(self._scene, width, height)
        settings = render_settings.of_layer(settings, self._scene, self._depsgraph.view_layer_eval)
        film = native.film_bytes_a_pixel(surfaces=True, halves=settings.noise_threshold > 0.0, groups=_MOST_PARTS)
        memory.check_picture(self._scene.petzval.memory_limit, width, height, film, 16)
        described = baking.describe(
            self.holder, self._scene, kind, pass_filter, has_camera=self._scene.camera is not None
        )
        share = 0.5 if kind == "SHADOW" else 1.0
        job = self._job(described, points, settings, 0.0, share)
        alone = None
        if kind == "SHADOW":
            plain = BakeDescription(described.object_name, "COMBINED", described.from_camera)
            alone = self._job(plain, points, settings, share, share, only_catchers=True)
        self._deliver(name, job.baked(alone), width, height)

    def _job(
        self,
        described: BakeDescription,
        points: baking.Points,
        settings: SettingsDescription,
        done: float,
        share: float,
        *,
        only_catchers: bool = False,
    ) -> Any:
        """A finished job of the engine; a `share` of all the work, of which a part is done before."""
        is_shadow = only_catchers or described.kind == "SHADOW"
        scene = self._stage(settings, is_shadow=is_shadow, only_catchers=only_catchers)
        how = self._denoising(described.kind)
        job = engine().Job(
            scene,
            self._camera,
            dataclasses.replace(settings, denoising=None),
            occlusion_distance=world.occlusion_distance(self._scene.world),
            bake=(described, *points),
            parts=[] if how is None else denoising.guides(how),
        )
        tell = lambda part, _: self._host.update_progress(done + share * part)  # noqa: E731
        if loop.follow(job, stop_asked=self._stop_asked, show=lambda _: None, tell=tell):
            raise loop.Stopped
        if how is not None:
            loop.stoppable(lambda: job.denoise(how), self._stop_asked)
        return job

    def _denoising(self, kind: str) -> DenoisingDescription | None:
        """The denoising of a bake; None: not denoised. A bake is denoised, as in Cycles, where pictures of the view layer are."""
        if kind not in _DENOISED or not passes.is_denoised(self._scene, self._depsgraph.view_layer_eval):
            return None
        how = denoising.of_render(self._scene)
        if how is None and self._scene.cycles.is_property_set("use_denoising"):
            self._host.report({"WARNING"}, f"Not denoised: {denoiser.INSTALL}")
        return how and denoising.within_memory(how, self._scene.petzval.memory_limit)

    def _stage(self, settings: SettingsDescription, *, is_shadow: bool, only_catchers: bool) -> Any:
        """The engine's scene."""
        if only_catchers not in self._stages:
            builder = engine().SceneBuilder()
            size = camera_export.resolution(self._scene.render)
            baked = baking.Baked(self.holder, is_shadow)
            staging.fill(
                builder,
                self._depsgraph,
                self._camera,
                size,
                self._report,
                self._check_stop,
                only_catchers=only_catchers,
                baked=baked,
            )
            place = tuple(self.holder.matrix_world.translation)
            scene = loop.stoppable(lambda: builder.build(place, settings.threads, None), self._stop_asked)
            self._stages[only_catchers] = scene
            if not only_catchers:
                self._report.warnings += [*builder.warnings(), *scene.warnings()]
                for warning in messages.grouped(self._report.warnings):
                    self._host.report({"WARNING"}, warning)
        return self._stages[only_catchers]

    def _find_camera(self) -> CameraDescription:
        """The scene's camera without its lens: nodes may ask where it stands, and the surface may be seen from there."""
        if self._scene.camera is None:
            return _NOWHERE
        size = camera_export.resolution(self._scene.render)
        return camera_export.describe(self._scene.camera, self._scene, *size, Report(), model="PINHOLE")

    def _deliver(self, name: str, pixels: np.ndarray, width: int, height: int) -> None:
        result = self._host.begin_result(0, 0, width, height, layer=name)
        combined = result.layers[0].passes[passes.COMBINED.name]
        wanted = pixels[..., : combined.channels]
        combined.rect.foreach_set(np.ascontiguousarray(wanted, dtype=np.float32).reshape(-1))
        self._host.end_result(result)

    def _stop_asked(self) -> bool:
        return self._host.test_break() or loop.WATCH.stop.is_set()

    def _check_stop(self) -> None:
        if self._stop_asked():
            raise loop.Stopped
