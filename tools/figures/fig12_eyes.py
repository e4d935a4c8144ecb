# SPDX-License-Identifier: GPL-3.0-or-later
"""Figure 12: the view of relaxed schematic eyes of charts six metres away, straight ahead and to the sides; and a thin lens."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from .figure import Caption, Figure, Shot, Taken, claim
from .rays import Rays
from .scene import corners_mm, in_lens_space
from .sharpness import contrast

PUPIL_MM, AWAY_MM, FILM_MM = 4.0, 6000.0, (16.0, 8.0)
#: Lens, its name, and the radius of its retina, mm (`# film_radius`).
EYES = (
    ("eye-gullstrand-exact", "Gullstrand", 12.0),
    ("eye-le-grand", "Le Grand", 12.0),
    ("eye-kooijman", "Kooijman", 10.8),
)
#: Charts in the scene, degrees to the right.
CHARTS = (0, 10, 20)
_FILM = ("--film", f"{FILM_MM[0]:g}x{FILM_MM[1]:g}", "--focus-distance", f"{AWAY_MM:g}")
_PLAIN = ("--effect", "diffraction=off", "--effect", "glare=off", "--effect", "ghosts=off")


def _shots() -> tuple[Shot, ...]:
    thin = ("--camera", "thin", "--focal-length", "17", "--f-number", f"{17.0 / PUPIL_MM:g}", *_FILM)
    shots = [
        Shot(
            "fig-12-thin",
            "eye_chart",
            None,
            thin,
            label="thin lens, 17 mm",
            aspect=2.0,
            width=1.5,
            samples=2.0,
            is_only_shown=True,
        )
    ]
    for lens, name, _ in EYES:
        pupil = ("--pupil-diameter", f"{PUPIL_MM:g}")
        shots.append(
            Shot(
                f"fig-12-{lens}",
                "eye_chart",
                lens,
                (*_FILM, *pupil, *_PLAIN),
                label=name,
                aspect=2.0,
                width=1.5,
                samples=2.0,
            )
        )
    for lens, _, _ in EYES:
        pin = ("--pupil-diameter", "0.5", "--seed", "7")
        shots.append(
            Shot(f"fig-12-{lens}-sharp", "eye_chart", lens, (*_FILM, *pin, *_PLAIN), aspect=2.0, width=1.5, samples=2.0, is_hidden=True)
        )  # fmt: skip
    return tuple(shots)


class Eye:
    """Exact rays onto a retina."""

    def __init__(self, lens: str, radius_mm: float, pupil_mm: float = PUPIL_MM) -> None:
        self.rays = Rays(lens, AWAY_MM, pupil_diameter_mm=pupil_mm)
        self.radius = radius_mm

    def on_retina(self, place_mm: np.ndarray, count: int = 1200) -> np.ndarray:
        """The hits of a place's light on the retina, (n, 3), mm in lens space; the place is before the camera."""
        point = in_lens_space(place_mm, self.rays.pupil_z)
        places, out = self.rays.through(point, count)
        centre = np.array([0.0, 0.0, self.rays.film_z - self.radius])
        from_centre = places - centre
        b = (from_centre * out).sum(1)
        along = -b + np.sqrt(b**2 - (from_centre**2).sum(1) + self.radius**2)
        hits = places + along[:, None] * out
        return hits[np.isfinite(hits).all(axis=1)]

    def spot_um(self, degrees: float) -> float:
        """Root mean square radius of the spot of a point on the wall of charts, micrometres."""
        angle = math.radians(degrees)
        hits = self.on_retina(AWAY_MM * np.array([math.sin(angle), 0.0, math.cos(angle)]))
        return 1000.0 * math.sqrt(((hits - hits.mean(0)) ** 2).sum(1).mean())

    def box(self, blend: Path, name: str, size: tuple[int, int], part: float = 0.75) -> tuple[slice, slice]:
        """Rows and columns of the middle part of a chart."""
        at = np.array([-self.on_retina(corner, 200)[:, :2].mean(0) for corner in corners_mm(blend, name)])
        columns, rows = (at[:, 0] / FILM_MM[0] + 0.5) * size[0], (0.5 - at[:, 1] / FILM_MM[1]) * size[1]
        found = []
        for values, count in ((rows, size[1]), (columns, size[0])):
            middle, half = 0.5 * (values.min() + values.max()), 0.5 * part * (values.max() - values.min())
            found.append(slice(max(round(middle - half), 0), min(round(middle + half) + 1, count)))
        return found[0], found[1]


def read(taken: dict[str, Taken]) -> Caption:
    caption = Caption(head=("eye", *(f"{degrees}°: spot, detail kept" for degrees in CHARTS)))
    kept, spots = {}, {}
    for lens, name, radius in EYES:
        eye, picture, sharp = Eye(lens, radius), taken[f"fig-12-{lens}"], taken[f"fig-12-{lens}-sharp"]
        size = picture.size
        for degrees in CHARTS:
            boxes = [eye.box(picture.blend, f"Chart at {d:+d} degrees", size) for d in {degrees, -degrees}]
            each = [contrast(picture.light, sharp.light, box, max(size[0] // 240, 2)) for box in boxes]
            kept[name, degrees] = float(np.mean(each))
            spots[name, degrees] = eye.spot_um(degrees)
        caption.rows.append(
            (name, *(f"{spots[name, d]:.1f} µm, {100.0 * kept[name, d]:.0f} %" for d in CHARTS))
        )  # fmt: skip
    for degrees in CHARTS[1:]:
        claim(
            spots["Kooijman", degrees] < spots["Gullstrand", degrees],
            f"at {degrees}° exact rays spread more in Kooijman's eye than in Gullstrand's: {spots}",
        )
        claim(
            kept["Kooijman", degrees] > kept["Gullstrand", degrees],
            f"at {degrees}° the picture of Kooijman's eye is not sharper than that of Gullstrand's: {kept}",
        )
    caption.sentences = [
        f"Relaxed eyes with pupils of {PUPIL_MM:g} mm, their lenses as published and their retinas moved to see {AWAY_MM / 1000.0:g} m sharply (Gullstrand's is "
        "a dioptre far-sighted as published). Spots are root mean square radii of exact rays at 550 nm on the curved retina; of the charts' fine detail so "
        "much is left beside a pinhole's. Off the axis Kooijman's aspheric eye is sharper than Gullstrand's, as the paper found.",
    ]
    return caption


FIGURE = Figure("fig-12", "Figure 12: schematic eyes", _shots(), read)
