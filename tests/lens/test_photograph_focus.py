# SPDX-License-Identifier: GPL-3.0-or-later
"""Ways to say the same thing give the same photograph: of the focus, of the focal length, of the world's scale."""

from __future__ import annotations

import json
import sys

import numpy as np
import pytest

from petzval import _native
from petzval.description import LensSettings, focal_length
from support.photograph.chart import LENSES, Studio, spots

WIDE_ANGLE = "wide-angle-smith-f3.4"
FILM = (120.0, 80.0)
WIDTH, HEIGHT = 48, 32


def info(studio: Studio) -> dict:
    """The lens data that the panel shows."""
    studio.bpy.context.view_layer.update()
    shown = sys.modules["petzval_addon"].queries.lens_info.of_camera(studio.holder, studio.scene)
    assert "error" not in shown, shown
    return shown


def film_z(studio: Studio) -> float:
    return info(studio)["film_z_mm"]


@pytest.fixture
def studio(blender, tmp_path):
    return Studio(blender, tmp_path, (WIDTH, HEIGHT), samples=32)


def exact_film_z(focus_mm: float | None, focal_length_mm: float | None = None, **settings) -> float:
    lens = _native.Lens(str(LENSES / f"{WIDE_ANGLE}.lens"))
    return json.loads(
        lens.info_json(LensSettings(focal_length(focal_length_mm), **settings), focus_distance_mm=focus_mm)
    )["film_z_mm"]


def test_the_film_stands_where_newton_says(studio):
    lens = _native.Lens(str(LENSES / f"{WIDE_ANGLE}.lens"))
    plain = json.loads(lens.info_json())
    for focus in (0.7, 2.0, 50.0):
        exact = studio.lens(WIDE_ANGLE, FILM, focus)
        before_focus = plain["object_focal_plane_mm"] - (exact.pupil_z_mm - 1000.0 * focus)
        expected = plain["image_focal_plane_mm"] + plain["efl_mm"] ** 2 / before_focus
        # Blender keeps the focus distance in single precision.
        assert film_z(studio) == pytest.approx(expected, abs=1e-5)
        assert info(studio)["focus_distance_mm"] == pytest.approx(1000.0 * focus, rel=1e-6)


def test_an_object_is_focused_by_its_depth(studio, blender):
    studio.lens(WIDE_ANGLE, FILM, 2.0)
    by_distance = film_z(studio)
    studio.holder.location = (3.0, -1.0, 0.5)
    studio.holder.rotation_euler = (1.2, 0.3, 0.7)
    blender.context.view_layer.update()
    target = blender.data.objects.new("Target", None)
    studio.scene.collection.objects.link(target)
    # Two units before the camera, and well to its side.
    target.location = studio.holder.matrix_world @ type(studio.holder.location)((0.8, -0.4, -2.0))
    studio.data.dof.focus_object = target
    studio.data.dof.focus_distance = 7.0
    assert film_z(studio) == pytest.approx(by_distance, abs=1e-4)
    studio.data.dof.focus_object = None
    assert film_z(studio) < by_distance - 0.1


@pytest.mark.once
def test_infinity_is_what_far_distances_come_to(studio):
    studio.lens(WIDE_ANGLE, FILM, None)
    # Blender keeps the wavelength in single precision.
    assert film_z(studio) == pytest.approx(exact_film_z(None), abs=1e-6)
    assert info(studio)["focus_distance_mm"] is None
    at_infinity = film_z(studio)
    studio.lens(WIDE_ANGLE, FILM, 1e6)
    assert film_z(studio) == pytest.approx(at_infinity, abs=1e-4)
    assert film_z(studio) > at_infinity


@pytest.mark.once
def test_a_film_distance_is_a_focus_distance(studio):
    """Set to the film's distance that a focus distance gave, it gives that focus distance again, and the picture."""
    exact = studio.lens(WIDE_ANGLE, FILM, 1.2)
    lamps(studio, exact)
    shown = info(studio)
    by_focus = studio.shoot()
    own = studio.data.petzval
    own.focus_mode = "FILM"
    own.film_distance = shown["film_distance_mm"]
    again = info(studio)
    # Single precision: 3e-8 of 35 mm of film distance is 2e-7 mm, a ten thousandth of a millimetre at 1.2 m.
    assert again["focus_distance_mm"] == pytest.approx(1200.0, abs=1e-2)
    assert again["film_z_mm"] == pytest.approx(shown["film_z_mm"], abs=1e-5)
    assert_same_picture(studio.shoot(), by_focus)


@pytest.mark.once
def test_a_focal_length_is_a_scale(studio):
    published = json.loads(_native.Lens(str(LENSES / f"{WIDE_ANGLE}.lens")).info_json())["efl_mm"]
    exact = studio.lens(WIDE_ANGLE, (36.0, 24.0), 1.2, focal_length_mm=28.0)
    lamps(studio, exact)
    by_length, shown = studio.shoot(), info(studio)
    assert shown["efl_mm"] == pytest.approx(28.0, rel=1e-6)
    own = studio.data.petzval
    own.focal_mode = "SCALE"
    own.focal_scale = 28.0 / published
    assert info(studio)["efl_mm"] == pytest.approx(28.0, rel=1e-6)
    assert info(studio)["f_number"] == pytest.approx(shown["f_number"], rel=1e-6)
    assert_same_picture(studio.shoot(), by_length)
    own.focal_mode = "PUBLISHED"
    assert info(studio)["efl_mm"] == pytest.approx(published, rel=1e-9)


@pytest.mark.parametrize("units_per_metre", [1000.0, 0.01])
def test_a_world_in_other_units_is_the_same_world(blender, tmp_path, units_per_metre):
    """Everything a thousand times as large, in a scene whose unit is a thousandth: in millimetres nothing changed."""
    pictures = []
    for scale in (1.0, units_per_metre):
        studio = Studio(blender, tmp_path, (WIDTH, HEIGHT), samples=32)
        studio.scene.unit_settings.scale_length = 1.0 / scale
        studio.data.clip_start, studio.data.clip_end = 0.1 * scale, 100.0 * scale
        exact = studio.lens(WIDE_ANGLE, FILM, 1.2 * scale)
        lamps(studio, exact, scale)
        pictures.append(studio.shoot())
        # The same by hand: millimetres for a unit, instead of the scene's scale.
        own = studio.data.petzval
        own.scale_from_scene = False
        own.scale = (1000.0 / scale,) * 3
        studio.scene.unit_settings.scale_length = 1.0
        pictures.append(studio.shoot())
        blender.ops.wm.read_factory_settings(use_empty=True)
    for other in pictures[1:]:
        assert_same_picture(other, pictures[0])


def lamps(studio: Studio, exact, scale: float = 1.0) -> None:
    for place in ((0.0, 0.0, -1.2), (0.3, 0.2, -1.2), (-0.6, 0.35, -2.0), (-0.15, -0.2, -0.8)):
        studio.lamp(np.array(place) * scale, 0.04 * scale)


def assert_same_picture(one: np.ndarray, other: np.ndarray) -> None:
    """The same samples: only those at the very edge of a lamp may fall to its other side by rounding."""
    assert one.max() > 0.05
    differing = np.abs(one - other).sum() / one.sum()
    assert differing < 2e-3, differing
    centres = [spot.centroid for spot in spots(one, [np.array([WIDTH, HEIGHT]) / 2.0])]
    again = [spot.centroid for spot in spots(other, [np.array([WIDTH, HEIGHT]) / 2.0])]
    assert np.abs(np.array(centres) - again).max() < 5e-3
