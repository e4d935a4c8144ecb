# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks a certificate of `petzval lens prove`: its hashes, that its cells fill all rays and none twice, its volumes, and its cells."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .enclosures import Enclosure
from .rays import followed

FORMAT = "petzval lens proof 1"
#: Powers of the floor's numbers in the terms of a cut.
_CUT = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (2, 0, 0), (1, 1, 0), (1, 0, 1), (0, 2, 0), (0, 1, 1), (0, 0, 2))
#: Cells that are followed together: more take memory, fewer time.
_TOGETHER = 500
#: Coarse cells, that fill so much of their column's way, are all checked.
_COARSE = 0.5
#: A cell that is not confirmed is halved in all of its four numbers so often.
_HALVINGS = 1


class CheckError(Exception):
    """The certificate is wrong. The message says where."""


@dataclass
class Checked:
    """The counts of a check."""

    columns: int
    cells: int
    followed: int
    #: Cells that the checker's own enclosures are too wide to confirm.
    unconfirmed: int
    undecided: float


def partition_hash(columns: list[Any]) -> str:
    """SHA-256 of the columns as compact JSON."""
    return hashlib.sha256(json.dumps(columns, separators=(",", ":")).encode()).hexdigest()


def file_hash(file: Path) -> str:
    """SHA-256 of a file."""
    return hashlib.sha256(file.read_bytes()).hexdigest()


def check(certificate: dict[str, Any], lens_file: Path | None, sample: int | None) -> Checked:
    """Checks a certificate; of its decided cells the coarse ones and a `sample` chosen by hash are followed, all if that is None."""
    if certificate.get("format") != FORMAT:
        raise CheckError(f"it is no certificate of the format '{FORMAT}'")
    columns = certificate["columns"]
    if partition_hash(columns) != certificate["partition_sha256"]:
        raise CheckError("its partition is not that of its hash: it has been changed")
    if lens_file is not None:
        if file_hash(lens_file) != certificate["lens_sha256"]:
            raise CheckError(f"{lens_file} is not the file that was proved: its hash is another")
        _check_table(certificate, lens_file)
    _check_floors(certificate)
    for place, column in enumerate(columns):
        _check_column(place, column)
    undecided = _undecided(certificate)
    if undecided > certificate["undecided"] * (1 + 1e-6) + 1e-12:
        raise CheckError(f"{undecided:.6f} of the volume is undecided, and not {certificate['undecided']:.6f}")
    chosen = _chosen(certificate, sample)
    pieces: list[_Piece] = [(place, (-1.0,) * 4, (1.0,) * 4) for place in chosen]
    unconfirmed = _unconfirmed(certificate, pieces)
    for _ in range(_HALVINGS):
        pieces = [half for piece in unconfirmed for half in _halves(piece)]
        unconfirmed = _unconfirmed(certificate, pieces)
    left = {place for place, _, _ in unconfirmed}
    return Checked(len(columns), sum(len(column[4]) for column in columns), len(chosen), len(left), undecided)


def _check_table(certificate: dict[str, Any], lens_file: Path) -> None:
    """Radii and diameters of a `.lens` of fixed surfaces, read here, are those of the certificate."""
    text = lens_file.read_text("utf-8")
    if lens_file.suffix != ".lens" or "# moving" in text or certificate["scale"] != 1.0:
        return
    rows = [line.split("//")[0].split() for line in text.splitlines() if line.strip() and not line.startswith("#")]
    for surface in certificate["surfaces"]:
        row = rows[surface["surface"]]
        given, _, inverse = row[0].partition("/")
        radius = float(given) / float(inverse) if inverse else float(given)
        curvature = 1.0 / radius if radius else 0.0
        rim = (0.5 * float(row[3])) ** 2
        same = math.isclose(curvature, surface["curvature_per_mm"], rel_tol=1e-14, abs_tol=0.0)
        if not same or not math.isclose(rim, surface["clear_squared_mm2"], rel_tol=1e-14):
            raise CheckError(f"surface {surface['surface']}: radius or diameter is not that of {lens_file}")


def _check_floors(certificate: dict[str, Any]) -> None:
    """The floors fill film radius, rim and wavelengths, and none lies on another; each centre lies within the disc."""
    slabs = len(certificate["centres"])
    film, disc = certificate["film_radius_mm"], certificate["disc_radius_mm"]
    for slab, (at_axis, slope) in enumerate(certificate["centres"]):
        ends = [film * slab / slabs, film * (slab + 1) / slabs]
        if any(abs(at_axis + slope * r) >= disc for r in ends):
            raise CheckError(f"the centre of slab {slab} lies outside of the disc")
        floors = [(column[1], column[2]) for column in certificate["columns"] if column[0] == slab]
        shortest, longest = certificate["wavelengths_nm"]
        _fill(floors, ([ends[0], -1.0, shortest], [ends[1], 1.0, longest]), f"slab {slab}")


def _fill(floors: list[Any], box: Any, what: str) -> None:
    """By halving: a box is filled by one floor that is the box, or cut where no floor is cut."""
    work = [(floors, box)]
    while work:
        floors, (low, high) = work.pop()
        if len(floors) == 1 and list(floors[0][0]) == list(low) and list(floors[0][1]) == list(high):
            continue
        for axis in range(3):
            places = sorted({floor[0][axis] for floor in floors} - {low[axis]})
            cut = next((x for x in places if all(f[1][axis] <= x or f[0][axis] >= x for f in floors)), None)
            if cut is not None and low[axis] < cut < high[axis]:
                below = [f for f in floors if f[1][axis] <= cut]
                above = [f for f in floors if f[0][axis] >= cut]
                work.append((below, (low, [cut if i == axis else x for i, x in enumerate(high)])))
                work.append((above, ([cut if i == axis else x for i, x in enumerate(low)], high)))
                break
        else:
            raise CheckError(f"{what}: the floors of its columns leave a gap, or lie on each other, in {low} to {high}")


def _least(cut: list[float]) -> float:
    """A lower bound of a cut over its floor."""
    square = (4, 7, 9)
    rest = sum(min(c, 0.0) if i in square else -abs(c) for i, c in enumerate(cut) if i)
    return float(cut[0] + rest - 1e-14 * sum(map(abs, cut)))


def _check_column(place: int, column: list[Any]) -> None:
    """Cuts rise from 0 to 1 and do not touch; cells follow on each other without a gap."""
    _, _, _, cuts, cells = column
    if cuts[0] != [0.0] * 10 or cuts[-1] != [1.0] + [0.0] * 9:
        raise CheckError(f"column {place}: its cuts do not go from 0 to 1")
    for low, high in zip(cuts, cuts[1:], strict=False):
        if not _least([b - a for a, b in zip(low, high, strict=True)]) > 0.0:
            raise CheckError(f"column {place}: two of its cuts touch")
    zone, reached = 0, 0.0
    for cell in cells:
        if reached == 1.0:
            zone, reached = zone + 1, 0.0
        if cell[0] != zone or cell[1] != reached or not cell[2] > cell[1]:
            raise CheckError(f"column {place}: its cells leave a gap, or lie on each other")
        reached = cell[2]
    if reached != 1.0 or zone != len(cuts) - 2:
        raise CheckError(f"column {place}: its cells end before the rim")


def _undecided(certificate: dict[str, Any]) -> float:
    """The undecided part of the volume, by Gauss's rule with four points a dimension."""
    nodes, weights = np.polynomial.legendre.leggauss(4)
    grid = np.array(np.meshgrid(nodes, nodes, nodes, indexing="ij")).reshape(3, -1)
    weight = np.einsum("i,j,k->ijk", weights, weights, weights).ravel() / 8.0
    monomials = np.array([np.prod([grid[i] ** p[i] for i in range(3)], axis=0) for p in _CUT])
    disc, total = certificate["disc_radius_mm"], 0.0
    for slab, low, high, cuts, cells in certificate["columns"]:
        left = [cell for cell in cells if cell[3] == "undecided"]
        if not left:
            continue
        low, high = np.array(low), np.array(high)
        r, u, _ = (0.5 * (low + high))[:, None] + (0.5 * (high - low))[:, None] * grid
        at_axis, slope = certificate["centres"][slab]
        y = 2.0 * u / (1.0 + u * u)
        density = disc * (disc - (at_axis + slope * r) * y) * 2.0 / (1.0 + u * u) * 2.0 * math.pi * r
        values = np.array(cuts) @ monomials
        for zone, start, end, *_ in left:
            ends = [np.clip(values[zone] + f * (values[zone + 1] - values[zone]), 0.0, 1.0) for f in (start, end)]
            total += float(np.sum(weight * density * (ends[1] ** 2 - ends[0] ** 2))) * float(np.prod(high - low))
    shortest, longest = certificate["wavelengths_nm"]
    whole = (math.pi * disc**2) * (math.pi * certificate["film_radius_mm"] ** 2) * (longest - shortest)
    return float(total / whole)


def _chosen(certificate: dict[str, Any], sample: int | None) -> list[tuple[int, int]]:
    """The decided cells to follow, by the places of column and cell."""
    decided = [
        (i, j)
        for i, column in enumerate(certificate["columns"])
        for j, cell in enumerate(column[4])
        if cell[3] != "undecided"
    ]
    if sample is None or len(decided) <= sample:
        return decided
    columns = certificate["columns"]

    def is_coarse(place: tuple[int, int]) -> bool:
        _, _, _, cuts, cells = columns[place[0]]
        zone, start, end, *_ = cells[place[1]]
        return bool((end - start) * (cuts[zone + 1][0] - cuts[zone][0]) > _COARSE)

    def lot(place: tuple[int, int]) -> bytes:
        return hashlib.sha256(f"{certificate['partition_sha256']} {place}".encode()).digest()

    coarse = sorted(filter(is_coarse, decided), key=lot)[:sample]
    rest = sorted(set(decided) - set(coarse), key=lot)[: max(sample - len(coarse), sample // 2)]
    return coarse + rest


#: A cell of a column, or a piece of it: lower and upper bounds of the four variables, -1 to 1 for the whole cell.
_Piece = tuple[tuple[int, int], tuple[float, ...], tuple[float, ...]]


def _halves(piece: _Piece) -> list[_Piece]:
    """The sixteen pieces of a piece."""
    place, low, high = piece
    middle = [0.5 * (a + b) for a, b in zip(low, high, strict=True)]
    sides = itertools.product((False, True), repeat=4)
    return [
        (
            place,
            tuple(m if upper else a for a, m, upper in zip(low, middle, side, strict=True)),
            tuple(b if upper else m for b, m, upper in zip(high, middle, side, strict=True)),
        )
        for side in sides
    ]


def _unconfirmed(certificate: dict[str, Any], pieces: list[_Piece]) -> list[_Piece]:
    """The pieces for which the fates of their cells are not confirmed."""
    parts = (pieces[i : i + _TOGETHER] for i in range(0, len(pieces), _TOGETHER))
    return [piece for part in parts for piece in _follow(certificate, part)]


def _follow(certificate: dict[str, Any], pieces: list[_Piece]) -> list[_Piece]:
    """Follows pieces together. Returns those that are not confirmed; raises where the contrary of a stated fate is proved."""
    columns = [certificate["columns"][i] for (i, _), _, _ in pieces]
    cells = [column[4][j] for column, ((_, j), _, _) in zip(columns, pieces, strict=True)]
    least, most = (np.array([piece[i] for piece in pieces]).T for i in (1, 2))
    e = [Enclosure.between(least[i], most[i], i) for i in range(4)]
    low, high = (np.array([column[i] for column in columns]).T for i in (1, 2))
    r, u, nm = (e[i] * (0.5 * (high[i] - low[i])) + 0.5 * (low[i] + high[i]) for i in range(3))
    centres = np.array([certificate["centres"][column[0]] for column in columns]).T
    cuts = [np.array([column[3][cell[0] + i] for column, cell in zip(columns, cells, strict=True)]).T for i in (0, 1)]
    below, above = (
        sum(
            (
                math.prod([e[i] for i in range(3) for _ in range(p[i])], start=1.0) * c
                for p, c in zip(_CUT[1:], cut[1:], strict=True)
            ),
            Enclosure.constant(cut[0]),
        )
        for cut in cuts
    )
    start, end = (np.array([cell[i] for cell in cells]) for i in (1, 2))
    s = below + (above - below) * (e[3] * (0.5 * (end - start)) + 0.5 * (start + end))
    over = (u * u + 1.0).inverse()
    disc = certificate["disc_radius_mm"]
    centre = r * centres[1] + centres[0]
    target = [s * (1.0 - u * u) * over * disc, s * u * over * (2.0 * disc) + (1.0 - s) * centre]
    k = certificate["film_curvature_per_mm"]
    depth = Enclosure.constant(np.full(len(cells), certificate["film_z_mm"]))
    if k:
        depth = depth + r * r * k * ((1.0 - r * r * (k * k)).root() + 1.0).inverse()
    along = [target[0], target[1] - r, -depth]
    length = (along[0] * along[0] + along[1] * along[1] + along[2] * along[2]).root().inverse()
    with np.errstate(all="ignore"):
        verdict = followed(
            certificate,
            [target[0], target[1], Enclosure.constant(np.zeros(len(cells)))],
            [x * length for x in along],
            nm,
        )
    unconfirmed = []
    stopped_somewhere = np.any(verdict.stopped, axis=0)
    for i, (cell, piece) in enumerate(zip(cells, pieces, strict=True)):
        says_passes = cell[3] == "passes"
        if (says_passes and stopped_somewhere[i]) or (not says_passes and verdict.passes[i]):
            column, place = piece[0]
            raise CheckError(f"column {column}, cell {place}: it says '{cell[3]}', and the contrary is proved")
        # Of a stopped one no ray gets past the surface: it ends there, or at one before, which lies nearer to the film.
        stops = () if says_passes else verdict.stopped[cell[4] :]
        if not (verdict.passes[i] if says_passes else any(surface[i] for surface in stops)):
            unconfirmed.append(piece)
    return unconfirmed
