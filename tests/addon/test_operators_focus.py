# SPDX-License-Identifier: GPL-3.0-or-later
"""Focusing on objects, the 3D cursor and points of the picture, and a lens that frames like Blender's camera: by exact rays."""

from __future__ import annotations

import math

import numpy as np
import pytest

from petzval import _native


@pytest.fixture
def scene(blender):
    """A camera at the origin that looks along +y through a triplet at f/11; a square 5 m away, a cube beside it, nearer."""
    from support import scenes

    made = scenes.set_up(width=96, height=64, model="LENS")
    own = made.camera.data.petzval
    own.lens_file, own.wide_open, own.f_number = "cooke-triplet-50mm", False, 11.0
    scenes.square("Square", (0.0, 5.0, 0.0), 1.0)
    blender.ops.mesh.primitive_cube_add(size=0.2, location=(0.4, 3.0, 0.2))
    blender.context.active_object.name = "Box"
    blender.context.view_layer.update()
    return made


def film_mm(scene) -> float:
    from support import scenes

    return scenes.part("queries.lens_info").of_camera(scene.camera, scene)["film_distance_mm"]


def sharpest_film_mm(scene, point, depth) -> float:
    """By the engine, for a wall that fills the picture at that depth."""
    import json

    from support import scenes

    camera_export = scenes.part("export.camera")
    report = scenes.part("export.report").Report()
    size = camera_export.resolution(scene.render)
    camera = camera_export.describe(scene.camera, scene, *size, report)

    def distance_to(origin, direction):
        return (depth - origin[1]) / direction[1]

    return json.loads(_native.autofocus_by_json(camera, *size, point, distance_to))["film_distance_mm"]


def activate(bpy, name):
    bpy.context.view_layer.objects.active = bpy.data.objects[name]


def test_a_point_of_the_picture_is_sharp(blender, scene):
    assert blender.ops.petzval.pick_focus(point=(0.5, 0.5)) == {"FINISHED"}
    assert scene.camera.data.petzval.focus_mode == "CAMERA"
    # The setting holds single precision of the distance, which the film's place changes by a thousandth of a part of.
    assert film_mm(scene) == pytest.approx(sharpest_film_mm(scene, (0.5, 0.5), 5.0), abs=1e-5)
    # Beside the square there is nothing.
    assert blender.ops.petzval.pick_focus(point=(0.1, 0.9)) == {"FINISHED"}
    info = film_mm(scene)
    assert info == pytest.approx(sharpest_film_mm(scene, (0.1, 0.9), 1e7), abs=1e-3)


def test_the_nearest_surface_of_an_object_in_the_picture(blender, scene):
    activate(blender, "Box")
    assert blender.ops.petzval.focus_on_object(part="SURFACE") == {"FINISHED"}
    x, y, z = 0.3 / 2.9, 0.1 / 2.9, 2.9  # one of the corners at the front, all of one depth
    focused = film_mm(scene)
    info = scene.camera.data
    half = 0.5 * info.sensor_width / info.lens
    point = 0.5 + 0.5 * x / half, 0.5 + 0.5 * y / (half * 64 / 96)
    assert focused == pytest.approx(sharpest_film_mm(scene, point, z), abs=2e-3)
    assert blender.ops.petzval.focus_on_object(part="ORIGIN") == {"FINISHED"}
    assert film_mm(scene) < focused


def test_the_cursor_in_and_beside_the_picture(blender, scene):
    scene.cursor.location = (0.0, 2.0, 0.0)
    assert blender.ops.petzval.focus_on_cursor() == {"FINISHED"}
    assert film_mm(scene) == pytest.approx(sharpest_film_mm(scene, (0.5, 0.5), 2.0), abs=1e-5)
    # Outside of the picture its depth counts.
    scene.cursor.location = (30.0, 2.0, 0.0)
    assert blender.ops.petzval.focus_on_cursor() == {"FINISHED"}
    assert scene.camera.data.dof.focus_distance == pytest.approx(2.0, rel=1e-6)
    scene.cursor.location = (0.0, -2.0, 0.0)
    with pytest.raises(RuntimeError, match="behind the camera"):
        blender.ops.petzval.focus_on_cursor()


def test_a_pixel_of_the_camera_view_is_a_point_of_the_picture(blender, scene, monkeypatch):
    """Without a window: a view that shows the camera's frame over a known rectangle."""
    from support import scenes

    picking = scenes.part("operators.focus_picking")
    frame = scene.camera.data.view_frame(scene=scene)
    right, top, depth = max(c.x for c in frame), max(c.y for c in frame), -frame[0].z

    def pixel(_region, _view, place):
        # The camera looks along +y: x is right, z up.
        return type(place)((100.0 + 300.0 * (place.x / place.y * depth / right), 80.0 + 200.0 * (place.z / place.y * depth / top), 0.0)).xy  # fmt: skip

    monkeypatch.setattr(picking.view3d_utils, "location_3d_to_region_2d", pixel)
    point = picking.picture_point(scene, scene.camera, None, None, (100.0 + 150.0, 80.0 - 100.0))
    assert point == pytest.approx((0.75, 0.25), abs=1e-6)
    assert picking.picture_point(scene, scene.camera, None, None, (401.0, 80.0)) is None
    said = picking.described(blender.context, scene.camera, picking.Target((0.5, 0.5)))
    assert said == "Square, 5 m away"
    assert picking.described(blender.context, scene.camera, picking.Target((0.1, 0.9))) == "Nothing there: infinity"


# Framing ------------------------------------------------------------------------------------------------------------


def angle_of(scene) -> float:
    from support import scenes

    return scenes.part("queries.lens_info").of_camera(scene.camera, scene)["fov_horizontal_rad"]


@pytest.mark.parametrize("by", ["FOCAL_LENGTH", "FILM"])
def test_the_lens_frames_what_blenders_camera_frames(blender, scene, by):
    camera = scene.camera.data
    own = camera.petzval
    own.match_viewport = False
    camera.lens, camera.shift_x, camera.dof.focus_distance = 63.0, 0.05, 3.0
    assert blender.ops.petzval.frame_like_blender(by=by) == {"FINISHED"}
    half = 18.0 / 63.0
    wanted = math.atan(half * 1.1) + math.atan(half * 0.9)
    # The settings keep single precision.
    assert angle_of(scene) == pytest.approx(wanted, abs=1e-6)
    # Blender's camera is as it was, and stays so.
    assert camera.lens == 63.0 and not own.match_viewport
    if by == "FILM":
        assert own.film_mode == "SIZE" and own.focal_mode == "PUBLISHED"
        assert own.film_width / own.film_height == pytest.approx(1.5)
    else:
        assert own.film_mode == "SENSOR" and own.focal_length == pytest.approx(63.0, rel=0.05)


def test_what_a_zoom_cannot_frame_is_said_and_nothing_changes(blender, scene):
    camera = scene.camera.data
    own = camera.petzval
    own.match_viewport = False
    own.lens_file, camera.lens = "nikkor-z-24-70-f4", 200.0
    before = own.focal_mode, own.film_mode, own.focus_mode
    with pytest.raises(RuntimeError, match="its zoom from 24.72"):
        blender.ops.petzval.frame_like_blender(by="FOCAL_LENGTH")
    assert (own.focal_mode, own.film_mode, own.focus_mode) == before


def test_pinholes_are_left_alone(blender, scene):
    scene.camera.data.petzval.model = "PINHOLE"
    for name in ("pick_focus", "focus_on_cursor", "frame_like_blender", "export_stmap", "export_osl"):
        assert not getattr(blender.ops.petzval, name).poll()


@pytest.mark.once
def test_costs_are_measured_and_drawn(blender, scene):
    from support import scenes

    scene.petzval.samples = 4
    assert blender.ops.petzval.measure_costs(width=24, seconds=2.0) == {"FINISHED"}
    found = scenes.part("operators.cost").last(scene.name)
    names = [row["key"] for row in found["rungs"] if row["is_measured"]]
    assert {"pinhole", "thin", "auto", "hero"} <= set(names)
    assert found["size"] == [24, 16]
    image = blender.data.images["What Accuracy Costs"]
    values = np.empty(image.size[0] * image.size[1] * 4, dtype=np.float32)
    image.pixels.foreach_get(values)
    assert values.min() < 0.3 and np.median(values) == 1.0
