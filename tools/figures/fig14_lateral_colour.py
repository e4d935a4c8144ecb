# SPDX-License-Identifier: GPL-3.0-or-later
"""Lateral colour in the corner: a single meniscus behind its stop, and the same as an achromat. The paper traces one wavelength a lens."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .figure import Caption, Figure, Shot, Taken, claim
from .rays import Rays
from .scene import in_lens_space
from .sharpness import box

_FOLDER = Path(__file__).parent / "lenses"
LENSES = (("singlet", "a single meniscus"), ("achromat", "crown and flint"))
FOCAL_MM, F_NUMBER, FOCUS_MM = 100.0, 22.0, 6000.0
#: The whole film, a part of it, and the middle of that, mm: a chart's half 20 degrees to the right.
WHOLE_MM, PART_MM, AT_MM = (90.0, 60.0), (15.0, 10.0), (37.0, 3.0)
#: The lines of `--spectrum rgb` that stand for red and blue.
RED_NM, BLUE_NM = 611.4, 464.2
_PLAIN = ("--effect", "ghosts=off", "--effect", "glare=off", "--effect", "diffraction=off")
_SET = ("--focal-length", f"{FOCAL_MM:g}", "--f-number", f"{F_NUMBER:g}", "--focus-distance", f"{FOCUS_MM:g}")


def _film(size: tuple[float, float]) -> tuple[str, ...]:
    return ("--film", f"{size[0]:g}x{size[1]:g}")


def _shots() -> tuple[Shot, ...]:
    shots = []
    for kind, name in LENSES:
        lens = str(_FOLDER / f"landscape-{kind}.lens")
        shots.append(
            Shot(
                f"fig-14-{kind}", "eye_chart", lens, (*_SET, *_film(WHOLE_MM), *_PLAIN), label=name, is_only_shown=True
            )
        )
    part = (*_SET, *_film(PART_MM), "--shift", f"{AT_MM[0]:g},{AT_MM[1]:g}", *_PLAIN)
    for kind, name in LENSES:
        lens = str(_FOLDER / f"landscape-{kind}.lens")
        shots.append(
            Shot(
                f"fig-14-{kind}-part",
                "eye_chart",
                lens,
                part,
                label=f"{name}: {PART_MM[0]:g} mm of the film",
                samples=2.0,
                is_only_shown=True,
            )
        )
    for kind, _ in LENSES:
        lens = str(_FOLDER / f"landscape-{kind}.lens")
        shots.append(
            Shot(f"fig-14-{kind}-lines", "eye_chart", lens, (*part, "--spectrum", "rgb"), samples=4.0, is_hidden=True)
        )
    return tuple(shots)


def foretold_um(lens: str) -> float:
    """The distance of blue to the right of red, micrometres on the film, for the point whose red is in the middle of the part."""
    red, blue = (Rays(lens, FOCUS_MM, nm, focal_length_mm=FOCAL_MM, f_number=F_NUMBER) for nm in (RED_NM, BLUE_NM))
    # One film and one scale for both, those of the main wavelength.
    main = Rays(lens, FOCUS_MM, focal_length_mm=FOCAL_MM, f_number=F_NUMBER)
    red.film_z = blue.film_z = main.film_z

    def at(rays: Rays, x: float) -> float:
        return float(-rays.on_film(in_lens_space(np.array([x, 0.0, FOCUS_MM]), main.pupil_z), count=300)[:, 0].mean())

    low, high = 0.0, 0.6 * FOCUS_MM
    for _ in range(24):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if at(red, middle) < AT_MM[0] else (low, middle)
    return 1000.0 * (at(blue, low) - at(red, low))


def seen_um(picture: Taken) -> float:
    """The shift of blue to the right of red in the picture, micrometres on the film: the one that makes them most alike."""
    columns, lines = picture.size
    red, _, blue = (picture.light[..., k] for k in range(3))
    radius = max(columns // 40, 3)
    red, blue = (one / np.maximum(box(one, radius), 1e-6) - 1.0 for one in (red, blue))
    at = np.arange(columns)
    margin = columns // 12
    shifts = np.arange(-0.9 * margin, 0.9 * margin, 0.25)
    inside = slice(margin, columns - margin)
    alike = []
    for shift in shifts:
        moved = np.stack([np.interp(at + shift, at, row) for row in blue])
        alike.append(np.corrcoef(moved[:, inside].ravel(), red[:, inside].ravel())[0, 1])
    best = int(np.clip(np.argmax(alike), 1, len(shifts) - 2))
    before, here, after = alike[best - 1 : best + 2]
    found = shifts[best] + 0.5 * (before - after) / (before - 2.0 * here + after) * 0.25
    return float(1000.0 * found * PART_MM[0] / columns)


def read(taken: dict[str, Taken]) -> Caption:
    caption = Caption(
        head=("lens", f"blue against red by exact rays, {AT_MM[0]:g} mm from the middle", "in the picture")
    )
    per_px = 1000.0 * PART_MM[0] / taken["fig-14-singlet-lines"].size[0]
    found = {}
    for kind, name in LENSES:
        expected = foretold_um(str(_FOLDER / f"landscape-{kind}.lens"))
        found[kind] = seen_um(taken[f"fig-14-{kind}-lines"])
        caption.rows.append((name, f"{expected:+.0f} µm", f"{found[kind]:+.0f} µm"))
        # A quarter of a pixel, and what the part's two sides differ by.
        claim(
            abs(found[kind] - expected) < 0.25 * per_px + 0.1 * abs(expected),
            f"{name}: blue lies {found[kind]:.1f} µm from red, by exact rays {expected:.1f}",
        )
    claim(abs(found["achromat"]) < 0.2 * abs(found["singlet"]), f"the achromat leaves as much lateral colour: {found}")
    caption.sentences = [
        f"Two landscape lenses of {FOCAL_MM:g} mm at f/{F_NUMBER:g} with their stop before them, which parts colours towards the corners. Cemented of crown and flint, "
        "the lens has next to none of it. Measured between the red and the blue of `--spectrum rgb`."
    ]
    return caption


FIGURE = Figure("fig-14", "Figure 14: lateral colour, before and after an achromat", _shots(), read)
