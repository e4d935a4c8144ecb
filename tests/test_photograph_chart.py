# SPDX-License-Identifier: GPL-3.0-or-later
"""Where points of a scene come to lie in the photograph: exact rays from the scene against Blender's render."""

from __future__ import annotations

import numpy as np
import pytest

from photograph.chart import Studio, spots

#: Lens, focal length (mm), film (mm), focus, depths (Blender units) at which lamps stand, and the diameter of their
#: images in pixels where the picture is not distorted: a fisheye's shrink towards its edge.
LENSES = {
    "wide angle": ("wide-angle-smith-f3.4", 28.0, (36.0, 24.0), 1.5, (1.5, 1.0, 4.0), 2.5),
    "double Gauss": ("double-gauss-f2-tronnier", 50.0, (36.0, 24.0), 2.0, (2.0, 1.5, 4.0), 2.5),
    "fisheye": ("laikin-fisheye-170", 20.0, (36.0, 24.0), 1.0, (1.0, 0.5, 3.0), 5.0),
}
#: Places in the picture, as parts of its half width and height: no two alike if it is mirrored or turned.
PLACES = ((0.05, -0.1), (0.8, 0.75), (-0.75, 0.6), (0.45, -0.7), (-0.35, -0.25), (-0.82, -0.8), (0.1, 0.55))
WIDTH, HEIGHT = 96, 64


def place_lamps(studio: Studio, exact, places, depths, diameter_px) -> list[np.ndarray]:
    """Lamps that a pinhole would show at `places`, their depths in turn; their positions in camera space."""
    focal = exact.info["efl_mm"]
    points = []
    for number, (right, up) in enumerate(places):
        depth = depths[number % len(depths)]
        x = right * 0.5 * exact.picture_mm[0] / focal * depth
        y = up * 0.5 * exact.picture_mm[1] / focal * depth
        pixel = exact.picture_mm[0] / exact.pixels[0] / focal * depth
        point = np.array([x, y, -depth])
        studio.lamp(point, 0.5 * diameter_px * pixel)
        points.append(point)
    return points


@pytest.mark.parametrize("case", LENSES)
def test_points_lie_where_exact_rays_meet_the_film(blender, tmp_path, case):
    name, focal_length, film, focus, depths, diameter_px = LENSES[case]
    studio = Studio(blender, tmp_path, (WIDTH, HEIGHT), samples=512)
    exact = studio.lens(name, film, focus, focal_length_mm=focal_length)
    points = place_lamps(studio, exact, PLACES, depths, diameter_px)
    expected = [exact.picture_of(point) for point in points]
    found = spots(studio.shoot(), [spot.centroid for spot in expected])
    errors = [spot.centroid - truth.centroid for spot, truth in zip(found, expected, strict=True)]
    print(case, np.round(errors, 4).tolist())
    assert np.abs(errors).max() < 0.05, errors
