# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of a point, by exact rays from the scene through the lens to the film.

The renderer goes the other way, from the film, and aims by a map of the pupil; all that the two share is the tracing
of one ray, which tests of its own hold against reference data. From the point, rays go evenly to the plane of the
entrance pupil, each with its share of the solid angle. By conservation of etendue the light that arrives on the film is
the sum over the rays that get through.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property
from math import cos, pi, sin
from pathlib import Path

import numpy as np

from petzval import _native
from petzval.description import LensSettings, focal_length

D_LINE_NM = 587.5618


def spread(count: int) -> np.ndarray:
    """(count, 2) points evenly over the unit square, in no symmetric pattern (Roberts's R2 sequence).

    The area of a disc is found to about 2 / count^0.75 of itself.
    """
    ratio = 1.32471795724474602596  # x^3 = x + 1
    return np.modf(0.5 + np.outer(np.arange(count), [1.0 / ratio, 1.0 / ratio**2]))[0]


@dataclass
class Spot:
    """Where a point's light arrives: pixels from the picture's lower left corner, and the part of the light."""

    at: np.ndarray  # (rays, 2)
    weight: np.ndarray

    @property
    def centroid(self) -> np.ndarray:
        return self.weight @ self.at / self.weight.sum()

    @property
    def covariance(self) -> np.ndarray:
        away = self.at - self.centroid
        return (away * self.weight[:, None]).T @ away / self.weight.sum()

    @property
    def flux(self) -> float:
        """Light that arrives, for a source of one unit per steradian."""
        return float(self.weight.sum())


@dataclass(frozen=True)
class Camera:
    """A lens before its film. Lengths in mm, in lens space; angles in radians."""

    lens: Path
    film_z_mm: float
    picture_mm: tuple[float, float]
    pixels: tuple[int, int]
    focal_length_mm: float | None = None
    f_number: float | None = None
    blades: int = 0
    blade_rotation_rad: float = 0.0
    tilt_rad: float = 0.0
    swing_rad: float = 0.0
    shift_mm: tuple[float, float] = (0.0, 0.0)
    wavelength_nm: float = D_LINE_NM
    mm_per_unit: float = 1000.0

    @cached_property
    def _lens(self) -> _native.Lens:
        return _native.Lens(str(self.lens))

    @cached_property
    def info(self) -> dict:
        return json.loads(
            self._lens.info_json(
                LensSettings(focal_length(self.focal_length_mm), self.f_number),
                wavelength_nm=self.wavelength_nm,
            )
        )

    @property
    def pupil_z_mm(self) -> float:
        """The camera object's origin."""
        return self.info["entrance_pupil"]["z_mm"]

    @cached_property
    def stop(self) -> int:
        """Number of the surface with the diaphragm."""
        rows = [line.split() for line in self.lens.read_text().splitlines() if line.strip() and line[0] != "#"]
        return next(number for number, row in enumerate(rows) if row[5] == "1")

    @cached_property
    def film_axes(self) -> np.ndarray:
        """Rows: the film's own x, y, and its normal, in lens space.

        The film is turned about its own vertical axis (swing), then about the lens's horizontal one (tilt), both
        right-handed with z along the light: x to y, y to z, z to x.
        """
        ct, st, cs, ss = cos(self.tilt_rad), sin(self.tilt_rad), cos(self.swing_rad), sin(self.swing_rad)
        about_x = np.array([[1, 0, 0], [0, ct, -st], [0, st, ct]])
        about_y = np.array([[cs, 0, ss], [0, 1, 0], [-ss, 0, cs]])
        return (about_x @ about_y).T

    def to_lens(self, point: np.ndarray) -> np.ndarray:
        """Camera space in Blender units to lens space."""
        x, y, z = np.asarray(point, float) * self.mm_per_unit
        return np.array([x, y, z + self.pupil_z_mm])

    def trace(self, origins: np.ndarray, directions: np.ndarray, *, from_film: bool = False) -> list[dict]:
        rays = [
            {"origin": o, "direction": d, "wavelength_nm": self.wavelength_nm}
            for o, d in zip(origins.tolist(), directions.tolist(), strict=True)
        ]
        answer = self._lens.trace_json(
            json.dumps({"rays": rays}),
            LensSettings(focal_length(self.focal_length_mm), self.f_number),
            from_film=from_film,
        )
        return json.loads(answer)["rays"]

    def is_open(self, ray: dict, *, from_film: bool = False) -> bool:
        """The ray got through, the blades too: `trace` itself has a round diaphragm."""
        if ray["status"] != "ok":
            return False
        if self.blades < 3:
            return True
        hits = ray["hits"][::-1] if from_film else ray["hits"]
        x, y, _z = hits[self.stop]
        # A regular polygon whose corners lie on the round opening, one of them at the angle of the rotation.
        step = 2.0 * pi / self.blades
        apothem = 0.5 * self.info["stop_diameter_mm"] * cos(0.5 * step)
        sides = self.blade_rotation_rad + (np.arange(self.blades) + 0.5) * step
        return bool(np.all(x * np.cos(sides) + y * np.sin(sides) <= apothem))

    def to_picture(self, origin: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """Rays behind the lens to pixels: the picture is the film turned by half a turn."""
        axes = self.film_axes
        middle = np.array([0.0, 0.0, self.film_z_mm])
        along = ((middle - origin) @ axes[2]) / (direction @ axes[2])
        # The lens moved right is the film moved left.
        film = (origin + along[:, None] * direction - middle) @ axes[:2].T + self.shift_mm
        return (0.5 - film / np.asarray(self.picture_mm)) * np.asarray(self.pixels)

    def picture_of(self, point: np.ndarray, grid: int = 50, search: float = 4.0) -> Spot:
        """The picture of a point in camera space (Blender units), by grid^2 rays, nearly all of which get through.

        The centroid is found to about 1 / grid^1.5 of the spot's radius, the flux to twice that part of itself.
        The pupil is first looked for with few rays, `search` times as far about the axis as its paraxial radius: for
        points far off the axis it moves and grows.
        """
        source = self.to_lens(point)
        half = 0.5 * self.info["entrance_pupil"]["diameter_mm"] * search
        coarse = 40
        at = self._arrived(source, np.array([[-half, -half], [half, half]]), coarse)[0]
        assert len(at), "no ray gets through the lens"
        assert np.abs(at).max() < half * (1.0 - 2.0 / coarse), "the pupil lies further out than was looked for"
        # The first look sees a beam's rim to about a cell; the second closes in on it.
        for rays in (coarse, grid):
            margin = 3.0 * half / coarse if rays == coarse else 1.5 * (at.max(axis=0) - at.min(axis=0)) / coarse
            at, spot = self._arrived(source, np.array([at.min(axis=0) - margin, at.max(axis=0) + margin]), rays)
        return spot

    def scale_at(self, point: np.ndarray) -> np.ndarray:
        """Pixels right and up for a step right and up at a point: 2 x 2, by rays through the pupil's middle."""
        source = self.to_lens(point)
        step = 1e-3 * np.linalg.norm(source)
        sources = source + step * np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])
        rays = self.trace(sources, np.array([0.0, 0.0, self.pupil_z_mm]) - sources)
        at = self.to_picture(np.array([r["origin"] for r in rays]), np.array([r["direction"] for r in rays]))
        return np.column_stack([at[0] - at[1], at[2] - at[3]]) / (2.0 * step) * self.mm_per_unit

    def _arrived(self, source: np.ndarray, box: np.ndarray, grid: int) -> tuple[np.ndarray, Spot | None]:
        """Rays from a point to grid^2 places of a box in the plane of the entrance pupil: those whose rays reach the
        film, and where."""
        x, y = (box[0] + (box[1] - box[0]) * spread(grid * grid)).T
        to = np.column_stack([x, y, np.full_like(x, self.pupil_z_mm)]) - source
        distance = np.linalg.norm(to, axis=1)
        direction = to / distance[:, None]
        solid_angle = (box[1] - box[0]).prod() / grid**2 * direction[:, 2] / distance**2
        rays = self.trace(np.broadcast_to(source, to.shape), direction)
        good = [number for number, ray in enumerate(rays) if self.is_open(ray)]
        if not good:
            return np.empty((0, 2)), None
        origin = np.array([rays[number]["origin"] for number in good])
        outward = np.array([rays[number]["direction"] for number in good])
        return np.column_stack([x, y])[good], Spot(self.to_picture(origin, outward), solid_angle[good])

    def exposure(self, pixels: list[tuple[float, float]], coarse: int = 48, fine: int = 40) -> float:
        """The mean over neighbouring points of the picture of what a uniform world of radiance one gives, by brute
        force, as film irradiance.

        From the first point rays go to few points all over the rear glass, then from each to more points of the
        part that lets light through: one point's exposure is found to about 2 / fine^1.5 of itself.
        """
        half = 0.5 * self.rear["diameter_mm"]
        step = 2.0 * half / coarse
        at, _seen = self._light(pixels[0], np.array([[-half, -half], [half, half]]), coarse)
        if not len(at):
            return 0.0
        # The light of a neighbouring point passes the rear glass no further away than that point is.
        away = np.abs(np.asarray(pixels) - pixels[0]).max(axis=0) / self.pixels * self.picture_mm
        box = np.array([at.min(axis=0) - 1.1 * step - away, at.max(axis=0) + 1.1 * step + away])
        total = 0.0
        for pixel in pixels:
            at, _seen = self._light(pixel, box, coarse // 2)
            cell = 2.2 * (box[1] - box[0]) / coarse
            total += self._light(pixel, np.array([at.min(axis=0) - cell, at.max(axis=0) + cell]), fine)[1].sum()
        return float(total) / len(pixels)

    def seen_from(self, pixels: list[tuple[float, float]], grid: int = 16) -> tuple[np.ndarray, np.ndarray]:
        """Where the rays of neighbouring points of the picture start and go, camera space in Blender units: evenly over the
        pupil, as the renderer has them."""
        half = 0.5 * self.rear["diameter_mm"]
        coarse = 24
        at, _seen, _rays = self._through(pixels[0], np.array([[-half, -half], [half, half]]), coarse)
        assert len(at), "no ray gets through the lens"
        # The light of a neighbouring point passes the rear glass no further away than that point is.
        away = np.abs(np.asarray(pixels) - pixels[0]).max(axis=0) / self.pixels * self.picture_mm
        cell = 2.2 * half / coarse + away
        box = np.array([at.min(axis=0) - cell, at.max(axis=0) + cell])
        rays = [ray for pixel in pixels for ray in self._through(pixel, box, grid)[2]]
        start = np.array([ray["origin"] for ray in rays]) - [0.0, 0.0, self.pupil_z_mm]
        return start / self.mm_per_unit, np.array([ray["direction"] for ray in rays])

    def _light(self, pixel: tuple[float, float], box: np.ndarray, grid: int) -> tuple[np.ndarray, np.ndarray]:
        return self._through(pixel, box, grid)[:2]

    def _through(
        self, pixel: tuple[float, float], box: np.ndarray, grid: int
    ) -> tuple[np.ndarray, np.ndarray, list[dict]]:
        """Of grid^2 points of a box in the plane of the rear vertex: those whose rays get through, their light, and they."""
        axes = self.film_axes
        film = (0.5 - np.asarray(pixel) / np.asarray(self.pixels)) * np.asarray(self.picture_mm) - self.shift_mm
        point = film @ axes[:2] + np.array([0.0, 0.0, self.film_z_mm])
        cell = (box[1] - box[0]) / grid
        x, y = (box[0] + (box[1] - box[0]) * spread(grid * grid)).T
        to = np.column_stack([x, y, np.full_like(x, self.rear["z_mm"])]) - point
        distance = np.linalg.norm(to, axis=1)
        direction = to / distance[:, None]
        rays = self.trace(np.broadcast_to(point, to.shape), direction, from_film=True)
        good = np.array([self.is_open(ray, from_film=True) for ray in rays])
        seen = np.abs(direction @ axes[2]) * np.abs(direction[:, 2]) / distance**2 * cell.prod()
        return (
            np.column_stack([x, y])[good],
            seen[good],
            [ray for ray, is_good in zip(rays, good, strict=True) if is_good],
        )

    @cached_property
    def rear(self) -> dict:
        """The last glass: its vertex and clear diameter at this focal length."""
        rows = [line.split() for line in self.lens.read_text().splitlines() if line.strip() and line[0] != "#"]
        published = json.loads(self._lens.info_json(wavelength_nm=D_LINE_NM))["efl_mm"]
        scale = 1.0 if self.focal_length_mm is None else self.focal_length_mm / published
        return {
            "z_mm": scale * sum(float(row[1]) for row in rows[:-1]),
            "diameter_mm": scale * float(rows[-1][3]),
        }
