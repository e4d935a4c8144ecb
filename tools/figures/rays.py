# SPDX-License-Identifier: GPL-3.0-or-later
"""Exact rays through a lens, by the command line's own numbers: the numbers of the captions. Needs petzval, no bpy.

Lens space: millimetres, z along the axis in the direction of the light, z = 0 at the first vertex.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from petzval.description import LensSettings, focal_length
from petzval.lens_loading import load

#: The distance before the first vertex at which rays are handed over, mm.
BEFORE_MM = 100.0
#: The wavelength of captions that name none.
LINE_NM = 550.0


class Rays:
    """A lens as it is set, focused on a plane so far before the entrance pupil, mm (infinity: None)."""

    def __init__(
        self,
        lens: str,
        focus_mm: float | None = None,
        nm: float = LINE_NM,
        focal_length_mm: float | None = None,
        **settings: Any,
    ) -> None:
        self.lens = load(lens)
        self.nm, self.focus_mm = nm, focus_mm
        self.setting = LensSettings(focal_length(focal_length_mm), **settings)
        self.info = json.loads(self.lens.info_json(self.setting, wavelength_nm=nm, focus_distance_mm=focus_mm))
        self.film_z = self.info["film_z_mm"]
        self.pupil_z = self.info["entrance_pupil"]["z_mm"]
        self.pupil_radius = 0.5 * self.info["entrance_pupil"]["diameter_mm"]

    def trace(
        self, origins: np.ndarray, directions: np.ndarray, *, from_film: bool = False
    ) -> tuple[np.ndarray, np.ndarray]:
        """The places where rays leave the last surface, and their directions, (n, 3) each; NaN where they do not come through."""
        rays = [
            {"origin": list(map(float, o)), "direction": list(map(float, d)), "wavelength_nm": self.nm}
            for o, d in zip(origins, directions, strict=True)
        ]
        text = json.dumps({"rays": rays})
        focus = None if self.focus_mm is None else (self.focus_mm, self.nm)
        told = json.loads(self.lens.trace_json(text, self.setting, from_film=from_film, focus=focus))["rays"]
        nothing = [float("nan")] * 3
        places = [(one["origin"], one["direction"]) if one["status"] == "ok" else (nothing, nothing) for one in told]
        return np.array([p for p, _ in places]), np.array([d for _, d in places])

    def through(self, point: np.ndarray, count: int, margin: float = 1.3) -> tuple[np.ndarray, np.ndarray]:
        """The places where the light of a point in lens space leaves the last surface, and its directions, (n, 3) each, NaN where it does
        not: rays spread evenly over the entrance pupil and a margin around it."""
        i = np.arange(count) + 0.5
        radius, turn = margin * self.pupil_radius * np.sqrt(i / count), i * np.pi * (3.0 - np.sqrt(5.0))
        pupil = np.stack([radius * np.cos(turn), radius * np.sin(turn), np.full(count, self.pupil_z)], -1)
        towards = pupil - point
        towards /= np.linalg.norm(towards, axis=1)[:, None]
        return self.trace(pupil - towards * ((self.pupil_z + BEFORE_MM) / towards[:, 2:]), towards)

    def on_film(self, point: np.ndarray, swing_rad: float = 0.0, count: int = 1500, margin: float = 1.3) -> np.ndarray:
        """The hits of a point's light on the film, along its sides, (n, 2) mm; the point is in lens space. A swung film is turned about its
        vertical axis, its normal (sin, 0, cos)."""
        places, out = self.through(point, count, margin)
        sin, cos = np.sin(swing_rad), np.cos(swing_rad)
        before = cos * (self.film_z - places[:, 2]) - sin * places[:, 0]
        hits = places + (before / (cos * out[:, 2] + sin * out[:, 0]))[:, None] * out
        hits = np.stack([cos * hits[:, 0] - sin * (hits[:, 2] - self.film_z), hits[:, 1]], -1)
        return hits[np.isfinite(hits).all(axis=1)]
