# SPDX-License-Identifier: GPL-3.0-or-later
"""Lenses of a lensfun database as cameras: places, red and blue beside green, and brightness in pictures are what lensfun's library computes
(tests/reference/lensfun/lensfun.json)."""

from __future__ import annotations

import json
import math
import re

import numpy as np
import pytest

from support.places import TESTS

pytestmark = pytest.mark.once

LENSES = TESTS / "reference/lensfun/lenses.xml"
REFERENCE = json.loads((TESTS / "reference/lensfun/lensfun.json").read_text())
WIDTH, HEIGHT = 300, 200
#: Diagonal of a film of 36 by 24 mm, to which crop factors refer.
FULL_DIAGONAL_MM = math.hypot(36.0, 24.0)


def setting_of(lens: str, focal_mm: float) -> dict:
    return next(one for one in REFERENCE if one["model"] == lens and one["focal_mm"] == focal_mm)


@pytest.fixture
def camera(blender, parts):
    """A scene with a camera of a setting of the reference, on a picture whose diagonal is the sensor's; and a pixel's side, mm."""

    def make(setting: dict, samples: int):
        scene = parts.set_up(WIDTH, HEIGHT, samples, model="CALIBRATED")
        scene.world = parts.grey_world(0.0)
        data = scene.camera.data
        data.sensor_fit, data.sensor_width = "HORIZONTAL", FULL_DIAGONAL_MM / setting["crop"] * 3.0 / math.sqrt(13.0)
        data.lens, data.dof.aperture_fstop = setting["focal_mm"], setting["f_number"]
        data.petzval.calibration_file, data.petzval.calibration_camera = str(LENSES), setting["model"]
        return scene, data.sensor_width / WIDTH

    return make


def pixel_of(mm, pitch_mm: float, centre=(0.0, 0.0)) -> np.ndarray:
    """From the lower left corner, in pixels; points have y down, and centres count in halves of the short side."""
    middle = np.array([WIDTH, HEIGHT]) / 2 + np.array([centre[0], -centre[1]]) * HEIGHT / 2
    return middle + np.array([mm[0], -mm[1]]) / pitch_mm


#: A lens of Adobe's models, made up.
MADE_UP = "Made-up 20-60mm of Adobe's models"


def test_lights_are_where_lensfun_has_them(camera, parts, tmp_path):
    """Distortion as lensfun's library computes it; red and blue by its model "linear", which enlarges them."""
    larger = {"red": 1.01, "blue": 0.992}
    text = re.sub(r'<tca model="acm" focal="[26]0".*?/>', "", LENSES.read_text())
    row = f'<tca model="linear" focal="20" kr="{larger["red"]}" kb="{larger["blue"]}"/>'
    database = tmp_path / "lenses.xml"
    database.write_text(
        text.replace(
            '<vignetting model="acm" focal="20" aperture="4"', f'{row}<vignetting model="acm" focal="20" aperture="4"'
        )
    )
    setting = setting_of(MADE_UP, 20)
    scene, pitch_mm = camera(setting, 128)
    scene.camera.data.petzval.calibration_file = str(database)
    scene.petzval.filter_width = 0.0
    for effect in ("vignetting", "lateral_colour"):
        setattr(scene.petzval.effects, effect, "ON")
    shown = []
    for i, row in enumerate(setting["points"]):
        x, y = (value / setting["real_focal_mm"] for value in row["at_mm"])
        green = pixel_of(row["distorted_mm"], pitch_mm)
        if (green > 12).all() and (green < np.array([WIDTH, HEIGHT]) - 12).all():
            # 20 units away, along +y; six pixels wide.
            size = 20.0 * 6.0 * pitch_mm / setting["focal_mm"]
            parts.square(f"Light {i}", (20.0 * x, 20.0, -20.0 * y), size, parts.emitter((1.0, 1.0, 1.0), 1.0))
            shown.append(green)
    picture = parts.render(tmp_path)[..., :3].astype(float)
    rows, columns = np.mgrid[0:HEIGHT, 0:WIDTH] + 0.5
    middle = np.array([WIDTH, HEIGHT]) / 2
    assert len(shown) >= 3
    for green in shown:
        near = np.hypot(columns - green[0], rows - green[1]) < 11.0
        found = {}
        for channel, key in enumerate(("red", "green", "blue")):
            light = picture[..., channel] * near
            found[key] = np.array([(light * columns).sum(), (light * rows).sum()]) / light.sum()
        # Some 24 pixels of the edge, by a third of 128 samples each, know the middle to 0.03 pixels.
        assert np.abs(found["green"] - green).max() < 0.1, (found, green)
        for key, factor in larger.items():
            assert np.abs(found[key] - middle - factor * (green - middle)).max() < 0.1, (key, found, green)
    # More than the error.
    assert np.linalg.norm(shown[-1] - middle) * 0.008 > 0.5


def test_a_white_world_darkens_as_measured(camera, parts, tmp_path):
    """At a setting that was measured: the formula's own light, but for what a pixel is wide."""
    setting = setting_of("Nikkor Z 24-70mm f/4 S", 24)
    scene, pitch_mm = camera(setting, 16)
    scene.world = parts.grey_world(1.0)
    scene.petzval.effects.lateral_colour = "OFF"
    picture = parts.render(tmp_path)
    checked = 0
    for row in setting["points"]:
        at = pixel_of(row["at_mm"], pitch_mm) - 0.5
        column, line = np.floor(at).astype(int)
        if 0 <= column < WIDTH - 1 and 0 <= line < HEIGHT - 1:
            part = at - [column, line]
            corners = picture[line : line + 2, column : column + 2, :3]
            light = np.einsum("ijc,i,j->c", corners, [1 - part[1], part[1]], [1 - part[0], part[0]])
            # Between the middles of pixels 0.12 mm apart, in which samples lie at random.
            assert light == pytest.approx(1.0 / row["gain"], rel=2e-3), row
            checked += 1
    assert checked >= 3
    # Off: as bright everywhere.
    scene.petzval.effects.vignetting = "OFF"
    assert parts.render(tmp_path)[..., :3] == pytest.approx(1.0, abs=1e-5)
    # With red, green and blue apart it is as bright, and white.
    scene.petzval.effects.lateral_colour = "ON"
    assert parts.render(tmp_path)[..., :3].mean((0, 1)) == pytest.approx(1.0, abs=2e-3)


def test_the_f_number_is_that_of_the_blur(camera, parts):
    """Petzval's own where there is one, as `--f-number` sets it, else Blender's; with depth of field and without."""
    from petzval_addon.export import camera as camera_export
    from petzval_addon.export.report import Report

    scene, _ = camera(setting_of("Nikkor Z 24-70mm f/4 S", 24), 1)
    data = scene.camera.data

    def found():
        told = camera_export.describe(scene.camera, scene, WIDTH, HEIGHT, Report())
        return told.calibration.f_number, told.lens.f_number

    assert found() == (4.0, None)
    data.petzval.wide_open, data.petzval.f_number = False, 8.0
    assert found() == (8.0, None)
    data.dof.use_dof = True
    assert found() == (8.0, 8.0)
