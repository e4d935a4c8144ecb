# SPDX-License-Identifier: GPL-3.0-or-later
"""The places of points of a scene in the photograph: exact rays from the scene against Blender's render."""

from __future__ import annotations

from math import radians

import numpy as np
import pytest

from support.photograph.chart import Studio, spots

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


def place_lamps(studio: Studio, exact, places, depths, diameter_px, matrix=None) -> list[np.ndarray]:
    """Lamps that a pinhole would show at `places`, their depths in turn; their positions in camera space."""
    focal = exact.info["efl_mm"]
    points = []
    for number, (right, up) in enumerate(places):
        depth = depths[number % len(depths)]
        x = right * 0.5 * exact.picture_mm[0] / focal * depth
        y = up * 0.5 * exact.picture_mm[1] / focal * depth
        pixel = exact.picture_mm[0] / exact.pixels[0] / focal * depth
        point = np.array([x, y, -depth])
        studio.lamp(point, 0.5 * diameter_px * pixel, matrix)
        points.append(point)
    return points


@pytest.mark.once
@pytest.mark.parametrize("case", LENSES)
def test_points_lie_where_exact_rays_meet_the_film(blender, tmp_path, case):
    name, focal_length, film, focus, depths, diameter_px = LENSES[case]
    studio = Studio(blender, tmp_path, (WIDTH, HEIGHT), samples=512)
    exact = studio.lens(name, film, focus, focal_length_mm=focal_length)
    points = place_lamps(studio, exact, PLACES, depths, diameter_px)
    expected = [exact.picture_of(point) for point in points]
    found = spots(studio.shoot(), [spot.centroid for spot in expected])
    errors = [spot.centroid - truth.centroid for spot, truth in zip(found, expected, strict=True)]
    # A lamp's image has some 1500 samples of 0.8 pixel's spread: 0.02 pixel without stratification, 0.01 with.
    assert np.abs(errors).max() < 0.05, errors


@pytest.mark.once
def test_a_camera_anywhere_takes_the_same_picture(blender, tmp_path):
    """Moved, turned, scaled and upside down: upright is the camera's own up, and nothing is mirrored."""
    from mathutils import Matrix

    name, focal_length, film, focus, depths, diameter_px = LENSES["double Gauss"]
    studio = Studio(blender, tmp_path, (WIDTH, HEIGHT), samples=256)
    exact = studio.lens(name, film, focus, focal_length_mm=focal_length)
    studio.holder.location = (12.0, -7.0, 3.0)
    studio.holder.rotation_euler = (radians(100.0), radians(170.0), radians(-40.0))
    studio.holder.scale = (2.0, 2.0, 2.0)
    blender.context.view_layer.update()
    place, turn, _scale = studio.holder.matrix_world.decompose()
    points = place_lamps(studio, exact, PLACES, depths, diameter_px, Matrix.LocRotScale(place, turn, None))
    expected = [exact.picture_of(point).centroid for point in points]
    found = [spot.centroid for spot in spots(studio.shoot(), expected)]
    assert np.abs(np.array(found) - expected).max() < 0.05, (found, expected)


def test_right_is_right_and_up_is_up(blender, tmp_path):
    """In words, without the lens's own coordinates: Blender's x is right, its y is up, the first row is the lowest."""
    studio = Studio(blender, tmp_path, (24, 16), samples=64)
    studio.lens("double-gauss-f2-tronnier", (36.0, 24.0), 2.0, focal_length_mm=50.0)
    studio.lamp((0.4, 0.25, -2.0), 0.05)
    (spot,) = spots(studio.shoot(), [np.zeros(2)])
    assert spot.centroid[0] > 15.0
    assert spot.centroid[1] > 10.0


@pytest.mark.parametrize("case", ["wide angle", "double Gauss"])
def test_magnification_and_blenders_frame(blender, tmp_path, case):
    """Near the axis the image is as large as the paraxial magnification says, and lies where Blender's own camera,
    kept in step with the lens, shows it."""
    from bpy_extras.object_utils import world_to_camera_view
    from mathutils import Vector

    name, focal_length, film, focus, _depths, _diameter = LENSES[case]
    studio = Studio(blender, tmp_path, (WIDTH, HEIGHT), samples=256)
    exact = studio.lens(name, film, focus, focal_length_mm=focal_length)
    blender.context.view_layer.update()
    places = ((0.15, 0.0), (-0.15, 0.0), (0.0, 0.22), (0.0, -0.22))
    points = place_lamps(studio, exact, places, (focus,), 2.5)
    framed = [world_to_camera_view(studio.scene, studio.holder, Vector(point)) for point in points]
    framed = [np.array([at.x * WIDTH, at.y * HEIGHT]) for at in framed]
    found = [spot.centroid for spot in spots(studio.shoot(), framed)]
    # Newton's form: image over object is the focal length over the object's distance from the object focal point.
    info = exact.info
    from_focus = info["object_focal_plane_mm"] - (exact.pupil_z_mm - 1000.0 * focus)
    pixels_per_unit = 1000.0 * info["efl_mm"] / from_focus / (exact.picture_mm[0] / WIDTH)
    for one, other in ((0, 1), (2, 3)):
        image = np.linalg.norm(found[one] - found[other])
        object_size = np.linalg.norm(points[one] - points[other])
        # 0.02 pixel of noise over 14 pixels; distortion is 0.1 % at a tenth of the field.
        assert image == pytest.approx(object_size * pixels_per_unit, rel=4e-3)
    assert np.abs(np.array(found) - framed).max() < 0.06, (found, framed)


@pytest.mark.once
def test_the_same_bits_for_any_threads_and_others_for_another_seed(blender, tmp_path):
    studio = Studio(blender, tmp_path, (48, 32), samples=24)
    exact = studio.lens("double-gauss-f2-tronnier", (36.0, 24.0), 2.0, focal_length_mm=50.0)
    studio.data.petzval.spectrum = "VISIBLE"
    place_lamps(studio, exact, PLACES, (2.0, 1.2), 4.0)
    render = studio.scene.render
    render.threads_mode = "FIXED"
    render.threads = 1
    one = studio.shoot()
    render.threads = 2
    assert np.array_equal(one, studio.shoot())
    studio.scene.petzval.seed = 1
    other = studio.shoot()
    assert not np.array_equal(one, other)
    # The same photograph all the same: 24 samples, some thousand of them on lamps.
    assert other.sum() == pytest.approx(one.sum(), rel=0.05)


@pytest.mark.once
def test_ranges_of_samples_average_to_the_whole(blender, tmp_path):
    studio = Studio(blender, tmp_path, (48, 32), samples=16)
    exact = studio.lens("double-gauss-f2-tronnier", (36.0, 24.0), 2.0, focal_length_mm=50.0)
    place_lamps(studio, exact, PLACES, (2.0, 1.2), 4.0)
    studio.scene.petzval.use_blue_noise = False
    first = studio.shoot()
    studio.scene.petzval.sample_offset = 16
    studio.scene.petzval.samples = 48
    second = studio.shoot()
    studio.scene.petzval.sample_offset = 0
    studio.scene.petzval.samples = 64
    whole = studio.shoot()
    assert not np.array_equal(first, second)
    # Sums of single precision.
    assert np.abs(0.25 * first + 0.75 * second - whole).max() < 1e-5 * whole.max()
