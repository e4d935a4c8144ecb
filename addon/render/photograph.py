# SPDX-License-Identifier: GPL-3.0-or-later
"""One render of one view of a view layer: the order of reading, the arguments of the engine, and the messages meanwhile."""

from __future__ import annotations

import dataclasses
import functools
import json
import time

import bpy
import numpy as np

from petzval.description import (
    DenoisingDescription,
    SettingsDescription,
    focused,
)

from ..data import denoiser, effects, passes, process_memory, settings_version
from ..export import camera as camera_export
from ..export import denoising, sampling, stereo
from ..export import settings as render_settings
from ..export import shutter as shutters
from ..export import world as world_export
from ..export.report import Report
from ..native import engine
from . import checkpoints, loop, messages, persistent, planning, progress, raw, shares, staging, statistics
from .moments import Moments
from .results import Results, deliver_black, region

# Samples: with fewer, the time that a forecast takes would be seen.
_WORTH_A_FORECAST = 1 << 21
# The part of the stray light before which a guess of the rest of the time is worth nothing.
_LEAST_PART = 0.02


class Photograph:
    """One render of one view of a view layer, from the dependency graph to the last tile."""

    def __init__(
        self,
        host: bpy.types.RenderEngine,
        depsgraph: bpy.types.Depsgraph,
        view: stereo.View = stereo.ONLY,
        said: set[str] | None = None,
    ) -> None:
        """`said`: the warnings of the views before, which are not said again."""
        self.host = host
        self.said = set() if said is None else said
        self.depsgraph = depsgraph
        self.view = view
        self.report = Report()
        self.moments = Moments(host, depsgraph, view, self.report, self._check_stop)
        self.results = Results(host, depsgraph, view)
        self.focus: dict | None = None
        # What takes the picture, in a line.
        self.camera = ""
        self.plan = None
        # What the plan tells, and the same in a line for the status.
        self.told: dict = {}
        self.samples = 0
        self.planned = ""
        # The part of the time that denoising is to take.
        self.denoise_share = 0.0

    @property
    def scene(self) -> bpy.types.Scene:
        """The scene at the graph's frame."""
        return self.depsgraph.scene_eval

    def take(self) -> None:
        """Takes the photograph; `loop.Stopped` if the user stops it first."""
        shutter = shutters.of(self.scene, self.depsgraph.view_layer_eval)
        now = self.scene.frame_current + self.scene.frame_subframe
        if shutter is None or shutter.middle == now:
            return self._take(shutter)
        # As in Cycles, everything is taken as it is in the middle of the exposure.
        try:
            self.moments.frame_set(*shutters.split(shutter.middle))
            self._take(shutter)
        finally:
            self.moments.frame_set(*shutters.split(now))

    def _take(self, shutter: shutters.Shutter | None) -> None:
        native = engine()
        self._tell("Reading the scene", 0.0)
        for warning in settings_version.warnings():
            self._warn(warning)
        began = time.perf_counter()
        width, height = camera_export.resolution(self.scene.render)
        eye = self.moments.eye()
        camera = staging.camera(self.scene, width, height, self.report, eye)
        staging.tell_of_lens(native, camera, width, height, self.report)
        raw.check(self.depsgraph, self.view.name, camera)
        settings = render_settings.describe(self.scene, width, height, self.results.has_data)
        settings = render_settings.of_layer(settings, self.scene, self.depsgraph.view_layer_eval)
        settings = render_settings.of_view(settings, self.view)
        self.samples, wanted = settings.samples, sampling.of_render(self.scene)
        checkpoint = checkpoints.of(self.depsgraph, self.view, is_part=self.results.is_mergeable)
        is_kept = checkpoint is not None and checkpoint.file is not None
        how = self._denoising()
        is_for_denoising = how is not None or self.results.has_denoising_data
        settings = dataclasses.replace(settings, independent_pixels=is_for_denoising)
        if settings.noise_threshold > 0.0 and wanted.is_after_denoising:
            settings = dataclasses.replace(settings, denoising=how)
        self.results.check_memory(width, height, halves=settings.noise_threshold > 0.0, is_kept=is_kept)
        blur, opened, moving = self.moments.over_the_shutter(shutter, camera, width, height)
        neighbours, motion = self.moments.beside(camera, width, height, is_asked=self.results.has_vectors)
        is_still, size = motion is None and blur is None, (width, height)
        now = persistent.begin(self.depsgraph, native, self.view, is_still=is_still, is_watched=checkpoint is not None)
        told = checkpoint.watched(now) if checkpoint else now.builder
        now.kept.builder = told
        catches = staging.fill(
            told, self.depsgraph, camera, size, now.report, self._check_stop, motion, blur, kept=now.kept, eye=eye
        )
        now.kept.sweep()
        if checkpoint:
            checkpoint.add(now.fingerprints)
        for warning in now.builder.warnings():
            now.report.warn(warning)
        self.report.warnings += now.report.warnings
        sync_seconds = time.perf_counter() - began

        self._tell("Building BVH", 0.0)
        place = staging.place(camera)
        scene = loop.stoppable(now.finish(place, settings.threads), self._stop_asked)
        persistent.keep(self.depsgraph, self.view, now, scene)
        self.report.warnings += scene.warnings()
        for warning in messages.grouped(self.report.warnings):
            self._warn(warning)
        self._tell("Preparing the lens", 0.0)
        if camera.focus.autofocus is not None:
            unfocused = camera
            camera, self.focus = loop.stoppable(
                lambda: staging.focus(native, scene, unfocused, width, height), self._stop_asked
            )
            moving = [focused(then, self.focus) for then in moving]
            neighbours = neighbours and tuple(focused(then, self.focus) for then in neighbours)
        self.camera = staging.in_a_line(native, camera, width, height, by="autofocus" if self.focus else "")
        if not (scene.moving_count or moving or (opened and opened.camera_keys)):
            # Nothing moves: samples need no time.
            opened = None
        if loop.WATCH.study is not None:
            wishes = effects.wishes(self.scene.petzval)
            loop.WATCH.study(loop.Subject(scene, camera, settings, moving, wishes, opened, sync_seconds))
            deliver_black(self.host, self.depsgraph, self.view.name)
            return
        settings = self._plan(native, scene, camera, settings, moving, opened, how)
        beside = self.results.for_job() | {
            "plan": self.plan,
            "neighbours": neighbours,
            "catches": catches,
            "shutter": opened,
            "mist": world_export.mist(self.scene.world),
            "occlusion_distance": world_export.occlusion_distance(self.scene.world),
        }
        picture_of: dict[str, str] = {}
        share, fingerprint = loop.WATCH.share, ""
        if checkpoint:
            decided = [(row["effect"], row["decision"]) for row in self.told["effects"]]
            others = {name: value for name, value in beside.items() if name != "plan"}
            fingerprint = checkpoint.fingerprint(settings, camera, moving, decided, others)
            beside["checkpoint"] = checkpoint.arguments(fingerprint)
            picture_of = checkpoint.picture(settings, camera, effects=decided, shutter=(moving, opened))
        if share is not None and checkpoint is not None:
            shares.agree(share, checkpoint, fingerprint, self.depsgraph, self.view)
        others = functools.partial(
            self._beside_all, native, camera, settings, moving, size, place, blur, opened, fingerprint
        )
        needs_sky = not self.scene.render.film_transparent and not self.results.has_shadow
        kinds = ([False, True] if needs_sky else [False]) if catches else []
        if share is not None and share.parts:
            make = functools.partial(native.Job, scene, camera, settings, moving)
            beside_them = [functools.partial(others, None, is_sky=one) for one in kinds]
            self._take_parts(share, make, beside, checkpoint, fingerprint, beside_them, sync_seconds)
            self._warn_late(scene)
            return
        beside |= shares.for_job(share, None)
        job = loop.stoppable(lambda: native.Job(scene, camera, settings, moving, **beside), self._stop_asked)
        limit_s = wanted.time_limit_s
        self.progress = progress.Progress(job, limit_s)
        stopped = loop.follow(
            job, stop_asked=self._stop_asked, show=self.results.show, tell=self._progress, limit_s=limit_s
        )
        self._progress(job.progress() if stopped else 1.0, job.samples_done())
        if share is not None:
            shares.join(share, job, fingerprint, (self.depsgraph, self.view))
        # Denoising and stray light belong to the whole picture.
        is_whole = share is None or share.is_whole
        if not is_whole:
            how = None
        if how is not None and not stopped:
            self._denoise(job, how)
        strays = [name for name in effects.STRAYS if self._is_on(name)]
        if strays and self.results.is_mergeable:
            self.host.report(
                {"WARNING"},
                f"Mergeable parts hold no {', '.join(strays)}: these are found in a whole picture; render it without Mergeable for them",
            )
        elif strays and is_whole and not stopped:
            self._develop(job)
        beside_it = None
        if catches and not stopped:
            jobs = [others(how, is_sky=is_sky) for is_sky in kinds]
            beside_it = (jobs[0], jobs[1] if needs_sky else None)
        combined = self._show_all(job, picture_of, beside_it)
        if is_whole:
            raw.write(self.depsgraph, self.view.name, camera, combined, self._warn)
        self._warn_late(scene)
        self._keep(json.loads(job.stats_json()), sync_seconds, stopped)
        if checkpoint:
            self._tell("Keeping the render", 1.0)
            written = loop.stoppable(job.end_checkpoints, lambda: False)
            if written is not None and loop.WATCH.checkpoint is not None:
                loop.WATCH.written_checkpoints.append(written)
            elif written is not None and not stopped:
                written.delete()

    def _take_parts(self, share, make, beside, checkpoint, fingerprint, others, sync_seconds) -> None:
        """Renders the share's parts into their films, of one scene that was read once. `make` gives a job, `others` the renders of a part
        that the picture needs beside it."""
        of = self.depsgraph, self.view
        # What the parts found is in their films.
        deliver_black(self.host, self.depsgraph, self.view.name)
        for part in share.parts:
            began, before = time.monotonic(), len(part.written)
            share.begun(part)
            checkpoint.file = checkpoints.of_view(part.checkpoint, *of)
            asked = beside | shares.for_job(share, part) | {"checkpoint": checkpoint.arguments(fingerprint)}
            job = loop.stoppable(functools.partial(make, **asked), self._stop_asked)
            self.progress = progress.Progress(job, 0.0)
            stopped = loop.follow(job, stop_asked=self._stop_asked, show=lambda _: None, tell=self._progress)
            if not stopped:
                shares.keep(share, part, job, fingerprint, of)
                for other in others:
                    other(part)
            self._keep(json.loads(job.stats_json()), sync_seconds, stopped)
            if (written := loop.stoppable(job.end_checkpoints, lambda: False)) is not None:
                part.checkpoints.append(written)
            part.seconds += time.monotonic() - began
            if stopped or share.problem or len(part.written) - before <= len(others):
                return
            if shares.is_last(*of):
                share.finished(part)

    def _warn_late(self, scene) -> None:
        """Reports the warnings of the engine's scene during the render."""
        for warning in scene.warnings():
            if warning not in self.report.warnings:
                self.report.warn(warning)
                self._warn(warning)

    def _warn(self, warning: str) -> None:
        if warning not in self.said:
            self.said.add(warning)
            self.host.report({"WARNING"}, warning)

    def _show_all(self, job, picture_of: dict[str, str], beside: tuple | None) -> np.ndarray:
        """Hands over the finished picture, and gives its colours. `beside`: the renders of shadow catchers alone, and of the sky, where
        things catch shadows."""
        pictures = {passes.COMBINED.name: job.image()}
        if self.results.is_denoised:
            pictures[passes.NOISY.name] = job.noisy_image()
        if beside is not None:
            alone, sky = beside
            is_opaque, is_apart = not self.scene.render.film_transparent, self.results.has_shadow
            for name in pictures:
                is_noisy = name == passes.NOISY.name
                pictures[name] = job.over_photograph(
                    alone, sky, is_opaque=is_opaque, is_apart=is_apart, is_noisy=is_noisy
                )
            pictures[passes.SHADOW.name] = job.shadow(alone)
        self.results.show_all(job, pictures, self.told, picture_of)
        return pictures[passes.COMBINED.name]

    def _is_on(self, effect: str) -> bool:
        return any(row["effect"] == effect and row["decision"] == "on" for row in self.told["effects"])

    def _develop(self, job) -> None:
        """Lays the stray light over the picture."""
        began, share = time.monotonic(), self._share_after_samples() - self.denoise_share

        def meanwhile() -> None:
            part = job.developed()
            gone = time.monotonic() - began
            left = gone * (1.0 - part) / part if part > _LEAST_PART else None
            remaining = "" if left is None else f"Remaining:{progress.clock_time(left)} | "
            self._tell(f"Ghosts, glare and diffraction: {100.0 * part:.0f} %", 1.0 - share * (1.0 - part), remaining)

        try:
            loop.stoppable(job.develop, self._stop_asked, meanwhile)
        except loop.Stopped:
            # What is there of the picture stays.
            job.stop_developing()

    def _share_after_samples(self) -> float:
        """The part of the time that denoising and the stray light are to take, after the samples."""
        predicted = self.told.get("predicted")
        return predicted["after_seconds"] / predicted["seconds"] if predicted and predicted["seconds"] else 0.0

    def _denoising(self) -> DenoisingDescription | None:
        """The denoising of the picture once its samples are there; None: not denoised."""
        how = denoising.of_render(self.scene) if self.results.is_denoised else None
        if how is None and self.results.is_denoised:
            # It is on unless it is turned off: who turned it on wants to know.
            level = "WARNING" if self.scene.cycles.is_property_set("use_denoising") else "INFO"
            self.host.report({level}, f"Not denoised: {denoiser.INSTALL}")
        if how is not None:
            self.results.guides = denoising.guides(how)
        return how

    def _denoise(self, job, how: DenoisingDescription) -> None:
        """Takes the noise out of the picture; without that it stays as it is."""
        done = 1.0 - self._share_after_samples()
        how = denoising.within_memory(how, self.scene.petzval.memory_limit)

        def meanwhile() -> None:
            part = job.developed()
            self._tell(f"Denoising: {100.0 * part:.0f} %", done + self.denoise_share * part)

        try:
            loop.stoppable(lambda: job.denoise(how), self._stop_asked, meanwhile)
        except loop.Stopped:
            job.stop_developing()
        except engine().PetzvalError as error:
            self.host.report({"WARNING"}, f"Not denoised: {error}")

    def _beside_all(
        self, native, camera, settings, moving, size, place, blur, opened, fingerprint, how, part=None, *, is_sky: bool
    ):
        """The finished render of shadow catchers without anything that casts shadows, or of the sky alone."""
        builder = native.SceneBuilder()
        if is_sky:
            staging.fill_sky(builder, self.depsgraph, camera, size, Report())
        else:
            staging.fill(
                builder,
                self.depsgraph,
                camera,
                size,
                Report(),
                self._check_stop,
                blur=blur,
                only_catchers=True,
                eye=self.moments.eye(),
            )
        # A sky that the camera sees is none of the light on what catches shadows.
        settings = dataclasses.replace(settings, transparent_film=not is_sky)
        scene = loop.stoppable(lambda: builder.build(place, settings.threads, None), self._stop_asked)
        share = loop.WATCH.share
        kept = {"parts": self.results.guides, "plan": self.plan, "shutter": opened, **shares.for_job(share, part)}
        make = lambda: native.Job(scene, camera, settings, moving, **kept)  # noqa: E731
        job = loop.stoppable(make, self._stop_asked)
        tell = lambda part, _: self._tell("Shadow catcher background", part)  # noqa: E731
        stopped = loop.follow(job, stop_asked=self._stop_asked, show=lambda _: None, tell=tell)
        of, what = (self.depsgraph, self.view), ".sky" if is_sky else ".catchers"
        if part is not None and not stopped:
            shares.keep(share, part, job, fingerprint, of, what)
        elif share is not None and not share.parts:
            shares.join(share, job, fingerprint, of, what)
        if how is not None and not stopped:
            self._denoise(job, how)
        return job

    def _plan(self, native, scene, camera, settings, moving, opened, how) -> SettingsDescription:
        """Decides which effects are simulated; the settings, in a border only those that it needs."""
        self._tell("Planning the effects", 0.0)
        wishes = effects.wishes(self.scene.petzval)
        self.plan = loop.stoppable(
            lambda: native.Plan(scene, camera, settings, moving, shutter=opened, **wishes), self._stop_asked
        )
        planned = json.loads(self.plan.json())
        is_part = loop.WATCH.share is not None
        border = region(self.scene.render) if self.scene.render.use_border else None
        # Parts of a picture are joined with others of its whole.
        if border is not None and not is_part and not self.results.is_mergeable:
            window = self.plan.window(tuple(border), (settings.width, settings.height))
            settings = dataclasses.replace(settings, window=window)
        if settings.width * settings.height * settings.samples > _WORTH_A_FORECAST and not is_part:
            planned = json.loads(loop.stoppable(lambda: self.plan.forecast(scene, camera, settings), self._stop_asked))
        if how is not None and (predicted := planned.get("predicted")):
            _, _, width, height = settings.window or (0, 0, settings.width, settings.height)
            seconds = native.denoising_seconds(how, width * height, predicted["threads"])
            predicted |= {key: predicted[key] + seconds for key in ("seconds", "after_seconds")}
            self.denoise_share = seconds / predicted["seconds"]
        planning.keep(self.scene.name, planned)
        for faces in planned["look"]["coincident_faces"]:
            # The picture is right; another program's may not be.
            self.report.warn(faces["text"])
            self.host.report({"INFO"}, faces["text"])
        self.told, self.planned = planned, effects.summary(planned)
        return settings

    def _progress(self, part: float, samples: int) -> None:
        left, speed = self.progress.remaining(part), self.progress.speed()
        used, peak = process_memory.used_bytes(), process_memory.peak_bytes()
        if used is not None and peak is not None:
            self.host.update_memory_stats(memory_used=used / 2**20, memory_peak=peak / 2**20)
            left += f"Mem:{used / 2**20:.0f}M, Peak:{peak / 2**20:.0f}M | "
        done = part * (1.0 - self._share_after_samples())
        self._tell(f"Sample {samples}/{self.samples}{speed} | {self.planned}", done, left)

    def _tell(self, text: str, part: float, left: str = "") -> None:
        view = self.view
        if view.name:
            part, text = (view.index + part) / view.count, f"{view.name}: {text}"
        self.host.update_stats("", left + text)
        self.host.update_progress(part)
        if loop.WATCH.on_progress is not None:
            loop.WATCH.on_progress(part, text)

    def _stop_asked(self) -> bool:
        return self.host.test_break() or loop.WATCH.stop.is_set()

    def _check_stop(self) -> None:
        if self._stop_asked():
            raise loop.Stopped

    def _keep(self, stats: dict, sync_seconds: float, stopped: bool) -> None:
        stats["seconds"]["sync"], stats["camera"] = sync_seconds, self.camera
        # With the forecast, if there was one.
        stats["planned"], stats["plan"] = self.told, self.told["effects"]
        wanted = sampling.of_render(self.scene)
        stats["peak_memory_bytes"], stats["time_limit_s"] = process_memory.peak_bytes(), wanted.time_limit_s
        stats["sampling"] = wanted.in_a_line()
        if self.focus is not None:
            stats["autofocus"] = self.focus
        render = statistics.LastRender(stats, self.report.warnings, stopped)
        statistics.keep(self.scene.name, render)
        for line in render.lines():
            print(f"Petzval: {line}")
        if problem := (stats["checkpoint"] or {}).get("problem"):
            self.host.report({"WARNING"}, problem)
        if stats.get("failure"):
            self.host.report({"ERROR"}, stats["failure"])
