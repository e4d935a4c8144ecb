# SPDX-License-Identifier: GPL-3.0-or-later
"""Depth, Position and Cryptomatte through a lens whose film is turned and shifted, of what is far out of focus: against exact
rays from the film, which meet a box before a leaning wall by closed forms."""

from __future__ import annotations

from math import radians

import numpy as np
import pytest

from support.photograph.chart import Studio
from support.photograph.truth import Camera

pytestmark = pytest.mark.once

PIXELS, FILM_MM = (24, 16), (12.0, 8.0)
FOCUS, SAMPLES = 1.6, 576
#: Places within a pixel.
INNER = [((i + 0.5) / 4, (j + 0.5) / 4) for i in range(4) for j in range(4)]
#: Of the wall: a point, and which way it faces; of the box: its corners. Camera space.
WALL, FACES = np.array([0.0, 0.0, -2.6]), np.array([0.5, -0.2, 1.0])
LOW, HIGH = np.array([-0.07, -0.05, -1.2]), np.array([0.05, 0.04, -0.85])


def met(starts: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where rays meet the box or the wall, and whether the box."""
    to_wall = ((WALL - starts) @ FACES) / (directions @ FACES)
    with np.errstate(divide="ignore"):
        sides = np.sort(np.stack([(LOW - starts) / directions, (HIGH - starts) / directions]), axis=0)
    enters, leaves = sides[0].max(1), sides[1].min(1)
    is_box = (enters < leaves) & (enters > 0.0) & (enters < to_wall)
    return starts + directions * np.where(is_box, enters, to_wall)[:, None], is_box


def expected(exact: Camera, column: int, row: int) -> tuple[np.ndarray, float]:
    """The mean place that a pixel sees, and the box's part of it."""
    places, box = met(*exact.seen_from([(column + x, row + y) for x, y in INNER], grid=12))
    return places.mean(0), float(box.mean())


def build(blender, studio: Studio) -> None:
    from support import scenes

    grey = scenes.emitter()
    z = FACES / np.linalg.norm(FACES)
    x = np.cross([0.0, 1.0, 0.0], z)
    x /= np.linalg.norm(x)
    y = np.cross(z, x)
    corners = [WALL + 4.0 * (a * x + b * y) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    scenes.mesh_object("Wall", corners, [(0, 1, 2, 3)], grey)
    at = [[(LOW, HIGH)[i >> axis & 1][axis] for axis in range(3)] for i in range(8)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    scenes.mesh_object("Box", at, faces, grey)
    layer = studio.scene.view_layers[0]
    layer.use_pass_z = layer.use_pass_position = layer.use_pass_cryptomatte_object = True


# Scene-first counts a ray for the pixel that it was started for: where the lens is sharp (docs/design/passes.md).
@pytest.mark.parametrize(("pipeline", "stop", "off"), [("FILM", {}, 0.04), ("SCENE", {"f_number": 4.0}, 0.08)])
def test_what_a_turned_film_sees(blender, tmp_path, pipeline, stop, off):
    from support import scenes
    from support.multilayer import mattes, photograph

    studio = Studio(blender, tmp_path, PIXELS)
    exact = studio.lens(
        "double-gauss-f2-tronnier",
        FILM_MM,
        FOCUS,
        focal_length_mm=50.0,
        tilt_rad=radians(-6.0),
        swing_rad=radians(11.0),
        shift_mm=(2.0, -1.0),
        **stop,
    )
    build(blender, studio)
    studio.scene.petzval.filter_width = 0.0
    studio.scene.petzval.pipeline = pipeline
    channels, _ = photograph(scenes, studio.scene, tmp_path / "passes.exr", samples=SAMPLES)
    depth = next(pixels for name, pixels in channels.items() if name in ("depth.z", "depth.v"))
    place = np.stack([channels[f"position.{axis}"] for axis in "xyz"], -1)
    # The box's is the smaller one.
    both = list(mattes(channels, "Object").values())
    matte = min(both, key=lambda one: one.mean())
    errors = []
    for column in range(0, PIXELS[0], 4):
        for row in range(0, PIXELS[1], 3):
            want, box = expected(exact, column, row)
            errors.append([*(place[row, column] - want), depth[row, column] + want[2], matte[row, column] - box, box])
    errors, box = np.array(errors)[:, :5], np.array(errors)[:, 5]
    print(f"{pipeline}: worst {np.abs(errors).max(0).round(4)}, mean {errors.mean(0).round(4)}")
    assert ((box > 0.02) & (box < 0.98)).sum() > 4, f"{box.round(2)}: nothing is unsharp"
    # The box is 1.6 nearer than the wall: a pixel's noise is that of its part, 1 / sqrt(samples) at most.
    assert np.abs(errors[:, :2]).max() < 0.01 and np.abs(errors[:, 2:4]).max() < 1.75 * off
    assert np.abs(errors[:, 4]).max() < off
    assert np.abs(errors.mean(0)).max() < 0.006
    # Where all rays meet the wall places lie in it, and depth is the place's.
    whole = (matte == 0.0) & (sum(both) > 0.999)
    assert np.abs((place[whole] - WALL) @ FACES).max() < 1e-4
    assert np.abs(depth[whole] + place[whole][:, 2]).max() < 1e-4
