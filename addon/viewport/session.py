# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders the request of a view in a thread of its own: a coarse picture at once, then one that is refined. No bpy."""

from __future__ import annotations

import dataclasses
import json
import threading
import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from petzval.description import CameraDescription, DenoisingDescription, SettingsDescription, focused

from ..data.tiles import Window
from ..render import loop

#: Time for a first picture at most, s; it has as many fewer pixels as that needs.
FIRST_S = 0.05
_DIVIDERS = (1, 2, 4, 8, 16)
#: Pixels in a second, before that is known.
_GUESSED_RATE = 1e5
#: Time from one picture to the next, s, while it is refined: short at first.
_SHOW_S, _SHOW_LATER_S = 0.1, 0.5
_POLL_S = 0.02


@dataclass(frozen=True)
class Wanted:
    """The request of a view."""

    camera: CameraDescription
    #: The settings, with the picture's size, the part of it that is seen, and the most samples.
    settings: SettingsDescription
    #: The wishes for effects, as the engine's `Plan` takes them.
    wishes: dict[str, Any] = field(default_factory=dict)
    #: The denoising of pictures, from `denoise_from` samples on; None: off.
    denoising: DenoisingDescription | None = None
    denoise_from: int = 1

    @property
    def parts(self) -> list[str]:
        """The passes that guide the denoiser: the engine keeps them."""
        how = self.denoising
        if how is None:
            return []
        return ["DENOISING_ALBEDO"] * how.by_albedo + ["DENOISING_NORMAL"] * how.by_normal

    @property
    def has_wishes(self) -> bool:
        """True if an effect is not left to the engine: its own decisions leave out only invisible effects, and need no plan."""
        return any(word != "auto" for word in self.wishes.get("effects", {}).values())

    @property
    def window(self) -> Window:
        s = self.settings
        return Window(*(s.window or (0, 0, s.width, s.height)))


@dataclass(frozen=True)
class Picture:
    """The picture of a view."""

    #: (height, width, 4), scene-linear, rows from below: the part of the picture that is seen.
    pixels: np.ndarray
    #: The place of `pixels` in the whole picture: left, bottom, width, height; 0 to 1.
    place: tuple[float, float, float, float]
    samples: int
    wanted: Wanted
    is_denoised: bool = False


class Session:
    """The renders of one view. Its methods return at once."""

    def __init__(self, native: Any) -> None:
        self._native = native
        self._wake = threading.Condition()
        self._draft: Any = None
        self._asked: Wanted | None = None
        self._is_new = False
        self._is_closed = False
        self._is_busy = False
        self._rate = _GUESSED_RATE
        self._plan: Any = None
        # The engine's scene, of the thread alone.
        self._scene: Any = None
        #: The last picture.
        self.picture: Picture | None = None
        #: The last error, and the warnings of the engine.
        self.error = ""
        self.warnings: list[str] = []
        #: Seconds that the first and the last scene took to be built, and from a wish to its first picture.
        self.seconds: dict[str, float] = {}
        self._thread = threading.Thread(target=self._run, name="petzval viewport", daemon=True)
        self._thread.start()

    def build(self, draft: Any) -> None:
        """Renders another scene from now on."""
        with self._wake:
            self._draft, self._is_new = draft, True
            self._wake.notify()

    def look(self, wanted: Wanted) -> None:
        """Renders this request from now on, if it differs from the last."""
        if wanted == self._asked:
            return
        with self._wake:
            self._asked, self._is_new = wanted, True
            self._wake.notify()

    @property
    def is_busy(self) -> bool:
        """True if more samples are to come."""
        return (self._is_busy or self._is_new) and not self._is_closed

    def close(self) -> None:
        """Ends soon; waits for nothing."""
        with self._wake:
            self._is_closed = True
            self._wake.notify()

    def wait(self, seconds: float) -> bool:
        """Waits until the last picture is there; False where that takes longer. For tests and tools."""
        end = time.monotonic() + seconds
        while self.is_busy:
            if time.monotonic() > end:
                return False
            time.sleep(0.005)
        return True

    def _run(self) -> None:
        while True:
            with self._wake:
                self._is_busy = False
                while not (self._is_closed or self._is_new):
                    self._wake.wait()
                if self._is_closed:
                    break
                self._is_busy, self._is_new = True, False
                draft, wanted = self._draft, self._asked
                self._draft = None
            try:
                self._work(draft, wanted)
            except Exception as error:  # is told in the view; the next wish may be better
                self.error = " ".join(str(error).split()) or type(error).__name__
        self._scene = self._plan = self.picture = None

    def _work(self, draft: Any, wanted: Wanted | None) -> None:
        began = time.perf_counter()
        if draft is not None:
            threads = wanted.settings.threads if wanted else 0
            self._scene = draft.build(threads, self._scene)
            self._plan = None
            self.warnings = self._scene.warnings()
            self.seconds["build"] = time.perf_counter() - began
        if self._scene is None or wanted is None:
            return
        self.error = ""
        camera = self._focused(wanted)
        if self._coarse(wanted, camera, began):
            self._refine(wanted, camera, began)

    def _focused(self, wanted: Wanted) -> CameraDescription:
        camera, s = wanted.camera, wanted.settings
        if camera.focus.autofocus is None:
            return camera
        answer = self._native.autofocus_json(self._scene, camera, s.width, s.height, camera.focus.autofocus)
        return focused(camera, json.loads(answer))

    def _coarse(self, wanted: Wanted, camera: CameraDescription, began: float) -> bool:
        """One sample for each of as many pixels as go quickly, then for four times as many, until all have one; False where something
        else is asked for meanwhile. The first goes to its end: or a view that moves would show nothing."""
        pixels = wanted.window.width * wanted.window.height
        first = next((d for d in _DIVIDERS if pixels / (d * d * self._rate) <= FIRST_S), _DIVIDERS[-1])
        for divider in reversed(_DIVIDERS[1:]):
            if divider > first:
                continue
            smaller = _divided(wanted, divider)
            # The last of them is denoised, too: all pixels may take long.
            is_last = divider == _DIVIDERS[1] and wanted.denoise_from <= 1
            parts = wanted.parts if is_last else []
            job = self._native.Job(self._scene, camera, smaller, plan=self._plan, parts=parts)
            started = time.perf_counter()
            while not job.wait(_POLL_S):
                if self._is_closed or (divider != first and self._is_new):
                    job.stop()
                    return False
            self._count(smaller.window[2] * smaller.window[3], started)
            self._show(job, wanted, smaller, began)
            if self._interrupted():
                return False
            if is_last and (image := self._denoised(job, wanted)) is not None:
                self._show(job, wanted, smaller, began, image)
        return not self._interrupted()

    def _count(self, samples: int, started: float) -> None:
        """Learns how quickly samples go."""
        rate = samples / max(time.perf_counter() - started, 1e-3)
        # Small pictures say little, and a rate that jumps would have pictures jump in size.
        self._rate += (rate - self._rate) * (0.5 if samples > 10_000 else 0.1)

    def _refine(self, wanted: Wanted, camera: CameraDescription, began: float) -> None:
        s = wanted.settings
        if wanted.has_wishes:
            self._plan = self._native.Plan(self._scene, camera, s, **wanted.wishes)
        else:
            self._plan = None
        job = self._native.Job(self._scene, camera, s, plan=self._plan, parts=wanted.parts)
        started, shown, next_show = time.perf_counter(), 0, 0.0
        is_done = False
        while not is_done:
            is_done = job.wait(_POLL_S)
            if self._interrupted():
                job.stop()
                while not job.wait(_POLL_S):
                    pass
                return
            now, samples = time.perf_counter(), job.samples_done()
            # With a noise threshold parts go on when the last has all its samples.
            if is_done or (samples > shown and now >= next_show):
                if shown == 0:
                    self._count(samples * wanted.window.width * wanted.window.height, started)
                self._show_refined(job, wanted, began)
                took = time.perf_counter() - now
                # Half of the time at least is the samples' own.
                pause = max(_SHOW_S if samples < 16 else _SHOW_LATER_S, took)
                shown, next_show = samples, now + took + pause
        failure = json.loads(job.stats_json()).get("failure")
        if failure:
            self.error = failure

    def _show_refined(self, job: Any, wanted: Wanted, began: float) -> None:
        """Shows the picture as it is, or denoised: pictures of few samples before it are not."""
        image = None
        if wanted.denoising is not None and job.samples_done() >= wanted.denoise_from:
            before = self.picture
            if before is None or before.wanted is not wanted or not before.is_denoised:
                # Denoising takes its time: the noisy picture is there meanwhile.
                self._show(job, wanted, wanted.settings, began)
            image = self._denoised(job, wanted)
            if self._interrupted():
                return
        self._show(job, wanted, wanted.settings, began, image)

    def _denoised(self, job: Any, wanted: Wanted) -> np.ndarray | None:
        """The picture without its noise; None where it stays noisy, or where something else is asked for meanwhile."""
        how = wanted.denoising
        if how is None:
            return None
        try:
            return loop.stoppable(lambda: job.denoised_image(how), self._interrupted)
        except loop.Stopped:
            job.stop_developing()
        except self._native.PetzvalError as error:
            # It is shown with its noise, and said.
            self.warnings = [*self.warnings, *{f"Not denoised: {error}"}.difference(self.warnings)]
        return None

    def _show(
        self, job: Any, wanted: Wanted, of: SettingsDescription, began: float, image: np.ndarray | None = None
    ) -> None:
        x, y, width, height = of.window or (0, 0, of.width, of.height)
        whole = job.image() if image is None else image
        pixels = np.ascontiguousarray(whole[y : y + height, x : x + width])
        place = (x / of.width, y / of.height, width / of.width, height / of.height)
        if self.picture is None or self.picture.wanted is not wanted:
            self.seconds["first"] = time.perf_counter() - began
        self.picture = Picture(pixels, place, job.samples_done(), wanted, image is not None)

    def _interrupted(self) -> bool:
        return self._is_new or self._is_closed


def _divided(wanted: Wanted, divider: int) -> SettingsDescription:
    """The settings of a picture with so many times fewer columns and rows, of one sample."""
    s = wanted.settings
    size = [max(round(side / divider), 1) for side in (s.width, s.height)]
    x, y, width, height = wanted.window
    begin = [min(int(at * n / side), n - 1) for at, n, side in zip((x, y), size, (s.width, s.height), strict=True)]
    end = [
        min(-int(-at * n // side), n)
        for at, n, side in zip((x + width, y + height), size, (s.width, s.height), strict=True)
    ]
    window = (*begin, max(end[0] - begin[0], 1), max(end[1] - begin[1], 1))
    # The choice of lights for light tracing would come before the first picture after each edit.
    return dataclasses.replace(s, width=size[0], height=size[1], window=window, samples=1, light_tracing=False)
