# SPDX-License-Identifier: GPL-3.0-or-later
"""Figure 9: one room, with a window and a landscape behind, focused at 2, 3, 5 and 10 m by a fast lens wide open."""

from __future__ import annotations

import math

import numpy as np

from .figure import Caption, Figure, Shot, Taken, claim
from .rays import Rays
from .scene import box_px
from .sharpness import contrast

LENS, FILM_MM = "double-gauss-f1.35", (48.0, 32.0)
FOCAL_MM = 100.4
#: Objects by their distance, m.
OBJECTS = {2.0: "Vase", 3.0: "Books", 5.0: "Cushion", 10.0: "Painting"}
_FILM = ("--film", f"{FILM_MM[0]:g}x{FILM_MM[1]:g}")
#: The most detail of an object out of focus, as a part of its detail in focus.
MOST = 0.85


def _shots() -> tuple[Shot, ...]:
    plain = ("--effect", "diffraction=off", "--effect", "ghosts=off")
    shots = [
        Shot(f"fig-09-{metres:g}", "room", LENS, (*_FILM, "--focus-distance", f"{1000.0 * metres:g}", *plain), label=f"focused at {metres:g} m: {what.lower()}", samples=2.0)
        for metres, what in OBJECTS.items()
    ]  # fmt: skip
    # The same focus, for the picture grows with it, and an opening through which all is sharp; by other random numbers.
    pin = ("--f-number", "128", "--seed", "7")
    sharp = [
        Shot(f"fig-09-{metres:g}-sharp", "room", LENS, (*_FILM, "--focus-distance", f"{1000.0 * metres:g}", *pin, *plain), samples=2.0, is_hidden=True)
        for metres in OBJECTS
    ]  # fmt: skip
    return (*shots, *sharp)


def spots_um() -> dict[float, dict[float, float]]:
    """Root mean square radius of the blur on the axis, micrometres on the film, by focus and by distance, m."""
    found = {}
    for focus in OBJECTS:
        rays = Rays(LENS, 1000.0 * focus)
        one = {}
        for metres in (*OBJECTS, 1000.0):
            hits = rays.on_film(np.array([0.0, 0.0, rays.pupil_z - 1000.0 * metres]))
            one[metres] = 1000.0 * math.sqrt(((hits - hits.mean(0)) ** 2).sum(1).mean())
        found[focus] = one
    return found


def read(taken: dict[str, Taken]) -> Caption:
    spots, raw = spots_um(), {}
    for focus in OBJECTS:
        picture, sharp = taken[f"fig-09-{focus:g}"], taken[f"fig-09-{focus:g}-sharp"]
        radius = max(sharp.size[0] // 160, 2)
        # As far behind the lens as the film.
        away = 1.0 / (1.0 / FOCAL_MM - 1.0 / (1000.0 * focus))
        boxes = {metres: box_px(sharp.blend, what, away, FILM_MM, sharp.size) for metres, what in OBJECTS.items()}
        raw[focus] = {metres: contrast(picture.light, sharp.light, boxes[metres], radius) for metres in OBJECTS}
    caption = Caption(
        head=("focused at", *(f"{what.lower()}, {metres:g} m" for metres, what in OBJECTS.items()), "landscape")
    )
    for focus in OBJECTS:
        # Noise of the sharp picture lowers all of an object's numbers alike.
        kept = {metres: raw[focus][metres] / max(raw[other][metres] for other in OBJECTS) for metres in OBJECTS}
        cells = [f"{max(100.0 * kept[metres], 0.0):.0f} % ({spots[focus][metres]:.0f} µm)" for metres in OBJECTS]
        caption.rows.append((f"{focus:g} m", *cells, f"({spots[focus][1000.0]:.0f} µm)"))
        others = max(kept[metres] for metres in OBJECTS if metres != focus)
        claim(
            kept[focus] == 1.0 and others < MOST,
            f"focused at {focus:g} m: of its most detail each object has {kept}, of all {raw[focus]}",
        )
        claim(
            min(OBJECTS, key=spots[focus].get) == focus,
            f"focused at {focus:g} m: exact rays meet best at another distance",
        )
    caption.sentences = [
        "The double Gauss, wide open at f/1.4 and 100 mm. In each picture the object in focus is the sharpest: of the fine detail that an object has "
        "in the picture focused on it so much is left in the others. In brackets the blur of a point on the axis at its distance, the root mean square "
        "radius of exact rays on the film.",
    ]
    return caption


FIGURE = Figure("fig-09", "Figure 9: focus", _shots(), read)
