# SPDX-License-Identifier: GPL-3.0-or-later
"""Figure 10: the film swung by 10 and 20 degrees behind two lenses; one row of chess pieces and a strip of marquetry, all at
one depth."""

from __future__ import annotations

import math

import numpy as np

from .figure import Caption, Figure, Shot, Taken, claim
from .rays import Rays
from .scene import in_lens_space, places_mm
from .sharpness import contrast_by_column

FILM_MM = (40.0, 20.0)
FOCAL_MM, FOCUS_MM = 80.0, 800.0
#: Lens, its name in the picture, f-number.
LENSES = (("double-gauss-f2-tronnier", "double Gauss", 2.02), ("angenieux-retrofocus-r1", "retrofocus", 3.0))
SWINGS_DEG = (10.0, 20.0)
#: Half of the strip's height, and of its width, m.
LIFT, HALF = 0.007, 0.24
#: The largest offset of the sharpest column from its place by exact rays, as a part of the band in which spots are at most twice their
#: smallest.
NEAR = 0.6


def _options(lens: str, f_number: float, swing: float) -> tuple[str, ...]:
    film = f"{FILM_MM[0]:g}x{FILM_MM[1]:g}"
    return (
        "--focal-length", f"{FOCAL_MM:g}", "--film", film, "--focus-distance", f"{FOCUS_MM:g}", "--swing", f"{swing:g}",
        "--f-number", f"{f_number:g}", "--effect", "diffraction=off", "--effect", "ghosts=off", "--effect", "glare=off",
    )  # fmt: skip


def _shots() -> list[Shot]:
    shots = []
    for lens, name, f_number in LENSES:
        for swing in SWINGS_DEG:
            label = f"{name}, f/{f_number:g}, swing {swing:g}°"
            key = f"fig-10-{name.replace(' ', '-')}-{swing:g}"
            shots.append(Shot(key, "chess", lens, _options(lens, f_number, swing), "row", label, 2.0, 1.5, 4.0))
            # By other random numbers: their noise has nothing in common.
            shots.append(
                Shot(
                    f"{key}-sharp",
                    "chess",
                    lens,
                    (*_options(lens, 32.0, swing), "--seed", "7"),
                    "row",
                    "",
                    2.0,
                    1.5,
                    4.0,
                    is_hidden=True,
                )
            )
    return shots


def foretold(
    strip: np.ndarray, lens: str, f_number: float, swing_rad: float, mm_per_px: float
) -> tuple[np.ndarray, ...]:
    """Places along the film, mm to the right of the picture's middle; the contrast by exact rays there of detail some pixels
    wide in the strip; and the size (root mean square, mm) of their spots."""
    rays = Rays(lens, FOCUS_MM, focal_length_mm=FOCAL_MM, f_number=f_number)
    waves = 2.0 * np.pi / (mm_per_px * np.array([4.0, 6.0, 9.0]))
    at, left, size = [], [], []
    for x in np.linspace(-1e3 * HALF, 1e3 * HALF, 71):
        hits = rays.on_film(in_lens_space(strip + [x, 0.0, 0.0], rays.pupil_z), swing_rad, 500)
        if len(hits) < 50:
            continue
        away = hits - hits.mean(0)
        at.append(-hits[:, 0].mean())
        left.append(np.mean([abs(np.exp(1j * wave * away[:, k]).mean()) for wave in waves for k in (0, 1)]))
        size.append(math.sqrt((away**2).sum(1).mean()))
    order = np.argsort(at)
    fine = np.linspace(-0.5 * FILM_MM[0], 0.5 * FILM_MM[0], 2001)
    return fine, *(np.interp(fine, np.array(at)[order], np.array(values)[order]) for values in (left, size))


def seen(picture: Taken, sharp: Taken, rows: slice, fine: np.ndarray, left: np.ndarray) -> float:
    """The shift of the band of sharpness to the right of its place by exact rays, mm: the shift at which the contrast by these rays is
    most like that of the columns."""
    columns, _ = picture.size
    found = contrast_by_column(picture.light, sharp.light, rows, max(columns // 160, 2), columns // 32)
    at = ((np.arange(columns) + 0.5) / columns - 0.5) * FILM_MM[0]
    shifts = np.arange(-8.0, 8.001, 0.05)
    alike = [np.corrcoef(np.interp(at - shift, fine, left), found)[0, 1] for shift in shifts]
    return float(shifts[int(np.argmax(alike))])


def read(taken: dict[str, Taken]) -> Caption:
    strip = places_mm(next(iter(taken.values())).blend, "Strip", LIFT)["Strip"]
    caption = Caption(
        [
            f"Both lenses have {FOCAL_MM:g} mm and stand {strip[2] / 1000.0:.2f} m before the strip; the film's middle is "
            f"focused at {FOCUS_MM / 1000.0:g} m, so that the swung film meets the strip's image beside it: there, and nowhere else, the strip is "
            "sharp. Swung twice as far, the band is half as wide, and half as far from the middle."
        ],
        ("picture", "sharpest by exact rays", "sharpest in the picture", "spots at most twice as large over"),
    )
    for lens, name, f_number in LENSES:
        at = {}
        for swing in SWINGS_DEG:
            key = f"fig-10-{name.replace(' ', '-')}-{swing:g}"
            picture, sharp = taken[key], taken[f"{key}-sharp"]
            _, lines = picture.size
            # The strip's own: the board before and behind it is sharp elsewhere.
            scale = FOCAL_MM / FILM_MM[1] / strip[2] * lines
            middle = 0.5 * lines - scale * strip[1]
            rows = slice(round(middle - 800.0 * LIFT * scale), round(middle + 800.0 * LIFT * scale) + 1)
            mm_per_px = FILM_MM[0] / picture.size[0]
            fine, left, size = foretold(strip, lens, f_number, math.radians(swing), mm_per_px)
            expected = float(fine[left.argmax()])
            found = at[swing] = expected + seen(picture, sharp, rows, fine, left)
            band = float((size <= 2.0 * size.min()).sum() * (fine[1] - fine[0]))
            caption.rows.append((picture.shot.label, f"{expected:+.1f} mm", f"{found:+.1f} mm", f"{band:.1f} mm"))
            claim(
                abs(found - expected) < NEAR * band,
                f"{picture.shot.label}: sharpest at {found:+.2f} mm, where exact rays have {expected:+.2f} mm",
            )
        claim(
            abs(at[20.0]) < abs(at[10.0]), f"{name}: a larger swing leaves the sharp band as far from the middle: {at}"
        )
    return caption


FIGURE = Figure("fig-10", "Figure 10: a swung film", tuple(_shots()), read)
