# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders the rungs, interleaved, until their times have settled. Runs where Blender is; the scene is read once.

A round renders the rungs for about as long each, in an order that is drawn anew, and a part of the truth (the top rung with
random numbers of its own, in two halves). Other work of the machine affects all rungs of a round alike, so times are
compared within rounds. Effects taken out, and strays, that take long to set up have their turn in every `SLOW_STRIDE`th round, with as
many more samples. The first round is not counted: it warms up, and gives the number of samples that fit. It ends when the interval of every
rung's median ratio to the pinhole is narrower than `SETTLED`, but not before `LEAST_ROUNDS`; or when the time given is over, or
the rounds asked for are done.
"""

from __future__ import annotations

import dataclasses
import json
import random
import time
from dataclasses import dataclass, field
from typing import Any

from ..description import changed
from . import results
from .accuracy import Sums
from .intervals import LEAST, is_settled
from .ladder import AUTO, PINHOLE, TOP, Rung, effect_of, ladder

LEAST_ROUNDS = 2 * LEAST
#: Rounds that should fit into the time given.
WANTED_ROUNDS = 14
#: The part of a round's time that goes into the truth.
TRUTH_PART = 0.4
#: The time of a set-up beyond which it is not paid in every round, s.
SLOW_SETUP_S = 0.1
SLOW_STRIDE = 4
#: A rung renders at least so long in its turn, s: shorter times are not well measured.
LEAST_RENDER_S = 0.08
#: A pixel, in the round that warms up.
WARM_UP_SAMPLES = 4
#: The seed of the truth, which no rung has.
TRUTH_SEED = 1 << 30
_POLL_SECONDS = 0.05


class Broken(Exception):
    """Somebody asked to stop."""


@dataclass
class Runs:
    """The measurements of one rung."""

    rung: Rung
    #: Samples a pixel in each turn, which comes in every `stride`th round.
    samples: int = WARM_UP_SAMPLES
    stride: int = 1
    #: The numbers of the rung's rounds; the lists below go with them.
    rounds: list[int] = field(default_factory=list)
    plan: dict[str, Any] = field(default_factory=dict)
    setup_s: list[float] = field(default_factory=list)
    #: Times of a render: by the clock, and of all threads together.
    wall_s: list[float] = field(default_factory=list)
    processor_s: list[float] = field(default_factory=list)
    predicted_s: list[float] = field(default_factory=list)
    #: Time of the forecast, s.
    forecast_s: list[float] = field(default_factory=list)
    pictures: Sums = field(default_factory=Sums)
    #: The stray light of a rung with some, and the time to find it, by the clock.
    strayed: Sums = field(default_factory=Sums)
    stray_s: list[float] = field(default_factory=list)
    stats: dict[str, Any] = field(default_factory=dict)
    #: The reason why it could not be rendered.
    why_not: str | None = None


class Study:
    """The study that is called by the engine instead of a render; `found` is its result, if there is one."""

    #: Worth a progress bar.
    is_long = True

    def __init__(self, options: dict[str, Any], watch: Any) -> None:
        self.options = options
        self.watch = watch
        self.found: dict[str, Any] | None = None

    def __call__(self, subject: Any) -> None:
        if self.found is not None:  # a further view layer
            return
        measured = _Measured(subject, self.options, self.watch)
        try:
            measured.run()
        except Broken:
            if not measured.has_some():
                return
        self.found = results.of(measured)


class _Measured:
    """The rungs of one picture, and the measurements of each."""

    def __init__(self, subject: Any, options: dict[str, Any], watch: Any) -> None:
        from petzval import _native

        self.native = _native
        self.subject, self.options, self.watch = subject, options, watch
        self.settings = dataclasses.replace(subject.settings, noise_threshold=0.0, blue_noise=False, with_data=False)
        self.info = json.loads(_native.camera_info_json(subject.camera, self.settings.width, self.settings.height))
        effects = json.loads(_native.effects_json())
        self.available = [one["name"] for one in effects if one["is_available"]]
        rungs = ladder(subject.camera, self.info, self.available, subject.wishes)
        self.runs = {rung.key: Runs(rung, why_not=rung.missing) for rung in rungs}
        self.truth = (Sums(), Sums())
        self.truth_samples = 0
        #: The rows of the plan as the user wishes it, stray light with it.
        self.planned: list[dict[str, Any]] = []
        self.truth_each = 0
        self.rounds = 0
        self.began = time.monotonic()
        #: The exposure of the scene's view transform, stops.
        self.exposure_stops = options["exposure_stops"]

    def run(self) -> None:
        """Runs all rounds, and computes the results."""
        self._warm_up()
        order = random.Random(1)
        while not self._is_over():
            turn = [one for i, one in enumerate(self._able()) if (self.rounds + i) % one.stride == 0]
            order.shuffle(turn)
            for one in turn:
                self._tell(one.rung.name)
                self._render(one, seed=1 + self.rounds)
            self._tell("the truth")
            self._add_truth()
            self.rounds += 1

    def has_enough(self) -> bool:
        """Each rung, and each half of the truth, was rendered twice at least."""
        return self.rounds >= 4 and all(one.pictures.count >= 2 for one in self._able())

    def has_some(self) -> bool:
        """Something can be told, if not of every rung: for who has asked to stop."""
        return min(self.runs[key].pictures.count for key in (TOP, AUTO, self.base().rung.key)) >= 2 and self.rounds >= 2

    def settled(self) -> bool:
        """True if every rung's ratio to the pinhole is known well enough."""
        return self.rounds >= LEAST_ROUNDS and all(
            one.pictures.count and is_settled(self.ratios(one)) for one in self._able() if one.rung.group != "stray"
        )

    def ratios(self, one: Runs) -> list[float]:
        """A rung's time for a sample over the pinhole's, round by round; over the thick lens's where no pinhole frames the
        picture."""
        base = self.base()
        times = dict(zip(base.rounds, base.processor_s, strict=False))
        each = zip(one.rounds, one.processor_s, strict=False)
        return [base.samples / one.samples * mine / times[number] for number, mine in each if number in times]

    def base(self) -> Runs:
        return self.runs[PINHOLE] if self.runs[PINHOLE].why_not is None else self.runs["thick"]

    def _able(self) -> list[Runs]:
        return [one for one in self.runs.values() if one.why_not is None]

    def elapsed(self) -> float:
        return time.monotonic() - self.began

    def _is_over(self) -> bool:
        if self.options["rounds"]:
            return bool(self.rounds >= self.options["rounds"])
        if not self.has_enough():
            return False
        # Not in the middle of the two halves of the truth.
        return self.rounds % 2 == 0 and (self.elapsed() > self.options["seconds"] or self.settled())

    def _warm_up(self) -> None:
        self.planned = self._plan_as_wished()
        for one in self._able():
            self._tell(f"warming up: {one.rung.name}")
            self._prepare(one)
        ready = self._able()
        most_stride = min(SLOW_STRIDE, (self.options["rounds"] or WANTED_ROUNDS) // 2)
        for one in ready:
            is_slow = one.rung.group in ("effect", "stray") and one.setup_s[-1] > SLOW_SETUP_S
            one.stride = most_stride if is_slow else 1
        round_s = max(self.options["seconds"] - self.elapsed(), 1.0) / (self.options["rounds"] or WANTED_ROUNDS)
        apart_s = sum(one.setup_s[-1] / one.stride for one in ready) + sum(self.runs[AUTO].forecast_s)
        each_s = max(((1.0 - TRUTH_PART) * round_s - apart_s) / len(ready), LEAST_RENDER_S)
        truth_s = TRUTH_PART / (1.0 - TRUTH_PART) * (each_s * len(ready) + apart_s)
        self.truth_each = max(int(truth_s / self.runs[TOP].wall_s[-1] * WARM_UP_SAMPLES), WARM_UP_SAMPLES)
        for one in ready:
            one.samples = max(int(each_s * one.stride / one.wall_s[-1] * WARM_UP_SAMPLES), WARM_UP_SAMPLES)
            one.rounds, one.setup_s, one.wall_s, one.processor_s = [], [], [], []
            one.predicted_s, one.forecast_s = [], []
            one.pictures, one.strayed, one.stray_s = Sums(), Sums(), []

    def _plan_as_wished(self) -> list[dict[str, Any]]:
        subject = self.subject
        plan = self.native.Plan(
            subject.scene,
            subject.camera,
            self.settings,
            subject.over_the_shutter,
            shutter=subject.shutter,
            **subject.wishes,
        )
        effects: list[dict[str, Any]] = json.loads(plan.json())["effects"]
        return effects

    def _prepare(self, one: Runs) -> None:
        """Renders a rung for the first time; a rung that cannot be rendered is left with the reason."""
        try:
            self._render(one, seed=0)
        except self.native.PetzvalError as error:
            if one.rung.key in (TOP, AUTO):
                raise
            one.why_not = " ".join(str(error).split())
            return
        left_out = one.rung.key.removeprefix("no-") if one.rung.group == "effect" else None
        top = {row["effect"]: row for row in self.runs[TOP].plan.get("effects", ())}
        mine = {row["effect"]: row for row in one.plan["effects"]}
        if left_out and top[left_out]["decision"] == "off":
            one.why_not = f"there is none in this picture: {top[left_out]['why'].split(':')[0]}"
        elif left_out and mine[left_out]["decision"] == "on":
            one.why_not = "it cannot be taken out of this lens"

    def _render(self, one: Runs, seed: int) -> None:
        rung, subject = one.rung, self.subject
        camera = changed(subject.camera, rung.camera)
        moving = [changed(then, rung.camera) for then in subject.over_the_shutter]
        settings = dataclasses.replace(self.settings, samples=one.samples, seed=seed, **rung.settings)
        wishes = subject.wishes | {"effects": rung.effects, "quality": rung.quality}
        began = time.perf_counter()
        plan = self.native.Plan(subject.scene, camera, settings, moving, shutter=subject.shutter, **wishes)
        planned = time.perf_counter() - began
        if rung.key == AUTO:
            began = time.perf_counter()
            told = json.loads(plan.forecast(subject.scene, camera, settings))
            one.predicted_s.append(told["predicted"]["seconds"])
            one.forecast_s.append(time.perf_counter() - began)
        else:
            told = json.loads(plan.json())
        began, processor = time.perf_counter(), time.process_time()
        job = self.native.Job(subject.scene, camera, settings, moving, plan=plan, shutter=subject.shutter)
        one.setup_s.append(planned + time.perf_counter() - began)
        made = time.process_time() - processor
        self._wait(job)
        processor = time.process_time() - processor
        # Once a picture, whatever its samples.
        began = time.perf_counter()
        job.develop()
        developed = time.perf_counter() - began
        one.setup_s[-1] += developed
        stats = json.loads(job.stats_json())
        if stats.get("failure"):
            raise self.native.PetzvalError(stats["failure"])
        one.plan, one.stats = told, stats
        one.rounds.append(self.rounds)
        one.wall_s.append(stats["seconds"]["render"])
        one.processor_s.append(processor - made)
        one.pictures.add(job.image()[..., :3])
        if rung.group == "stray":
            effect = effect_of(rung.key)
            assert effect is not None
            one.strayed.add(job.stray(effect.upper()))
            one.stray_s.append(developed)

    def _add_truth(self) -> None:
        """The top rung, with other random numbers, into the half that has less."""
        rung = self.runs[TOP].rung
        camera = changed(self.subject.camera, rung.camera)
        moving = [changed(then, rung.camera) for then in self.subject.over_the_shutter]
        settings = dataclasses.replace(
            self.settings, samples=self.truth_each, seed=TRUTH_SEED + self.rounds, **rung.settings
        )
        plan = self.native.Plan(
            self.subject.scene,
            camera,
            settings,
            moving,
            effects=rung.effects,
            quality=rung.quality,
            shutter=self.subject.shutter,
        )
        job = self.native.Job(self.subject.scene, camera, settings, moving, plan=plan, shutter=self.subject.shutter)
        self._wait(job)
        self.truth[self.rounds % 2].add(job.image()[..., :3])
        self.truth_samples += self.truth_each

    def _wait(self, job: Any) -> None:
        while not job.wait(_POLL_SECONDS):
            if self.watch.stop.is_set():
                job.stop()
                while not job.wait(_POLL_SECONDS):
                    pass
                raise Broken
            self._tell(None)
        if self.watch.stop.is_set():
            raise Broken

    _doing = ""

    def _tell(self, doing: str | None) -> None:
        if doing is not None:
            self._doing = doing
        if self.watch.on_progress is None:
            return
        if self.options["rounds"]:
            part = self.rounds / self.options["rounds"]
        else:
            part = self.elapsed() / self.options["seconds"]
        self.watch.on_progress(min(part, 0.999), f"round {self.rounds + 1}: {self._doing}")
