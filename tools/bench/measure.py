# SPDX-License-Identifier: GPL-3.0-or-later
"""The experiments. Programs take turns, so that a busy hour of the machine meets all of them."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from statistics import median
from typing import Any

import numpy as np

from . import noise
from .programs import CAMERAS, CAN, CYCLES, LLVM, NAMES, PETZVAL, SCALAR, Bench, Failed, Job


@dataclass(frozen=True)
class Plan:
    """The extent of a measurement: scenes, cameras, rounds, sizes, samples."""

    scenes: tuple[str, ...]
    cameras: tuple[str, ...]
    #: The cameras whose noise is measured.
    noise_cameras: tuple[str, ...]
    rounds: int
    size: tuple[int, int]
    samples: int
    noise_size: tuple[int, int]
    noise_samples: tuple[int, ...]
    reference_samples: int
    #: Programs render with so many threads, one after the other, to be compared; none: it is not measured.
    threads: tuple[int, ...]
    #: Names of `places.MAKERS`.
    places: tuple[str, ...]


#: The names of `places.MAKERS`, which only a Python with bpy can import.
PLACES = ("meadow", "room", "night")
FULL = Plan(
    ("small", "large"),
    tuple(CAMERAS),
    tuple(CAMERAS),
    3,
    (960, 540),
    16,
    (192, 108),
    (8, 32, 128),
    1024,
    (1, 2),
    PLACES,
)
QUICK = Plan(("small",), ("thin", "lens-one"), ("thin",), 1, (160, 90), 2, (48, 27), (4, 16), 32, (), PLACES[-1:])

#: The seeds of the two halves of a converged picture: their difference is its noise.
REFERENCE_SEEDS = (77, 78)
#: Seeds of the pictures whose noise is measured; one is enough for 20,000 pixels.
NOISE_SEED = 5


class Experiments:
    """Runs all, and keeps the results as plain data."""

    def __init__(self, bench: Bench, plan: Plan) -> None:
        self.bench, self.plan = bench, plan
        self.found: dict[str, Any] = {
            "speed": {}, "noise": {}, "agreement": [], "threads": {}, "memory": {}, "places": {},
        }  # fmt: skip
        self._began = time.perf_counter()

    def all(self) -> dict[str, Any]:
        self.memory()
        self.speed()
        self.noise()
        self.places()
        self.threads()
        self.rays()
        return self.found

    def _run(self, job: Job) -> list[dict] | None:
        self._tell(f"{NAMES.get(job.program, job.program)}, {job.camera or 'loaded'}, {job.scene}")
        try:
            return self.bench.run(job)
        except Failed as error:
            if str(error) not in self.bench.missing:
                self.bench.missing.append(str(error))
                self._tell(f"could not run: {error}")
            return None

    def _tell(self, text: str) -> None:
        print(f"petzval: {time.perf_counter() - self._began:5.0f} s  {text}", file=sys.stderr, flush=True)

    def memory(self) -> None:
        """Measures the memory of Blender with the scene loaded, before a render."""
        for scene in self.plan.scenes:
            done = self._run(Job("blender", "", scene=scene))
            if done:
                self.found["memory"][scene] = done[0]["peak_mb"]

    def speed(self) -> None:
        plan = self.plan
        for turn in range(plan.rounds):
            for scene in plan.scenes:
                for camera in plan.cameras:
                    for program in self.bench.programs():
                        if camera in CAN[program]:
                            # What one sample takes holds all that is done once; the rest is the samples'.
                            renders = [(1, 1), (1 + plan.samples, 2 + turn)]
                            done = self._run(Job(program, camera, plan.size, renders, scene))
                            if done:
                                self._keep_speed(scene, camera, program, done)

    def _keep_speed(self, scene: str, camera: str, program: str, done: list[dict]) -> None:
        one, many = done
        sampling = many["user_s"] - one["user_s"]
        kept = {
            "sampling_s": sampling,
            "once_s": one["user_s"] - sampling / self.plan.samples,
            "sampling_wall_s": many["wall_s"] - one["wall_s"],
            **{key: many[key] for key in ("peak_mb", "tree_s", "sync_s", "lost") if key in many},
        }
        if program == CYCLES and camera == "lens-one":
            kept["lost"] = self.bench.osl_lost
        self.found["speed"].setdefault(scene, {}).setdefault(camera, {}).setdefault(program, []).append(kept)

    def noise(self) -> None:
        plan, pixels = self.plan, {}
        for camera in plan.noise_cameras:
            for program in self.bench.programs():
                if camera not in CAN[program]:
                    continue
                # Both variants of Mitsuba have one limit; the faster one finds it.
                shares = program == SCALAR and LLVM in self.bench.programs()
                renders = [(1, 1), *((n, NOISE_SEED + i) for i, n in enumerate(plan.noise_samples))]
                renders += [] if shares else [(plan.reference_samples // 2, seed) for seed in REFERENCE_SEEDS]
                done = self._run(Job(program, camera, plan.noise_size, renders, plan.scenes[0], keep=True))
                if done:
                    pixels[camera, program] = [np.load(one["file"]) for one in done[1:]]
                    seconds = [one["user_s"] for one in done[1 : 1 + len(plan.noise_samples)]]
                    self.found["noise"].setdefault(camera, {})[program] = {"seconds": seconds}
        for (camera, program), pictures in pixels.items():
            shares = program == SCALAR and LLVM in self.bench.programs()
            if shares and (camera, LLVM) not in pixels:
                del self.found["noise"][camera][program]
                continue
            limit = _converged(pixels[camera, LLVM] if shares else pictures)
            errors = [
                noise.rel_mse(picture, limit, n, plan.reference_samples)
                for picture, n in zip(pictures, plan.noise_samples, strict=False)
            ]
            kept = self.found["noise"][camera][program]
            fitted = noise.fit(plan.noise_samples, errors, kept["seconds"])
            kept |= {"samples": list(plan.noise_samples), "errors": errors,
                     "error_samples": fitted.error_samples, "seconds_per_sample": fitted.seconds_per_sample}  # fmt: skip
        self._agreement(pixels)

    def _agreement(self, pixels: dict) -> None:
        """Measures the agreement of Petzval's converged pictures with the others', the noise of both subtracted."""
        mitsuba = LLVM if LLVM in self.bench.programs() else SCALAR
        pairs = [(PETZVAL, CYCLES), (PETZVAL, mitsuba), (CYCLES, mitsuba)]
        for camera in self.plan.noise_cameras:
            for first, second in pairs:
                if (camera, first) not in pixels or (camera, second) not in pixels:
                    continue
                a, b = (_converged(pixels[camera, one]) for one in (first, second))
                measured, own = noise.difference(pixels[camera, first][-2:], pixels[camera, second][-2:])
                self.found["agreement"].append(
                    {
                        "camera": camera,
                        "programs": [first, second],
                        "measured": measured,
                        "noise": own,
                        "mean_ratio": float(a.mean() / b.mean()),
                    }
                )

    def places(self) -> None:
        """Each place by Petzval and by Cycles through a pinhole, seeds in turns: processor time of a sample, noise, and both together."""
        plan = self.plan
        samples = plan.noise_samples[-1]
        for place in plan.places:
            rounds: dict[str, list[list[dict]]] = {PETZVAL: [], CYCLES: []}
            for turn in range(plan.rounds):
                for program, found in rounds.items():
                    renders = [(1, 1), (samples, 2 * turn + 2), (samples, 2 * turn + 3)]
                    done = self._run(Job(program, "pinhole", plan.noise_size, renders, place, keep=True))
                    if done:
                        found.append(done)
            if all(rounds.values()):
                self.found["places"][place] = beside(rounds[PETZVAL], rounds[CYCLES], samples, plan.noise_size)

    def threads(self) -> None:
        """Wall seconds of the samples by one thread and by two."""
        plan, scene = self.plan, self.plan.scenes[0]
        for program in self.bench.programs():
            for threads in plan.threads:
                renders = [(1, 1), (1 + plan.samples, 2)]
                done = self._run(Job(program, "thin", plan.size, renders, scene, threads))
                if done:
                    kept = {key: done[1][key] - done[0][key] for key in ("wall_s", "user_s")}
                    self.found["threads"].setdefault(program, {})[str(threads)] = kept

    def rays(self) -> None:
        """Embree's rays, on the largest scene of the plan."""
        if LLVM in self.bench.programs():
            done = self._run(Job(LLVM, "rays", scene=self.plan.scenes[-1], threads=1))
            if done:
                self.found["rays"] = done[0] | {"scene": self.plan.scenes[-1]}


def beside(
    petzval: list[list[dict]], cycles: list[list[dict]], samples: int, size: tuple[int, int]
) -> dict[str, float]:
    """Microseconds of a sample of both, and Petzval's noise variance and time to equal noise over Cycles'. A render's own time is the
    quickest of all; the first one is of a single sample, and its time is that of work done once."""
    count = size[0] * size[1]
    sample_us, variance, means = [], [], []
    for rounds in (petzval, cycles):
        once = min(done[0]["user_s"] for done in rounds)
        most = min(one["user_s"] for done in rounds for one in done[1:])
        sample_us.append(1e6 * (most - once) / (count * (samples - 1)))
        pictures = np.stack([np.load(one["file"]).mean(-1) for done in rounds for one in done[1:]]).astype(np.float64)
        means.append(pictures.mean(0))
        variance.append(pictures.var(0, ddof=1))
    limit = 0.5 * (means[0] + means[1])
    floor = (noise.FLOOR * limit.mean()) ** 2
    own, other = (noise.trimmed_mean(one / (limit**2 + floor)) for one in variance)
    return {
        "petzval_us": sample_us[0], "cycles_us": sample_us[1], "mean": float(means[0].mean() / means[1].mean()),
        "noise": own / other, "time": own / other * sample_us[0] / sample_us[1],
    }  # fmt: skip


def _converged(pictures: list[np.ndarray]) -> np.ndarray:
    """The mean of the two halves, which come last."""
    return 0.5 * (pictures[-2].astype(np.float64) + pictures[-1])


def middle(rounds: list[dict], key: str) -> float | None:
    """The median of the rounds' results."""
    values = [one[key] for one in rounds if key in one]
    return median(values) if values else None


def ratio(rounds: list[dict], base: list[dict], key: str = "sampling_s") -> float | None:
    """The median of the rounds' own ratios: the machine may be slower in one round than in another."""
    pairs = list(zip(rounds, base, strict=False))
    return median(one[key] / other[key] for one, other in pairs) if pairs else None
