# SPDX-License-Identifier: GPL-3.0-or-later
"""A mirror lens of 500 mm: its second mirror stands in the middle of the beam, and blurred lamps are rings."""

from __future__ import annotations

import numpy as np

from .blur import profile
from .fig11_aperture import spread
from .figure import Caption, Figure, Shot, Taken, claim
from .rays import Rays
from .scene import in_lens_space, places_mm

LENS, FOCUS_MM = "reflex-nikkor-500-f8", 9000.0
#: A lamp that no other's blur touches, its width, and the place of its image on the film, mm.
LAMP, LAMP_RADIUS_MM, AT_MM, FILM_MM = "Lamp in the hedge 23", 6.0, (3.77, 4.06), 5.4
#: The limit of the profile as a part of the blur's radius, and its number of rings.
LIMIT, RINGS = 1.4, 28
_PLAIN = ("--effect", "ghosts=off", "--effect", "glare=off", "--effect", "diffraction=off")


def _shots() -> list[Shot]:
    focus = ("--focus-distance", f"{FOCUS_MM:g}")
    many = ("--min-samples", "64", "--noise-threshold", "0.03")
    near = ("--film", f"{FILM_MM:g}x{FILM_MM / 1.5:g}", "--shift", f"{AT_MM[0]:g},{AT_MM[1]:g}", "--samples", "1024")
    return [
        Shot("fig-13-garden", "lights", LENS, (*focus, *many), "far", "Reflex-Nikkor 500 mm, f/6.3", samples=8.0, is_only_shown=True),
        Shot("fig-13-near", "lights", LENS, (*focus, *near, *_PLAIN), "far", "a lamp", width=0.5),
    ]  # fmt: skip


def edges(at: np.ndarray, light: np.ndarray) -> tuple[float, float]:
    """The radii where light rises to half of the ring's, and where it has fallen to half, going outwards."""
    level = 0.5 * np.median(light[light > 0.5 * light.max()])
    above = np.flatnonzero(light > level)
    first, last = above[0], above[-1]

    def crossing(i: int) -> float:
        return float(at[i] + (level - light[i]) / (light[i + 1] - light[i]) * (at[i + 1] - at[i]))

    return crossing(first - 1) if first else 0.0, crossing(last)


def read(taken: dict[str, Taken]) -> Caption:
    picture = taken["fig-13-near"]
    rays = Rays(LENS, FOCUS_MM)
    place = places_mm(picture.blend, LAMP)[LAMP]
    hits = rays.on_film(in_lens_space(place, rays.pupil_z), 0.0, 20000)
    radii = np.hypot(*(hits - hits.mean(0)).T)
    limit = LIMIT * float(radii.max())
    aside = rays.on_film(in_lens_space(place + [LAMP_RADIUS_MM, 0.0, 0.0], rays.pupil_z), 0.0, 20000)
    lamp = float(np.hypot(*(aside.mean(0) - hits.mean(0))))
    at, light = profile(picture.light, FILM_MM / picture.size[0], limit, RINGS)
    bounds = np.linspace(0.0, limit, RINGS + 1)
    expected = np.histogram(spread(radii, lamp), bins=bounds)[0] / np.diff(bounds**2)
    found, foreseen = edges(at, light), edges(at, expected)
    alike = float(np.corrcoef(light, expected)[0, 1])
    step = float(at[1] - at[0])
    for name, a, b in zip(("inner", "outer"), found, foreseen, strict=True):
        # A pixel of the smallest size is a third of a ring of the profile wide.
        claim(
            abs(a - b) < 0.35 * step + 0.02 * b, f"the {name} radius of the ring is {a:.3f} mm, by exact rays {b:.3f}"
        )
    claim(alike > 0.97, f"light by radius in a blurred lamp and that of exact rays correlate by {alike:.3f} only")
    dark = abs(light[at < 0.5 * found[0]].mean()) / np.median(light[light > 0.5 * light.max()])
    claim(dark < 0.1, f"the ring's middle has {dark:.2f} of the light of the ring")
    return Caption(
        [
            f"Focused at {FOCUS_MM / 1000.0:g} m; the lamp by itself is {place[2] / 1000.0:.1f} m away. Its blur is a ring from "
            f"{found[0]:.2f} to {found[1]:.2f} mm on the film, from {foreseen[0]:.2f} to {foreseen[1]:.2f} mm by exact rays: the "
            f"hole is {found[0] / found[1]:.2f} of the whole, and in its middle is {100.0 * dark:.0f} % of the ring's light. Light "
            f"over radius follows exact rays with a correlation of {alike:.3f}. The mirror's shadow and the lens's coatings make an f/6.3 lens one of "
            f"T/{rays.info['t_number']:.1f}."
        ]
    )


FIGURE = Figure("fig-13", "Figure 13: rings of a mirror lens", tuple(_shots()), read)
