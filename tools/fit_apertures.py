#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits the clear apertures of a lens to the vignetting that lensfun's database has measured of its product.

    python3 tools/fit_apertures.py LENS.lens lensfun/data/db [--crop 1.0]

Patents rarely give clear apertures. Two numbers stand for them here: the part of the beam, about its middle, that passes at 0.7 of the
height of the film's corner, and the part in the corner. Each rim is as wide as these beams and the whole beam on the axis need, and 2 %
more, as far as the glasses leave room for edges. The two parts are found by least squares on stops of light at the widest measured
f-numbers. Prints the table of the lens with its new diameters, the two parts, and the residual. Needs numpy; reads spherical, conic and
polynomial surfaces.
"""

from __future__ import annotations

import argparse
import math
import re
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

#: Parts of the beam's radius for which rim rays are traced once; between them heights are interpolated.
PARTS = np.array([0.1, 0.25, 0.4, 0.55, 0.7, 0.85, 1.0])
#: Directions in the stop of rim rays; the other half is the same by symmetry.
AROUND = ((0, 1), (0, -1), (1, 0), (math.sqrt(0.5), math.sqrt(0.5)), (math.sqrt(0.5), -math.sqrt(0.5)))
#: The edge that a glass keeps, mm; of a layer of resin or cement.
EDGE_MM, THIN_EDGE_MM = 0.4, 0.02
FIELDS, GRID, SPARE = 11, 61, 1.02


@dataclass
class Table:
    """A lens file's table, focused at infinity."""

    head: list[str]
    columns: str
    rows: list[list[str]]
    powers: list[int] = field(default_factory=list)

    @classmethod
    def read(cls, path: Path) -> Table:
        lines = [line.strip() for line in path.read_text().splitlines() if line.strip()]
        columns = next(line for line in lines if line.startswith("#radius"))
        rows = [line.split("#")[0].split() for line in lines if not line.startswith("#")]
        powers = [int(name[1:]) for name in columns[1:].split()[6:] if re.fullmatch(r"a\d+", name)]
        return cls([line for line in lines if line.startswith("# ")], columns, rows, powers)

    def says(self, key: str) -> str | None:
        return next((line.split(":", 1)[1].strip() for line in self.head if line.startswith(f"# {key}:")), None)


class Lens:
    """Surfaces at the d line, traced by exact rays from the scene."""

    def __init__(self, table: Table) -> None:
        number = [[float(row[i]) for row in table.rows] for i in (0, 1, 3, 4)]
        radius, self.gap, self.diameter, self.conic = map(np.array, number)
        self.curvature = np.array([1.0 / r if r else 0.0 for r in radius])
        self.glass = [row[2] for row in table.rows]
        self.index = [1.0, *(1.0 if glass == "air" else float(glass.split("/")[0]) for glass in self.glass)]
        self.stop = next(i for i, row in enumerate(table.rows) if row[5] == "1")
        self.powers = table.powers
        self.terms = [[float(x) for x in row[6 : 6 + len(table.powers)]] for row in table.rows]
        self.chief_by_angle: dict[float, float] = {}

    def paraxial(self) -> tuple[float, float]:
        """Focal length, and the focus from the last vertex, mm."""
        y, slope = 1.0, 0.0
        for i, curvature in enumerate(self.curvature):
            slope -= y * (self.index[i + 1] - self.index[i]) * curvature
            y += self.gap[i] * slope / self.index[i + 1] if i + 1 < len(self.gap) else 0.0
        return -1.0 / slope, -y / slope

    def entrance(self) -> tuple[float, float]:
        """The entrance pupil's place from the first vertex, mm, and its size over the stop's."""
        y, slope = 0.0, self.index[self.stop]
        for i in range(self.stop - 1, -1, -1):
            y -= self.gap[i] * slope / self.index[i + 1]
            slope += y * (self.index[i + 1] - self.index[i]) * self.curvature[i]
        return -y / slope, 1.0 / abs(slope)

    def sag(self, i: int, r: np.ndarray) -> np.ndarray:
        under = 1.0 - (1.0 + self.conic[i]) * (self.curvature[i] * r) ** 2
        with np.errstate(invalid="ignore"):
            z = self.curvature[i] * r**2 / (1.0 + np.sqrt(under))
        return z + sum(a * r**p for p, a in zip(self.powers, self.terms[i], strict=True))

    def _hit(self, i: int, start: np.ndarray, way: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Points on a surface, its slope over the radius there, and the rays that hit it."""
        c, k = self.curvature[i], self.conic[i]
        x, y, z = start.T
        dz = way[:, 2]
        a = c * (1.0 + k * dz**2)
        b = c * (x * way[:, 0] + y * way[:, 1] + (1.0 + k) * z * dz) - dz
        d = c * (x * x + y * y + (1.0 + k) * z * z) - 2.0 * z
        root = b * b - a * d
        t = d / (-b + np.sqrt(np.maximum(root, 0.0)))
        good = root > 0.0
        is_asphere = any(self.terms[i])
        for _ in range(12 if is_asphere else 1):
            at = start + t[:, None] * way
            r2 = at[:, 0] ** 2 + at[:, 1] ** 2
            under = np.maximum(1.0 - (1.0 + k) * c * c * r2, 1e-9)
            sag, slope = c * r2 / (1.0 + np.sqrt(under)), c / np.sqrt(under)
            for p, term in zip(self.powers, self.terms[i], strict=True):
                sag, slope = sag + term * r2 ** (p / 2), slope + term * p * r2 ** ((p - 2) / 2)
            off = at[:, 2] - sag
            if is_asphere:
                t = t - off / (dz - slope * (at[:, 0] * way[:, 0] + at[:, 1] * way[:, 1]))
        return at, slope, good & (np.abs(off) < 1e-6)

    def trace(
        self, start: np.ndarray, way: np.ndarray, last: int | None = None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Points on the surface `last`, directions behind it, which rays come there, and their heights on each surface."""
        start, way, good, heights = start.copy(), way.copy(), np.ones(len(start), bool), []
        last = len(self.gap) - 1 if last is None else last
        for i in range(last + 1):
            at, slope, met = self._hit(i, start, way)
            good &= met
            heights.append(np.hypot(at[:, 0], at[:, 1]))
            normal = np.stack([-slope * at[:, 0], -slope * at[:, 1], np.ones(len(at))], 1)
            normal /= np.linalg.norm(normal, axis=1)[:, None]
            ratio, cosine = self.index[i] / self.index[i + 1], np.sum(normal * way, axis=1)
            under = 1.0 - ratio**2 * (1.0 - cosine**2)
            good &= under > 0.0
            way = ratio * way + (np.sqrt(np.maximum(under, 0.0)) - ratio * cosine)[:, None] * normal
            start = at - np.array([0.0, 0.0, self.gap[i]]) if i < last else at
        return start, way, good, np.array(heights)

    def chief(self, angle: float) -> float:
        """Height at the first vertex of the ray through the stop's middle, mm; from smaller angles outwards."""
        way = np.array([[0.0, math.sin(angle), math.cos(angle)]])

        def missed(y: float) -> float:
            at, _, good, _ = self.trace(np.array([[0.0, y, 0.0]]), way, self.stop)
            return float(at[0, 1]) if good[0] else math.nan

        before = [known for known in self.chief_by_angle if 1e-3 < known <= angle]
        first = -self.entrance()[0] * math.tan(angle)
        if before:
            first = self.chief_by_angle[max(before)] * math.tan(angle) / math.tan(max(before))
        a, b = first, first + 0.01
        off_a, off_b = missed(a), missed(b)
        for _ in range(20):
            if not math.isfinite(off_b) or abs(off_b) < 1e-9 or off_a == off_b:
                break
            a, b, off_a = b, b - off_b * (b - a) / (off_b - off_a), off_b
            off_b = missed(b)
        if abs(off_b) < 1e-6:
            self.chief_by_angle[angle] = b
        return b

    def height(self, angle: float) -> float:
        """Height of the chief ray on the film, mm; the film is at the paraxial focus."""
        way = np.array([[0.0, math.sin(angle), math.cos(angle)]])
        at, out, good, _ = self.trace(np.array([[0.0, self.chief(angle), 0.0]]), way)
        beyond = self.paraxial()[1] - at[0, 2]
        return abs(float(at[0, 1] + beyond * out[0, 1] / out[0, 2])) if good[0] else math.nan

    def room(self) -> np.ndarray:
        """The largest diameters for which glasses keep an edge, mm; no narrower than the table's."""
        most = np.array([2.0 * 0.98 / abs(c) / math.sqrt(max(1.0 + k, 1.0)) if c else 1e3
                         for c, k in zip(self.curvature, self.conic, strict=True)])  # fmt: skip
        own = most.copy()
        radii = np.arange(0.5, 80.0, 0.05)

        def ground(i: int) -> np.ndarray:
            # Beyond its own reach a surface goes on as a plane.
            return self.sag(i, np.minimum(radii, own[i] / 2.0))

        for i in range(len(self.gap) - 1):
            if self.glass[i] != "air":
                edge = EDGE_MM if self.gap[i] > 2 * EDGE_MM else THIN_EDGE_MM
                bad = ~(self.gap[i] + ground(i + 1) - ground(i) >= edge)
                first = radii[np.argmax(bad)] if bad.any() else radii[-1]
                most[i : i + 2] = np.minimum(most[i : i + 2], 2.0 * first)
        return np.maximum(most, self.diameter)


class Beams:
    """The beams of fields evenly to the film's corner: rays once traced, light for any rims."""

    def __init__(self, lens: Lens, f_number: float, corner_mm: float) -> None:
        self.lens, self.focal_mm = lens, lens.paraxial()[0]
        _, self.size = lens.entrance()
        self.stop_mm = self.focal_mm / f_number / self.size
        self.heights_mm = np.linspace(0.0, corner_mm, FIELDS)
        widest = math.atan(1.2 * corner_mm / self.focal_mm)
        samples = np.linspace(0.0, widest, 24)
        found = np.array([0.0, *(lens.height(angle) for angle in samples[1:])])
        known = np.isfinite(found)
        # The tangent of the angle by the height, a polynomial through the samples.
        tangent = np.polynomial.Polynomial.fit(found[known], np.tan(samples[known]), 9)
        self.angles = np.arctan(tangent(self.heights_mm))
        self.angles[0] = 0.0
        turn = tangent.deriv()(self.heights_mm) / (1.0 + np.tan(self.angles) ** 2)
        # Area of the scene's sky a mm² of the film: sin θ dθ / (h dh).
        sky = [math.sin(t) * d / h for t, d, h in zip(self.angles[1:], turn[1:], self.heights_mm[1:], strict=True)]
        self.sky = np.array([1.0 / self.focal_mm**2, *sky])
        self.masks = [self._grid(angle) for angle in self.angles]
        self.rims = {part: self._rim(part) for part in (0.0, 0.7, 1.0)}
        self.most = lens.room()

    def _grid(self, angle: float) -> tuple[np.ndarray, np.ndarray]:
        """Rays evenly over more than the beam: which come through, and their heights on surfaces."""
        half = 0.5 * self.stop_mm * self.size * 1.35
        steps = ((np.arange(GRID) + 0.5) / GRID * 2.0 - 1.0) * half
        x, y = np.meshgrid(steps, steps / math.cos(angle))
        start = np.stack([x.ravel(), y.ravel() + self.lens.chief(angle), np.zeros(GRID * GRID)], 1)
        way = np.tile([0.0, math.sin(angle), math.cos(angle)], (GRID * GRID, 1))
        _, _, good, heights = self.lens.trace(start, way)
        return good, heights

    def _rim(self, part: float) -> np.ndarray:
        """Heights on each surface, the largest around, of rays at PARTS of the stop's radius, of a field at this part of the corner."""
        angle = float(np.interp(part * self.heights_mm[-1], self.heights_mm, self.angles))
        target = np.array([(p * x, p * y) for p in PARTS for x, y in AROUND]) * 0.5 * self.stop_mm
        at = target * self.size + np.array([0.0, self.lens.chief(angle)])
        way = np.tile([0.0, math.sin(angle), math.cos(angle)], (len(target), 1))
        for _ in range(8):
            met, _, good, _ = self.lens.trace(np.c_[at, np.zeros(len(at))], way, self.lens.stop)
            at = at + np.where(good[:, None], target - met[:, :2], 0.0) * self.size
        _, _, good, heights = self.lens.trace(np.c_[at, np.zeros(len(at))], way)
        heights = np.where(good[None, :], heights, 0.0)
        return heights.reshape(len(self.lens.gap), len(PARTS), len(AROUND)).max(axis=2)

    def diameters(self, middle: float, corner: float) -> np.ndarray:
        """Clear diameters that let these parts of the beam through."""
        at = [np.array([np.interp(wanted, PARTS, row) for row in self.rims[part]])
              for part, wanted in ((0.0, 1.0), (0.7, middle), (1.0, corner))]  # fmt: skip
        found = np.minimum(2.0 * np.max(at, axis=0) * SPARE, self.most)
        found[self.lens.stop] = self.stop_mm
        return found

    def stops(self, diameters: np.ndarray, f_number: float) -> np.ndarray:
        """Light on the film at each height, stops from the middle."""
        rims = diameters.copy()
        rims[self.lens.stop] = min(self.focal_mm / f_number / self.size, self.stop_mm)
        light = np.array([np.sum(good & np.all(heights <= rims[:, None] / 2, axis=0)) for good, heights in self.masks])
        light = light * self.sky
        return np.log2(np.maximum(light / light[0], 1e-4))


def measured(database: Path, product: str, crop: float) -> dict[float, tuple[float, list[float]]]:
    """Crop factor and terms of lensfun's model "pa", by f-number, farthest focus."""
    files = sorted(database.glob("*.xml")) if database.is_dir() else [database]
    found: dict[float, tuple[float, list[float]]] = {}
    for lens in (lens for file in files for lens in ElementTree.parse(file).getroot().findall("lens")):
        own = float(lens.findtext("cropfactor") or 1.0)
        if product not in [model.text for model in lens.findall("model")] or abs(own - crop) > 0.02:
            continue
        for row in lens.iterfind("calibration/vignetting"):
            if float(row.get("distance", 0)) >= 100.0:
                found[float(row.get("aperture", 0))] = own, [float(row.get(key, 0)) for key in ("k1", "k2", "k3")]
    return found


def measured_stops(row: tuple[float, list[float]], heights_mm: np.ndarray) -> np.ndarray:
    crop, terms = row
    r2 = (heights_mm / (math.hypot(36.0, 24.0) / crop / 2.0)) ** 2
    return np.log2(np.maximum(1.0 + sum(k * r2 ** (i + 1) for i, k in enumerate(terms)), 1e-4))


def fit(
    beams: Beams, rows: dict[float, tuple[float, list[float]]], f_number: float
) -> tuple[float, float, list[float], float]:
    """The two parts, the f-numbers that they were fitted to, and the root mean square of the residual, stops."""
    widest = [n for n in sorted(rows) if n <= 1.45 * min(rows)][:3]

    def left(middle: float, corner: float) -> float:
        rims = beams.diameters(middle, corner)
        off = [beams.stops(rims, max(n, f_number)) - measured_stops(rows[n], beams.heights_mm) for n in widest]
        return float(np.sqrt(np.mean(np.square(np.array(off)[:, 2:]))))

    # Of parts that the beam on the axis makes good anyway, the largest.
    def tried(middle: float, corner: float) -> tuple[float, float, float]:
        return round(left(middle, corner), 6), -middle, -corner

    best = min(tried(m, c) for m in np.arange(0.2, 0.95, 0.1) for c in np.arange(0.1, 0.95, 0.1))
    for step in (0.05, 0.025, 0.0125):
        m, c = -best[1], -best[2]
        tries = [(x, y) for x in (m - step, m, m + step) for y in (c - step, c, c + step)]
        best = min(tried(x, y) for x, y in tries if min(x, y) > 0.0 and max(x, y) <= 1.0)
    return -best[1], -best[2], widest, best[0]


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("lens", type=Path)
    parser.add_argument("lensfun", type=Path)
    parser.add_argument("--crop", type=float, default=1.0, help="of the measurement; default: 1")
    given = parser.parse_args()
    # Rays that miss a surface are numbers that are none until they are left out.
    np.seterr(invalid="ignore", divide="ignore", over="ignore")
    table = Table.read(given.lens)
    product, stated = table.says("lensfun"), table.says("f_number")
    if product is None or stated is None:
        raise SystemExit(f"{given.lens}: the header needs '# lensfun:' and '# f_number:'")
    rows = measured(given.lensfun, product, given.crop)
    if not rows:
        raise SystemExit(f"{given.lensfun}: no vignetting of '{product}' at a crop factor of {given.crop:g}")
    lens = Lens(table)
    beams = Beams(lens, float(stated), 0.5 * math.hypot(36.0, 24.0) / given.crop)
    middle, corner, widest, rms = fit(beams, rows, float(stated))
    rims = beams.diameters(middle, corner)
    print(f"# apertures: fitted, {100 * middle:.0f} % at 0.7, {100 * corner:.0f} % in the corner, to F/"
          f"{', F/'.join(f'{n:g}' for n in widest)}, {rms:.2f} stops left")  # fmt: skip
    print(table.columns)
    for row, diameter, i in zip(table.rows, rims, range(len(rims)), strict=True):
        print(" ".join([*row[:3], f"{diameter:.6f}" if i == lens.stop else f"{diameter:.2f}", *row[4:]]))


if __name__ == "__main__":
    main()
