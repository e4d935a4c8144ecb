# SPDX-License-Identifier: GPL-3.0-or-later
"""Figure 8: the field of view by focal length, and by the film's size."""

from __future__ import annotations

import math

import numpy as np

from .figure import Caption, Figure, Shot, Taken, claim, luminance
from .rays import Rays
from .sharpness import box

LENS, F_NUMBER, FOCUS_MM, ASPECT = "wide-angle-smith-f3.4", 8.0, 1370.0, 4.0 / 3.0
#: Focal length and film's diagonal, mm, in pairs.
PAIRS = (((100.0, 30.0), (80.0, 30.0)), ((60.0, 50.0), (60.0, 80.0)))
#: The tolerance of the scale of one picture of a pair over the other.
NEAR = 0.005


def _name(setting: tuple[float, float]) -> str:
    return f"fig-08-{setting[0]:g}-{setting[1]:g}"


def _shot(setting: tuple[float, float]) -> Shot:
    focal, diagonal = setting
    film = f"{diagonal * 0.8:g}x{diagonal * 0.6:g}"
    options = (
        "--focal-length",
        f"{focal:g}",
        "--film",
        film,
        "--f-number",
        f"{F_NUMBER:g}",
        "--focus-distance",
        f"{FOCUS_MM:g}",
    )
    label = f"focal length {focal:g} mm, film {diagonal:g} mm across"
    return Shot(_name(setting), "chess", LENS, (*options, "--effect", "glare=off"), "table", label, ASPECT)


def chief_rays(focal: float, angles: np.ndarray) -> np.ndarray:
    """Distance from the film's middle, mm, at which light of the plane in focus arrives that came at these angles to the axis."""
    rays = Rays(LENS, FOCUS_MM, focal_length_mm=focal, f_number=F_NUMBER)
    points = [np.array([FOCUS_MM * math.tan(angle), 0.0, rays.pupil_z - FOCUS_MM]) for angle in angles]
    return np.array([-rays.on_film(point, count=300)[:, 0].mean() for point in points])


def scale_between(
    first: Taken, second: Taken, radii: tuple[np.ndarray, np.ndarray], film_mm: tuple[float, float]
) -> float:
    """The factor by which the second picture has to be enlarged beyond that of chief rays, so that it is most like the first. `radii` are
    those of the same angles on the two films."""
    (columns, lines), mm_per_px = first.size, film_mm[0] * 0.8 / first.size[0]
    x, y = (np.arange(columns) - 0.5 * columns + 0.5) * mm_per_px, (np.arange(lines) - 0.5 * lines + 0.5) * mm_per_px
    away = np.hypot(x[None, :], y[:, None])
    onto = np.interp(away, *radii) / np.maximum(away, 1e-9)
    light = np.log(luminance(first.light) + 1e-3)
    detail = light - box(light, columns // 24)
    other = np.log(luminance(second.light) + 1e-3)
    per_mm = second.size[0] / (film_mm[1] * 0.8)

    def alike(scale: float) -> float:
        column = scale * onto * x[None, :] * per_mm + 0.5 * second.size[0] - 0.5
        line = scale * onto * y[:, None] * per_mm + 0.5 * second.size[1] - 0.5
        moved = sampled(other, column, line)
        inside = np.isfinite(moved)
        moved = np.where(inside, moved, 0.0)
        moved = moved - box(moved, columns // 24)
        return float(np.corrcoef(detail[inside], moved[inside])[0, 1])

    scales = np.linspace(0.97, 1.03, 61)
    found = np.array([alike(scale) for scale in scales])
    best = int(np.clip(found.argmax(), 1, len(scales) - 2))
    before, at, after = found[best - 1 : best + 2]
    return float(scales[best] + 0.5 * (before - after) / (before - 2.0 * at + after) * (scales[1] - scales[0]))


def sampled(picture: np.ndarray, column: np.ndarray, line: np.ndarray) -> np.ndarray:
    """Between pixels' middles, linear; NaN outside."""
    i, j = np.floor(line).astype(int), np.floor(column).astype(int)
    inside = (i >= 0) & (j >= 0) & (i < picture.shape[0] - 1) & (j < picture.shape[1] - 1)
    i, j = np.where(inside, i, 0), np.where(inside, j, 0)
    v, u = line - i, column - j
    above = (1.0 - u) * picture[i, j] + u * picture[i, j + 1]
    below = (1.0 - u) * picture[i + 1, j] + u * picture[i + 1, j + 1]
    return np.where(inside, (1.0 - v) * above + v * below, np.nan)


def read(taken: dict[str, Taken]) -> Caption:
    angles = np.radians(np.linspace(0.0, 37.0, 75))
    caption = Caption(
        head=("picture", "field by exact rays", "by focal length and film alone", "scale against its pair, rays = 1")
    )
    fields = {}
    for pair in PAIRS:
        films = [chief_rays(focal, angles) for focal, _ in pair]
        for setting, film in zip(pair, films, strict=True):
            claim(
                np.isfinite(film).all() and bool((np.diff(film) > 0.0).all()),
                f"{setting}: chief rays do not order the field",
            )
            fields[setting] = 2.0 * math.degrees(float(np.interp(0.5 * setting[1], film, angles)))
        pictures = [taken[_name(setting)] for setting in pair]
        scale = scale_between(*pictures, tuple(films), (pair[0][1], pair[1][1]))
        for setting, said in zip(pair, ("", f"{scale:.4f}"), strict=True):
            plain = 2.0 * math.degrees(math.atan(0.5 * setting[1] / setting[0]))
            caption.rows.append((taken[_name(setting)].shot.label, f"{fields[setting]:.1f}°", f"{plain:.1f}°", said))
        claim(abs(scale - 1.0) < NEAR, f"{pair}: the pictures' scales are {scale:.4f} of what chief rays say")
    (a, b), (c, d) = ([fields[setting] for setting in pair] for pair in PAIRS)
    claim(b > a and d > c, "a shorter lens, or a larger film, does not see more")
    caption.sentences = [
        f"The wide-angle lens at f/{F_NUMBER:g}, focused at {FOCUS_MM / 1000.0:g} m. From 100 mm to 80 mm of focal length its field grows from {a:.1f}° to "
        f"{b:.1f}°; from 50 mm to 80 mm of film, from {c:.1f}° to {d:.1f}°, across the diagonal. Each pair of pictures is laid on top of each other by "
        "the paths of exact chief rays; the scale that makes them most alike is within half a hundredth of that."
    ]
    return caption


FIGURE = Figure(
    "fig-08", "Figure 8: the field of view", tuple(_shot(setting) for pair in PAIRS for setting in pair), read
)
