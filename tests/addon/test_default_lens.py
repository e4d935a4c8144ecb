# SPDX-License-Identifier: GPL-3.0-or-later
"""A camera for which no lens was chosen: it frames what Blender's camera frames, and Blender's camera comes back with another engine."""

from __future__ import annotations

import math

import pytest

from support import scenes


@pytest.fixture
def scene(blender):
    """Blender's own default scene, as a new user has it, with Petzval chosen."""
    blender.ops.wm.read_factory_settings(use_empty=False)
    scene = blender.context.scene
    scene.render.engine = "PETZVAL"
    blender.context.view_layer.update()
    return scene


def info_of(scene):
    return scenes.part("queries.lens_info").of_camera(scene.camera, scene)


def blenders_angle(scene) -> float:
    """Of the picture's width."""
    camera = scene.camera.data
    return 2.0 * math.atan(0.5 * camera.sensor_width / camera.lens)


def test_the_first_picture_is_framed_as_blenders_camera_has_it(scene):
    camera = scene.camera.data
    before = (camera.lens, camera.sensor_width, camera.shift_x, camera.shift_y)
    found = info_of(scene)
    assert "Nikkor Z 50 mm" in found["lens_name"]
    assert 45.0 < found["efl_mm"] < 55.0
    # The settings keep single precision.
    assert found["fov_horizontal_rad"] == pytest.approx(blenders_angle(scene), abs=1e-5)
    assert (camera.lens, camera.sensor_width, camera.shift_x, camera.shift_y) == before


@pytest.mark.parametrize(
    "focal_mm, lens", [(14.0, "Hologon"), (24.0, "Biogon"), (35.0, "Nikkor 28"), (85.0, "Z 50"), (135.0, "105 mm")]
)
def test_wide_and_long_cameras_get_lenses_that_see_as_much(scene, focal_mm, lens):
    scene.camera.data.lens = focal_mm
    found = info_of(scene)
    assert lens in found["lens_name"]
    assert found["fov_horizontal_rad"] == pytest.approx(blenders_angle(scene), abs=1e-5)
    if focal_mm > 14.0:
        assert scenes.part("queries.lens_info").coverage(scene.camera, scene) == ""


def test_blenders_shift_shifts_the_lens(scene, blender):
    camera = scene.camera.data
    camera.shift_x, camera.shift_y = 0.05, -0.04
    found = info_of(scene)
    assert found["viewport_shift"] == pytest.approx([0.05, -0.04], abs=1e-6)
    edge = [math.atan((side + 0.05) * camera.sensor_width / camera.lens) for side in (-0.5, 0.5)]
    assert found["fov_horizontal_rad"] == pytest.approx(edge[1] - edge[0], abs=1e-5)


def test_a_lens_that_is_chosen_is_as_published_and_the_view_follows(scene, blender):
    camera = scene.camera.data
    own, before = camera.petzval, (camera.lens, camera.sensor_width, camera.sensor_fit)
    own.lens_file = "nikkor-105-f1.4"
    assert own.focal_mode == "PUBLISHED"
    assert 100.0 < camera.lens < 110.0
    # Another engine has Blender's own camera again, and Petzval that of its lens.
    scene.render.engine = "CYCLES"
    scenes.part("queries.viewport_camera").engine_changed(scene)
    assert (camera.lens, camera.sensor_width, camera.sensor_fit) == before
    scene.render.engine = "PETZVAL"
    scenes.part("queries.viewport_camera").engine_changed(scene)
    assert 100.0 < camera.lens < 110.0
    # And so has a camera that frames as Blender's again.
    own.focal_mode = "BLENDER"
    assert (camera.lens, camera.sensor_width, camera.sensor_fit) == before


def test_the_engine_is_listened_to(scene, blender):
    camera = scene.camera.data
    camera.petzval.lens_file = "nikkor-105-f1.4"
    scene.render.engine = "CYCLES"
    scene.frame_set(scene.frame_current + 1)
    blender.context.view_layer.update()
    assert camera.lens == pytest.approx(50.0)


def test_files_of_the_version_before_keep_their_lens(scene, blender, tmp_path):
    own = scene.camera.data.petzval
    own.in_step = True
    assert not own.is_property_set("focal_mode") and not own.is_property_set("lens_file")
    file = tmp_path / "old.blend"
    blender.ops.wm.save_as_mainfile(filepath=str(file))
    blender.ops.wm.open_mainfile(filepath=str(file))
    own = blender.context.scene.camera.data.petzval
    assert (own.focal_mode, own.lens_file) == ("PUBLISHED", "wide-angle-smith-f3.4.lens")


def test_a_film_that_the_lens_does_not_cover_is_said(scene):
    own = scene.camera.data.petzval
    own.lens_file = "phone-4.1-f1.8"
    complaint = scenes.part("queries.lens_info").coverage(scene.camera, scene)
    assert "stays black" in complaint and "Of the Lens" in complaint
    own.film_mode = "LENS"
    assert scenes.part("queries.lens_info").coverage(scene.camera, scene) == ""
    found = info_of(scene)
    # 4.8 x 3.6 mm in a picture of 16:9.
    assert (found["picture_width_mm"], found["picture_height_mm"]) == pytest.approx((4.8, 2.7))


def test_messages_of_a_kind_are_one():
    grouped = scenes.part("render.messages").grouped
    many = [f"Object 'O{i}': its fur is not supported yet" for i in range(7)]
    found = grouped([*many, "mesh 'A': bad", "mesh 'B': worse", "all is lost"])
    assert found == [
        "Object 'O0', 'O1', 'O2' and 4 more: its fur is not supported yet",
        "mesh 'A': bad",
        "mesh 'B': worse",
        "all is lost",
    ]
    assert scenes.part("render.messages").of_text(found[0])[1:] == ("object", "O0")


def test_captions_keep_the_f_number():
    caption = scenes.part("ui.lens_gallery").caption
    assert caption("Nikkor Z 50 mm F/1.8 S, WO 2019/220618 ex. 9") == "Nikkor Z 50 F/1.8"
    assert caption("Double Gauss 100 mm F/1.35, US 2,601,805 (Lowenthal)").endswith(" F/1.35")
    assert all(len(caption(name)) <= 17 for name in ("Ball lens, diameter 10 mm, n = 1.5168", "A" * 40 + " F/2"))
    assert caption("Short F/2") == "Short F/2"
