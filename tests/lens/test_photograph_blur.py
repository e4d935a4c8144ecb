# SPDX-License-Identifier: GPL-3.0-or-later
"""The blur of points in the photograph: circles and polygons of confusion, and planes that a turned film leans."""

from __future__ import annotations

import cmath
from math import radians, sqrt

import numpy as np
import pytest

from support.photograph.chart import FILTER_VARIANCE, Studio, spots
from support.photograph.truth import Camera, Spot

pytestmark = pytest.mark.once

DOUBLE_GAUSS = "double-gauss-f2-tronnier"
FOCAL_MM, FOCUS = 50.0, 2.0


class Lamp:
    """A lamp whose image is about so large, and its addition to the covariance of its spot."""

    def __init__(self, exact: Camera, at: np.ndarray, diameter_px: float) -> None:
        scale = exact.scale_at(at)
        self.radius = 0.5 * diameter_px / sqrt(abs(np.linalg.det(scale)))
        # A disc's variance is r^2 / 4.
        self.covariance = 0.25 * self.radius**2 * scale @ scale.T

    def blur(self, spot: Spot) -> float:
        """The diameter of a disc as unsharp as a found spot is, without the lamp's size and the pixel filter."""
        own = spot.covariance - self.covariance - np.eye(2) * FILTER_VARIANCE
        return diameter(own)


def diameter(covariance: np.ndarray) -> float:
    """The diameter of a disc with this covariance."""
    return 4.0 * sqrt(max(np.trace(covariance) / 2.0, 0.0))


#: Depth, f-number, blades, turn of the blades in degrees, and the width of the film that gives a blur of some 14 pixels.
CIRCLES = {
    "near": (0.6, None, 0, 0.0, 3.6),
    "far": (8.0, None, 0, 0.0, 1.2),
    "near, f/4": (0.6, 4.0, 0, 0.0, 1.8),
    "near, six blades": (0.6, 2.4, 6, 10.0, 3.0),
    "near, five blades": (0.6, 2.4, 5, 25.0, 3.0),
    "far, five blades": (8.0, 2.4, 5, 25.0, 1.0),
}


@pytest.mark.parametrize("case", CIRCLES)
def test_a_circle_of_confusion_is_that_of_exact_rays(blender, tmp_path, case):
    depth, f_number, blades, turn_deg, film_mm = CIRCLES[case]
    studio = Studio(blender, tmp_path, (36, 36), samples=1024)
    extra = {} if f_number is None else {"f_number": f_number}
    exact = studio.lens(
        DOUBLE_GAUSS,
        (film_mm, film_mm),
        FOCUS,
        focal_length_mm=FOCAL_MM,
        blades=blades,
        blade_rotation_rad=radians(turn_deg),
        **extra,
    )
    at = depth * np.array([0.0005, -0.0003, -1.0])
    lamp = Lamp(exact, at, 5.0)
    studio.lamp(at, lamp.radius)
    expected = exact.picture_of(at, grid=80)
    (found,) = spots(studio.shoot(), [expected.centroid])
    exact_diameter = diameter(expected.covariance)
    assert 9.0 < exact_diameter < 22.0, exact_diameter
    # Some 30000 samples on the lamp: 0.3 % of the diameter.
    assert lamp.blur(found) == pytest.approx(exact_diameter, rel=0.02)
    assert np.abs(found.centroid - expected.centroid).max() < 0.1
    if blades:
        # The moment of a shape's own symmetry: neither round lamps nor filters add to it.
        moment, exact_moment = (symmetry_moment(spot, blades) for spot in (found, expected))
        difference = cmath.phase(moment / exact_moment) / blades
        assert abs(difference) < radians(1.5)
        assert abs(moment) == pytest.approx(abs(exact_moment), rel=0.1)


def symmetry_moment(spot: Spot, fold: int) -> complex:
    away = (spot.at - spot.centroid) @ np.array([1.0, 1.0j])
    return complex(spot.weight @ away**fold / spot.weight.sum())


def test_a_pentagon_turns_over_where_the_focus_is_passed(blender, tmp_path):
    """Without exact rays: one corner of the opening points to the right as the lens is seen from behind. Nearer than the
    focus the rays hit the film before they have crossed, and the picture is the film turned by half a turn."""
    moments = {}
    for depth, film_mm in ((0.6, 3.0), (8.0, 1.0)):
        studio = Studio(blender, tmp_path, (36, 36), samples=128)
        exact = studio.lens(DOUBLE_GAUSS, (film_mm, film_mm), FOCUS, focal_length_mm=FOCAL_MM, f_number=2.4, blades=5)
        at = np.array([0.0, 0.0, -depth])
        studio.lamp(at, Lamp(exact, at, 6.0).radius)
        (spot,) = spots(studio.shoot(), [np.full(2, 18.0)])
        moments[depth] = symmetry_moment(spot, 5)
        blender.ops.wm.read_factory_settings(use_empty=True)
    # z^5 of a corner to the left is negative, to the right positive.
    for depth, sign in ((0.6, -1.0), (8.0, 1.0)):
        assert abs(cmath.phase(sign * moments[depth])) < radians(20.0), moments


#: The turn of the film in degrees, tilt and swing, and places in the picture (parts of its half size): two for lamps
#: where the leaning plane is sharp, two for lamps as far away as the middle's focus.
TURNS = {
    "tilt": (14.0, 0.0, ((0.05, 0.7), (-0.05, -0.7)), ((0.35, 0.7), (-0.35, -0.7))),
    "swing": (0.0, -14.0, ((0.45, 0.05), (-0.45, -0.05)), ((0.45, 0.5), (-0.45, -0.5))),
    "both": (9.0, -9.0, ((0.35, 0.6), (-0.35, -0.6)), ((0.6, 0.25), (-0.6, -0.25))),
}
TURNED_FOCUS = 1.0


@pytest.mark.parametrize("case", TURNS)
def test_a_turned_film_makes_a_leaning_plane_sharp(blender, tmp_path, case):
    """At each place of the film Newton's x x' = f^2 says what depth is sharp: a lamp there is a point, in its exact
    place; a lamp as deep as the middle's focus is as unsharp as exact rays say."""
    tilt, swing, sharp, unsharp = TURNS[case]
    film = (36.0, 24.0)
    studio = Studio(blender, tmp_path, (132, 88), samples=300)
    turn = {"tilt_rad": radians(tilt), "swing_rad": radians(swing)}
    exact = studio.lens(DOUBLE_GAUSS, film, TURNED_FOCUS, focal_length_mm=FOCAL_MM, **turn)
    points = [conjugate(exact, right * film[0] / 2.0, up * film[1] / 2.0) for right, up in (*sharp, *unsharp)]
    for number in range(len(sharp), len(points)):
        points[number] *= TURNED_FOCUS / -points[number][2]
    lamps = [Lamp(exact, at, 3.0) for at in points]
    for at, lamp in zip(points, lamps, strict=True):
        studio.lamp(at, lamp.radius)
    expected = [exact.picture_of(at) for at in points]
    found = spots(studio.shoot(), [spot.centroid for spot in expected])
    for number, (lamp, spot, exact_spot) in enumerate(zip(lamps, found, expected, strict=True)):
        exact_blur = diameter(exact_spot.covariance)
        # Some 2000 samples on a lamp of 1.1 to 1.4 pixels' spread: 0.03 pixel, half of it as they are stratified.
        assert np.abs(spot.centroid - exact_spot.centroid).max() < (0.05 if number < len(sharp) else 0.07)
        if number < len(sharp):
            # A wide open lens's aberrations are left; the noise of the spread, 2 % of 1.1, hides that much.
            assert exact_blur < 0.4
            assert lamp.blur(spot) < 0.8
        else:
            # The noise of the spread, 1.5 % of 1.4, is 4 % of the blur's part of it.
            assert exact_blur > 2.5
            assert lamp.blur(spot) == pytest.approx(exact_blur, rel=0.08)


def conjugate(exact: Camera, right_mm: float, up_mm: float) -> np.ndarray:
    """The point of camera space that is sharp, paraxially, at a place of the picture, mm from its middle."""
    info = exact.info
    # The film shows the scene turned by half a turn.
    x, y, z = np.array([-right_mm, -up_mm, 0.0]) @ exact.film_axes + np.array([0.0, 0.0, exact.film_z_mm])
    behind_focus = z - info["image_focal_plane_mm"]
    before_focus = info["efl_mm"] ** 2 / behind_focus
    depth_mm = exact.pupil_z_mm - (info["object_focal_plane_mm"] - before_focus)
    enlarged = -before_focus / info["efl_mm"]
    return np.array([x * enlarged, y * enlarged, -depth_mm]) / exact.mm_per_unit
