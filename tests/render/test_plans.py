# SPDX-License-Identifier: GPL-3.0-or-later
"""What a plan leaves out is not seen: its own choice beside everything on, all wavelengths, over many lenses and scenes."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import sys

import numpy as np
import pytest

from support.places import ROOT

try:
    import bpy  # noqa: F401
except ImportError:
    SCENES = {}
else:
    from plan_scenes import SCENES

pytestmark = pytest.mark.once

#: Wide and long, old and new, with mirrors, aspheres, cylinders, one with colours that nothing corrects.
LENSES = (
    "wide-angle-smith-f3.4", "double-gauss-f2-tronnier", "cellphone-5.6mm-f3.5", "tessar-brendel", "cooke-triplet-50mm",
    "biotar-1927", "hologon-15-f8", "laikin-fisheye-170", "laikin-telephoto-5in", "reflex-nikkor-500-f8",
    "anamorphic-2x-double-gauss", "biconvex-50mm",
)  # fmt: skip
WIDTH, HEIGHT = 96, 64
#: All lenses see from about the same place: their size is changed to this focal length.
FOCAL_MM = 30.0
#: Of the picture's corner, at most: beyond, small pictures of the scenes show little but the foreground.
WIDEST_RAD = math.radians(30.0)
#: A third of the pictures are taken with so little of the film, stopped down: there most of a lens cannot be seen, and simpler
#: cameras do.
NARROW_MM, NARROW_F_NUMBER = 4.0, 16.0
#: The mirror in its middle hides all of the pupil beyond f/11.
NARROWEST = {"reflex-nikkor-500-f8": 8.0}
#: Independent renders of each picture, by the same seeds for both, and samples a pixel in each.
SEEDS, SAMPLES = 4, 10
#: The stated tolerances at quality 1 (design.md, section 5).
PIXELS, STOPS, EXPOSURE = 0.5, 1.0 / 50.0, 1.0 / 255.0
#: Standard errors that noise may add. They are estimated from four renders and the eight pixels around: 27 degrees of
#: freedom, where 4 standard errors are passed once in 2000 times by well-behaved noise.
SURE = 4.0
#: Of the pixels, how many more may lie outside than where the full lens is held against itself. Noise is not well behaved
#: where a few paths carry the light, so the same question to two independent pictures of the full lens says how many
#: pixels it takes out. Three in a thousand is 18 pixels: what that number itself varies by.
OUTSIDE = 0.003


def settings_of(lens: str, native, subject, focus_m: float | None, is_narrow: bool = False):
    """The scene's camera with this lens, wide open on as much film as it fills, or stopped down on a little of it."""
    from petzval.description import LensSettings, changed, focal_length

    path = ROOT / "lenses" / f"{lens}.lens"
    info = json.loads(native.Lens(str(path)).info_json(LensSettings(focal_length(FOCAL_MM))))
    # Where half of the light still comes; a lens that does not say so by a stop of its own gets a small field.
    half_field = min(math.radians(info["half_vignetted_field_deg"] or 15.0), WIDEST_RAD)
    diagonal = 2.0 * FOCAL_MM * math.tan(0.9 * half_field)
    if is_narrow:
        diagonal = min(diagonal, NARROW_MM)
    size = [diagonal * side / math.hypot(WIDTH, HEIGHT) for side in (WIDTH, HEIGHT)]
    narrow = max(NARROWEST.get(path.stem, NARROW_F_NUMBER), info["f_number"]) if is_narrow else None
    film = {"film.width_mm": size[0], "film.height_mm": size[1]}
    focus = {"focus.distance": focus_m, "focus.point_world": None}
    lens_settings = LensSettings(focal_length(FOCAL_MM), narrow)
    return changed(subject.camera, {"model": "LENS", "lens_path": str(path), "lens": lens_settings} | film | focus)


class Pictures:
    """Of one plan: (SEEDS, height, width, 3), and what was done."""

    def __init__(self, native, subject, camera, wishes, first_seed: int, samples: int) -> None:
        settings = dataclasses.replace(subject.settings, samples=samples)
        self.plan = native.Plan(subject.scene, camera, settings, [], **wishes)
        self.planned = json.loads(self.plan.json())
        taken = []
        for seed in range(first_seed, first_seed + SEEDS):
            job = native.Job(subject.scene, camera, dataclasses.replace(settings, seed=seed), [], plan=self.plan)
            while not job.wait(1.0):
                pass
            self.stats = json.loads(job.stats_json())
            assert self.stats["failure"] is None and self.stats["non_finite_samples"] == 0
            taken.append(job.image()[..., :3].astype(np.float64))
        self.each = np.array(taken)
        self.mean = self.each.mean(0)

    @property
    def choice(self) -> dict:
        return self.planned["camera"]

    def variance(self) -> np.ndarray:
        """Of the mean, smoothed over the pixels around."""
        return around(self.each.var(0, ddof=1) / SEEDS).mean(0)


def around(picture: np.ndarray) -> np.ndarray:
    """Each pixel and its eight neighbours, edges repeated: (9, height, width, 3)."""
    padded = np.pad(picture, ((1, 1), (1, 1), (0, 0)), mode="edge")
    height, width = picture.shape[:2]
    return np.array([padded[y : y + height, x : x + width] for y in range(3) for x in range(3)])


def outside(picture: Pictures, full: Pictures) -> float:
    """The part of the pixels that lie where light moved by half a pixel cannot bring them.

    A pixel of a picture whose light has moved by less than a pixel lies between the least and the most of the nine around it;
    half a pixel of blur or shift is well inside. That range is widened by a 255th of the exposure (what may be left out
    of light), by a fiftieth of a stop (of brightness), and by the noise of both.
    """
    exposure = full.mean.mean()
    nine = around(full.mean)
    slack = SURE * np.sqrt(picture.variance() + full.variance()) + EXPOSURE * exposure
    low, high = nine.min(0) * 2.0**-STOPS - slack, nine.max(0) * 2.0**STOPS + slack
    return float(((picture.mean < low) | (picture.mean > high)).any(-1).mean())


def products(each: np.ndarray) -> np.ndarray:
    """The square of what independent pictures tend to, without their noise: the mean of the products of all pairs."""
    count = len(each)
    return (each.sum(0) ** 2 - (each**2).sum(0)) / (count * (count - 1))


def moved(picture: Pictures, full: Pictures) -> tuple[float, float, float]:
    """Mean relative squares over the picture: by how much it differs, the standard error of that, and what is allowed.

    One pixel's noise hides much; the mean over all of them does not. Light moved by half a pixel changes a pixel by half
    of what it differs from its neighbour, along both axes; brightness may be off by a fiftieth of a stop, and light left
    out by a 255th of the exposure. Both sides are free of noise, as products of independent pictures.
    """
    exposure = full.mean.mean()
    # In parts of each pixel's brightness, or a few highlights would decide what is allowed everywhere.
    either = around(full.mean).mean(0) ** 2 + around(picture.mean).mean(0) ** 2
    weight = 1.0 / (either + exposure**2)
    differs = (products(picture.each - full.each) * weight).mean(-1)
    down = products(np.diff(full.each, axis=1)) * np.minimum(weight[1:], weight[:-1])
    across = products(np.diff(full.each, axis=2)) * np.minimum(weight[:, 1:], weight[:, :-1])
    dimmed = (2.0**STOPS - 1.0) ** 2 * (products(full.each) * weight).mean()
    allowed = PIXELS**2 * (down.mean() + across.mean()) + dimmed + EXPOSURE**2
    # Neighbours share light by the pixel's filter: about two count as one.
    error = math.sqrt(2.0 * differs.var() / differs.size)
    return float(differs.mean()), error, float(max(allowed, 0.0))


def brightness(picture: Pictures) -> tuple[float, float]:
    """The mean of the picture, and its standard error."""
    means = picture.each.mean((1, 2, 3))
    return means.mean(), means.std(ddof=1) / math.sqrt(SEEDS)


def compare(lens: str, native, subject, focus_m: float | None, samples: int, is_narrow: bool) -> list[str]:
    """What is wrong with the plan's choice for one lens."""
    camera = settings_of(lens, native, subject, focus_m, is_narrow)
    available = [one["name"] for one in json.loads(native.effects_json()) if one["is_available"]]
    everything = {"effects": dict.fromkeys(available, "on"), "quality": 100.0}
    full = Pictures(native, subject, camera, everything, 0, samples)
    auto = Pictures(native, subject, camera, {"effects": {}, "quality": 1.0}, 0, samples)
    wrong = []

    lost, by_noise = outside(auto, full), 0.0
    if lost > OUTSIDE:
        by_noise = outside(Pictures(native, subject, camera, everything, SEEDS, samples), full)
    if lost > by_noise + OUTSIDE:
        wrong.append(
            f"{lost:.2%} of the pixels are not what light moved by half a pixel explains ({by_noise:.2%} by noise)"
        )
    differs, error, allowed = moved(auto, full)
    if differs > allowed + SURE * error:
        wrong.append(
            f"it differs by {math.sqrt(differs):.3f}; half a pixel and a fiftieth of a stop explain "
            f"{math.sqrt(allowed):.3f}"
        )
    (ours, ours_error), (theirs, theirs_error) = brightness(auto), brightness(full)
    # Half a pixel at the picture's edge moves light in and out: of its width and height, that part.
    across = PIXELS / WIDTH + PIXELS / HEIGHT
    allowed = (2.0**STOPS - 1.0 + across) * theirs + EXPOSURE * theirs + SURE * math.hypot(ours_error, theirs_error)
    if abs(ours - theirs) > allowed:
        wrong.append(f"brightness {ours:.4f} rather than {theirs:.4f}, {allowed:.4f} allowed")
    wrong += never_slower(auto, full) + only_what_is_on(auto)
    return [f"{lens} ({describe(auto)}): {line}" for line in wrong]


def describe(one: Pictures) -> str:
    choice = one.choice
    return f"{choice['model']}, {choice['wavelengths']} wavelengths, {one.stats['pipeline']}"


def never_slower(auto: Pictures, full: Pictures) -> list[str]:
    """By what is counted, not by the clock: no more samples, wavelengths and rays for a sample that came through."""
    wrong = []
    if auto.choice["wavelengths"] > full.choice["wavelengths"]:
        wrong.append(f"more wavelengths than everything on: {full.choice['wavelengths']}")
    if auto.stats["camera_rays"] > full.stats["camera_rays"]:
        wrong.append("more camera rays than everything on")

    def rays(one: Pictures) -> float:
        return one.stats["rays"] / (one.stats["camera_rays"] - one.stats["camera_rays_lost"])

    # Paths are as long; that they are other paths makes a few in a hundred of difference at so few samples.
    if rays(auto) > 1.05 * rays(full):
        wrong.append(f"{rays(auto):.3f} rays a path, everything on has {rays(full):.3f}")
    return wrong


def only_what_is_on(one: Pictures) -> list[str]:
    """Code for what is left out did not run, as far as the statistics tell."""
    wrong = []
    on = {row["effect"] for row in one.planned["effects"] if row["decision"] == "on"}
    traced = one.stats["precision"] is not None
    if one.choice["model"] != "exact" and (traced or on & {"aberration", "distortion", "vignetting"}):
        wrong.append("a lens was traced that was not called for")
    if one.choice["model"] == "exact" and not traced:
        wrong.append("no lens was traced")
    # The densities of rays that light tracing asks for are those of the hero pipeline, with one wavelength too.
    is_plain = one.stats["pipeline"] == "film" or one.stats["light_tracing"]["lights"] > 0
    if one.choice["wavelengths"] == 1 and (not is_plain or on & {"lateral_colour", "axial_colour"}):
        wrong.append("one wavelength, but packets of them were carried")
    if one.choice["model"] == "pinhole" and "defocus" in on:
        wrong.append("a pinhole that blurs")
    return wrong


def subject_of(blender, name: str, size: tuple[int, int]):
    """Everything that a render of the scene is made of, as the engine is handed it."""
    one = SCENES[name]
    one.open()
    scene = blender.context.scene
    scene.render.engine = "PETZVAL"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = *size, 100
    scene.petzval.max_bounces, scene.petzval.use_blue_noise = 3, False
    found = []
    watch = sys.modules["petzval_addon"].render.loop.WATCH
    watch.study = found.append
    try:
        blender.ops.render.render(scene=scene.name)
    finally:
        watch.study = None
    return found[0], one.focus_m


#: In each scene a sixth of the lenses in `make test`: over the scenes all of them, wide open and stopped down; the others as recipes.
SIXTHS = [pytest.param(0), *(pytest.param(sixth, marks=pytest.mark.recipe) for sixth in range(1, 6))]


@pytest.mark.parametrize("sixth", SIXTHS)
@pytest.mark.parametrize("name", SCENES)
def test_auto_is_as_good_as_everything_on(blender, name, sixth):
    from petzval import _native

    subject, focus_m = subject_of(blender, name, (WIDTH, HEIGHT))
    # A third of the lenses in each scene stopped down on a little film: one of three that follow each other.
    first = list(SCENES).index(name)
    wrong = []
    for i, lens in enumerate(LENSES):
        if (i // 2 + first) % 6 == sixth:
            wrong += compare(lens, _native, subject, focus_m, SAMPLES, (i + first) % 3 == 0)
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize(("name", "effect"), [("room", "vignetting"), ("macro", "defocus"), ("chart", "vignetting")])
def test_what_is_left_out_wrongly_is_seen(blender, name, effect):
    """The test's own test, with no more samples than that has: corners as bright as the middle; five pixels of blur."""
    from petzval import _native

    subject, focus_m = subject_of(blender, name, (WIDTH, HEIGHT))
    camera = settings_of("double-gauss-f2-tronnier", _native, subject, focus_m)
    full = Pictures(_native, subject, camera, {"effects": {}, "quality": 1.0}, 0, SAMPLES)
    less = Pictures(_native, subject, camera, {"effects": {effect: "off"}, "quality": 1.0}, 0, SAMPLES)
    differs, error, allowed = moved(less, full)
    assert differs > allowed + SURE * error
    if effect == "vignetting":
        assert outside(less, full) > 10.0 * OUTSIDE


@pytest.mark.slow
@pytest.mark.skipif(not os.environ.get("PETZVAL_ALL_LENSES"), reason="takes minutes: set PETZVAL_ALL_LENSES")
@pytest.mark.parametrize("name", SCENES)
def test_auto_is_as_good_with_every_lens(blender, name):
    from petzval import _native

    subject, focus_m = subject_of(blender, name, (WIDTH, HEIGHT))
    lenses = sorted(path.stem for path in (ROOT / "lenses").glob("*.lens"))
    wrong = []
    for lens in lenses:
        try:
            for is_narrow in (False, True):
                wrong += compare(lens, _native, subject, focus_m, 4 * SAMPLES, is_narrow)
        except _native.PetzvalError as error:
            # Some lenses cannot be focused so near, see nothing there, or cannot be had at this size.
            if not any(
                word in str(error)
                for word in ("focus", "zooms from", "larger than the retina", "no light gets through")
            ):
                wrong.append(f"{lens}: {error}")
    assert not wrong, "\n".join(wrong)
