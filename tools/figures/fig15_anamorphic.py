# SPDX-License-Identifier: GPL-3.0-or-later
"""An anamorphic lens: lamps out of focus are upright ovals, and a bare lamp flares between the uncoated surfaces of its cylinders."""

from __future__ import annotations

import numpy as np

from .blur import moments
from .figure import Caption, Figure, Shot, Taken, claim, luminance
from .rays import LINE_NM, Rays
from .scene import in_lens_space, places_mm

LENS, FOCUS_MM, FILM_MM, SQUEEZE = "anamorphic-2x-front-focus", 2700.0, (22.0, 18.6), 2.0
#: A lamp that no other's blur touches, how wide it is, where its image is on the film, and a part of the film about it, mm.
LAMP, LAMP_RADIUS_MM, AT_MM, PART_MM = "Lamp in the hedge 24", 8352.0 * 0.0030 * 0.6, (8.38, -4.51), (2.4, 4.6)
_SET = ("--focus-distance", f"{FOCUS_MM:g}", "--coating", "none")
_STRAY = tuple(word for name in ("ghosts", "glare", "diffraction") for word in ("--effect", f"{name}=off"))


def _shots() -> tuple[Shot, ...]:
    whole = ("--film", f"{FILM_MM[0]:g}x{FILM_MM[1]:g}")
    part = ("--film", f"{PART_MM[0]:g}x{PART_MM[1]:g}", "--shift", f"{AT_MM[0]:g},{AT_MM[1]:g}", "--samples", "1024", "--spectrum", f"{LINE_NM:g}")
    shape = FILM_MM[0] / FILM_MM[1]
    many = ("--min-samples", "16", "--noise-threshold", "0.05")
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
    flare = luminance(taken["fig-15-flare"].light) - luminance(taken["fig-15-none"].light)
    kept = taken["fig-15-flare"].stats["ghosts"]
    claim(flare.sum() > 0.0 and flare.min() > -1e-4, "ghosts add no light")
    brightest = float(np.quantile(flare, 0.999))
    row, column = np.unravel_index(int(flare.argmax()), flare.shape)
    _ = (row, column)
    return Caption(
        [
            f"Focused at {FOCUS_MM / 1000.0:g} m by the lens's front pair; the lamp by itself is {place[2] / 1000.0:.1f} m away. On the film its blur "
            f"is {found[0]:.3f} mm wide and {found[1]:.3f} mm high (root mean square), by exact rays {expected[0]:.3f} and "
            f"{expected[1]:.3f}; shown {SQUEEZE:g} times as wide it is an upright oval, {shown:.2f} times as wide as high "
            f"({foreseen:.2f} by exact rays). Focal lengths are {rays.info['efl_mm']:.0f} mm upright and "
            f"{rays.info['section_x']['efl_mm']:.0f} mm across. Of the bare lamp {kept} ghosts were traced; the brightest part of the "
            f"picture that they cover has {brightest:.2g} of the exposure."
        ]
    )


FIGURE = Figure("fig-15", "Ovals and flare: an anamorphic lens", _shots(), read, 1)
