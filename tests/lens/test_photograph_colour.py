# SPDX-License-Identifier: GPL-3.0-or-later
"""Fringes of colour in the photograph: the distances of red, green and blue of a point, and the shape of its spot."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from support.photograph.chart import FILTER_VARIANCE, Studio, spots

#: The wavelengths of red, green and blue, where three stand for the spectrum: those of the primaries of Rec. 709.
LINES_NM = (611.4, 549.1, 464.2)
#: Lens, f-number, film (mm), the window's place on the film (mm) and its side: such that the fringe is some pixels wide.
CASES = {
    "Tessar": ("tessar-brendel", 16.0, 0.7, (-35.0, 20.0)),
    "Biogon": ("biogon-21-f4.5", 11.0, 0.3, (12.0, 14.0)),
}
SIDE = 32
FAR = 100.0


@pytest.mark.once
@pytest.mark.parametrize("case", CASES)
def test_colours_part_as_far_as_by_exact_rays(blender, tmp_path, case):
    """By the pipeline that carries the light of one ray back at three wavelengths."""
    name, f_number, film_mm, shift_mm = CASES[case]
    studio = Studio(blender, tmp_path, (SIDE, SIDE), samples=600)
    exact = studio.lens(name, (film_mm, film_mm), FAR, f_number=f_number, shift_mm=shift_mm)
    studio.data.petzval.spectrum = "THREE"
    studio.scene.petzval.pipeline = "HERO"
    at = where_it_falls_into_the_window(exact, np.array(shift_mm))
    pixel = film_mm / SIDE / exact.info["efl_mm"] * FAR
    radius = 1.5 * pixel
    studio.lamp(at, radius)
    # The lamp's own covariance, that of a disc at right angles to the view and carried along it into the plane of its depth; and
    # the filter's.
    view = at / np.linalg.norm(at)
    carried = exact.scale_at(at) @ (np.eye(3) - np.outer(view, [0.0, 0.0, 1.0 / view[2]]))[:2]
    disc = 0.25 * radius**2 * (np.eye(3) - np.outer(view, view))
    besides = np.trace(carried @ disc @ carried.T) + 2.0 * FILTER_VARIANCE
    true_spots = [dataclasses.replace(exact, wavelength_nm=nm).picture_of(at) for nm in LINES_NM]
    picture = studio.shoot()
    found = [spots(np.repeat(picture[:, :, [c]], 3, axis=2), [true_spots[c].centroid])[0] for c in range(3)]
    for one, other in ((0, 1), (2, 1)):
        fringe = true_spots[one].centroid - true_spots[other].centroid
        seen = found[one].centroid - found[other].centroid
        # One ray serves all three colours, so that most of the noise of one is that of the others.
        assert np.linalg.norm(fringe) > 0.4
        assert np.abs(seen - fringe).max() < 0.03, (case, one, seen, fringe)
    for spot, truth in zip(found, true_spots, strict=True):
        assert np.abs(spot.centroid - truth.centroid).max() < 0.08
        # Some 3000 samples on the lamp.
        assert np.trace(spot.covariance) == pytest.approx(np.trace(truth.covariance) + besides, rel=0.06)


def where_it_falls_into_the_window(exact, shift_mm: np.ndarray) -> np.ndarray:
    """The place at the depth `FAR` whose picture is the window's middle."""
    at = np.array([*(shift_mm / exact.info["efl_mm"] * FAR), -FAR])
    for _ in range(4):
        away = exact.picture_of(at, grid=20).centroid - 0.5 * SIDE
        at[:2] -= np.linalg.solve(exact.scale_at(at), away)
    return at
