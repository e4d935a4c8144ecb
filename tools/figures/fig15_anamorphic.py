# SPDX-License-Identifier: GPL-3.0-or-later
"""An anamorphic lens: lamps out of focus are upright ovals, and a bare lamp flares between the uncoated surfaces of its cylinders."""

from __future__ import annotations

import numpy as np

from .blur import moments
from .figure import Caption, Figure, Shot, Taken, claim, luminance
from .rays import LINE_NM, Rays
from .scene import in_lens_space, places_mm

LENS, FOCUS_MM, FILM_MM, SQUEEZE = "anamorphic-2x-front-focus", 3870.0, (22.0, 18.6), 2.0
#: A lamp that no other's blur touches, its width, the place of its image on the film, and a part of the film about it, mm.
LAMP, LAMP_RADIUS_MM, AT_MM, PART_MM = "Lamp in the hedge 24", 7432.0 * 0.0030 * 0.6, (6.81, -4.57), (1.4, 2.8)
#: The lamp that flares.
BARE = "Bare lamp 0"
_SET = ("--focus-distance", f"{FOCUS_MM:g}", "--coating", "none")
_STRAY = tuple(word for name in ("ghosts", "glare", "diffraction") for word in ("--effect", f"{name}=off"))


def _shots() -> tuple[Shot, ...]:
    whole = ("--film", f"{FILM_MM[0]:g}x{FILM_MM[1]:g}")
    part = (
        "--film",
        f"{PART_MM[0]:g}x{PART_MM[1]:g}",
        "--shift",
        f"{AT_MM[0]:g},{AT_MM[1]:g}",
        "--samples",
        "1024",
        "--spectrum",
        f"{LINE_NM:g}",
    )
    shape = FILM_MM[0] / FILM_MM[1]
    many = ("--min-samples", "64", "--noise-threshold", "0.03")
    return (
        Shot("fig-15-garden", "lights", LENS, (*_SET, *whole, *many), "wide", "anamorphic 2x, f/2, without coatings, widened", shape, samples=8.0, widened=SQUEEZE, is_only_shown=True),
        Shot("fig-15-lamp", "lights", LENS, (*_SET, *part, *_STRAY), "wide", "a lamp", PART_MM[0] / PART_MM[1], width=0.25, is_hidden=True),
        Shot("fig-15-flare", "lights", LENS, (*_SET, *whole, "--samples", "4", *_STRAY[2:], "--effect", "ghosts=on"), "wide", "with ghosts", shape, width=0.5, is_hidden=True),
        Shot("fig-15-none", "lights", LENS, (*_SET, *whole, "--samples", "4", *_STRAY), "wide", "without", shape, width=0.5, is_hidden=True),
    )  # fmt: skip


def read(taken: dict[str, Taken]) -> Caption:
    picture = taken["fig-15-lamp"]
    rays = Rays(LENS, FOCUS_MM)
    place = places_mm(picture.blend, LAMP)[LAMP]

    def spot(aside_mm: tuple[float, float]) -> np.ndarray:
        return rays.on_film(in_lens_space(place + [*aside_mm, 0.0], rays.pupil_z), 0.0, 12000, 1.6)

    hits = spot((0.0, 0.0))
    # A round lamp's own width is added: a disc's root mean square is half of its radius.
    moved = [abs(spot(aside).mean(0) - hits.mean(0)) for aside in ((LAMP_RADIUS_MM, 0.0), (0.0, LAMP_RADIUS_MM))]
    lamp = [moved[0][0], moved[1][1]]
    expected = [float(np.hypot(hits[:, k].std(), 0.5 * lamp[k])) for k in (0, 1)]
    found = [value * PART_MM[k] / picture.size[k] for k, value in enumerate(moments(picture.light))]
    for name, a, b in zip(("width", "height"), found, expected, strict=True):
        # The smallest picture has 30 pixels of it, and its noise hides a little of the rim.
        claim(abs(a / b - 1.0) < 0.07, f"the root mean square {name} of the blur is {a:.3f} mm, by exact rays {b:.3f}")
    shown, foreseen = SQUEEZE * found[0] / found[1], SQUEEZE * expected[0] / expected[1]
    claim(shown < 0.7, f"a lamp is {shown:.2f} times as wide as high: no upright oval")
    distances = np.arange(0.75, 1.1, 0.02) * FOCUS_MM
    spots = [rays.on_film(np.array([0.0, 0.0, rays.pupil_z - d]), 0.0, 3000).std(0) for d in distances]
    sharpest = float(distances[np.argmin([np.hypot(*one) for one in spots])])
    flare = luminance(taken["fig-15-flare"].light) - luminance(taken["fig-15-none"].light)
    kept = taken["fig-15-flare"].stats["ghosts"]
    claim(flare.min() > -0.01 * flare.max(), "ghosts take light away")
    # Cylinders spread what they reflect across; upright they are planes, and it stays at the lamp's height.
    at = places_mm(picture.blend, BARE)[BARE]
    height_mm = -rays.on_film(in_lens_space(at, rays.pupil_z), 0.0, 12000, 1.6)[:, 1].mean()
    rows = flare.mean(axis=1)
    streak = int(rows.argmax())
    off_mm = (0.5 - (streak + 0.5) / len(rows)) * FILM_MM[1] - height_mm
    claim(abs(off_mm) < 0.03 * FILM_MM[1], f"the streak stands {off_mm:.2f} mm above the lamp that makes it")
    stands_out = float(rows[streak] / np.median(rows))
    claim(stands_out > 2.0, f"the streak has {stands_out:.1f} times the light of the other ghosts")
    least = float(flare[streak].min() / np.median(flare[streak]))
    claim(least > 0.5, f"the streak fades to {least:.2f} of its brightness before the picture ends")
    return Caption(
        [
            f"Set to {FOCUS_MM / 1000.0:g} m by the lens's front pair; wide open what is {sharpest / 1000.0:.1f} m away is sharpest, by exact rays. The lamp by itself is {place[2] / 1000.0:.1f} m away. On the film its blur "
            f"is {found[0]:.3f} mm wide and {found[1]:.3f} mm high (root mean square), by exact rays {expected[0]:.3f} and "
            f"{expected[1]:.3f}; shown {SQUEEZE:g} times as wide it is an upright oval, {shown:.2f} times as wide as high "
            f"({foreseen:.2f} by exact rays). Focal lengths are {rays.info['efl_mm']:.0f} mm upright and "
            f"{rays.info['section_x']['efl_mm']:.0f} mm across. Of "
            f"{kept['found']} ghosts of its brightest sources {kept['simulated']} are simulated; the others could add {kept['left_out']:.1g} "
            f"to a pixel at most. Those between cylinders make a streak from side to side, {abs(off_mm):.2f} mm beside the height of the bare lamp "
            f"on the film, {stands_out:.1f} times as bright as what lies beside it."
        ]
    )


FIGURE = Figure("fig-15", "Figure 15: ovals and flare of an anamorphic lens", _shots(), read, 1)
