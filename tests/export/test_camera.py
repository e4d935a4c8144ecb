# SPDX-License-Identifier: GPL-3.0-or-later
"""What is sent of cameras, and where the picture of a point lies, against Blender's own projection."""

from __future__ import annotations

from math import radians

import numpy as np
import pytest


@pytest.fixture
def parts(blender):
    from support import scenes

    scenes.set_up(width=120, height=80)
    return scenes


FRAMES = {
    "auto wide": {"size": (120, 80)},
    "auto tall": {"size": (80, 120)},
    "horizontal, tall": {"size": (80, 120), "sensor_fit": "HORIZONTAL"},
    "vertical, wide": {"size": (120, 80), "sensor_fit": "VERTICAL", "sensor_height": 20.0},
    "vertical, tall": {"size": (80, 120), "sensor_fit": "VERTICAL", "sensor_height": 30.0},
    "shifted": {"size": (120, 80), "shift_x": 0.15, "shift_y": -0.1},
    "shifted, tall": {"size": (80, 120), "shift_x": 0.1, "shift_y": 0.2},
    "shifted, vertical": {"size": (120, 80), "sensor_fit": "VERTICAL", "shift_x": 0.1, "shift_y": 0.05},
    "shifted, horizontal, tall": {"size": (80, 120), "sensor_fit": "HORIZONTAL", "shift_x": 0.1, "shift_y": 0.1},
    "tele": {"size": (120, 80), "lens": 135.0},
    "orthographic": {"size": (120, 80), "type": "ORTHO", "ortho_scale": 5.0, "shift_x": 0.1, "shift_y": 0.05},
    "orthographic, tall": {"size": (80, 120), "type": "ORTHO", "ortho_scale": 5.0, "shift_x": -0.05},
    "orthographic, vertical": {"size": (120, 80), "type": "ORTHO", "ortho_scale": 3.0, "sensor_fit": "VERTICAL"},
    "scaled camera": {"size": (120, 80), "scale": 2.5},
}


@pytest.mark.parametrize("frame", FRAMES)
def test_points_lie_where_blender_projects_them(parts, blender, tmp_path, frame):
    from bpy_extras.object_utils import world_to_camera_view
    from mathutils import Vector

    scene, settings = blender.context.scene, dict(FRAMES[frame])
    holder = scene.camera
    scene.render.resolution_x, scene.render.resolution_y = settings.pop("size")
    holder.scale = (settings.pop("scale", 1.0),) * 3
    holder.location, holder.rotation_euler = (0.3, -0.4, 0.2), (radians(80), radians(7), radians(-12))
    for name, value in settings.items():
        setattr(holder.data, name, value)
    scene.world = parts.grey_world(0.0)
    scene.petzval.samples = 64
    blender.context.view_layer.update()
    glow = parts.emitter((1.0, 1.0, 1.0), 50.0)
    places = [(0.2, 0.3), (0.8, 0.25), (0.7, 0.8)]
    # Where a ray through the picture's place goes, by Blender's own frame.
    frame_corners = holder.data.view_frame(scene=scene)
    right, left, top, bottom = frame_corners[0], frame_corners[2], frame_corners[0], frame_corners[2]
    points = []
    for u, v in places:
        local = Vector((left.x + u * (right.x - left.x), bottom.y + v * (top.y - bottom.y), left.z))
        local = Vector((local.x, local.y, -6.0)) if holder.data.type == "ORTHO" else local * 6.0
        pose = holder.matrix_world.normalized()
        points.append(pose @ local)
    picture_size = (scene.render.resolution_x, scene.render.resolution_y)
    for index, point in enumerate(points):
        blender.ops.mesh.primitive_ico_sphere_add(radius=0.05, location=point)
        dot = blender.context.object
        dot.name = f"Dot {index}"
        dot.data.materials.append(glow)
    for index, point in enumerate(points):
        for other in range(3):
            blender.data.objects[f"Dot {other}"].hide_render = other != index
        picture = parts.render(tmp_path, f"{index}.exr")[..., 0]
        assert picture.shape == picture_size[::-1]
        assert picture.sum() > 0
        rows, columns = np.mgrid[: picture.shape[0], : picture.shape[1]] + 0.5
        found = ((picture * columns).sum() / picture.sum(), (picture * rows).sum() / picture.sum())
        wanted = world_to_camera_view(scene, holder, point)
        wanted = (wanted.x * picture_size[0], wanted.y * picture_size[1])
        assert found == pytest.approx(wanted, abs=0.25), frame


def test_the_lens_photographs_what_the_camera_view_frames(parts, blender, tmp_path):
    """After the lens was set up, Blender's camera is in step: a pinhole there sees the same picture."""
    scene = blender.context.scene
    own = scene.camera.data.petzval
    own.model = "LENS"
    scene.camera.data.dof.focus_distance = 3.0
    own.lens_file = "double-gauss-f2-tronnier.lens"
    own.focal_mode, own.focal_length = "LENGTH", 50.0
    own.wide_open, own.f_number = False, 16.0
    own.shift_x, own.shift_y = 3.0, -2.0
    own.spectrum = "SINGLE"
    scene.world = parts.grey_world(0.0)
    scene.petzval.samples = 64
    blender.context.view_layer.update()
    assert scene.camera.data.lens == pytest.approx(50.0, rel=0.05)
    assert scene.camera.data.shift_x == pytest.approx(3.0 / 36.0, rel=1e-3)
    assert scene.camera.data.shift_y == pytest.approx(-2.0 / 36.0, rel=1e-3)
    for x, z in ((0.5, 0.1), (-0.3, -0.4)):
        parts.square("Dot", (x, 3.0, z), 0.05, parts.emitter(strength=50.0))
    pictures = []
    for model in ("LENS", "PINHOLE"):
        own.model = model
        picture = parts.render(tmp_path, f"{model}.exr")[..., 0]
        rows, columns = np.mgrid[:80, :120]
        half = columns < 40
        pictures.append(
            [
                (picture[side] * axis[side]).sum() / picture[side].sum()
                for side in (half, ~half)
                for axis in (rows, columns)
            ]
        )
    assert pictures[0] == pytest.approx(pictures[1], abs=0.5)


def description(parts):
    return parts.sent()[2]


def test_the_focus(parts, blender):
    camera = blender.context.scene.camera.data
    own = camera.petzval
    own.model = "LENS"
    camera.dof.focus_distance = 7.0
    assert description(parts).focus.distance == 7.0
    target = blender.data.objects.new("Target", None)
    target.location = (0, 4, 1)
    parent = blender.data.objects.new("Parent", None)
    parent.location = (1, 0, 0)
    target.parent = parent
    for one in (target, parent):
        blender.context.scene.collection.objects.link(one)
    camera.dof.focus_object = target
    assert description(parts).focus.point_world == pytest.approx((1, 4, 1))
    camera.dof.focus_object = None
    camera.dof.focus_distance = 0.0
    _, warnings, sent = parts.sent()
    assert sent.focus.distance is None
    assert len(warnings) == 1 and "focus distance is zero" in warnings[0]
    camera.dof.focus_distance = 7.0
    own.focus_mode = "INFINITY"
    sent = description(parts)
    assert sent.focus.distance is None and sent.focus.point_world is None and sent.focus.film_distance_mm is None
    own.focus_mode, own.film_distance = "FILM", 61.5
    assert description(parts).focus.film_distance_mm == pytest.approx(61.5)


def test_the_lens_settings(parts, blender):
    camera = blender.context.scene.camera.data
    own = camera.petzval
    own.model = "LENS"
    # The normal lens, by a little larger than it is: it frames what Blender's camera of 50 mm does.
    assert description(parts).lens.focal_length["MILLIMETRES"] == pytest.approx(50.0, abs=0.5)
    own.focal_mode = "PUBLISHED"
    sent = description(parts)
    assert sent.lens.f_number is None and sent.lens.focal_length == "AS_PUBLISHED"
    assert sent.wavelength_nm is None and sent.lens.blades == 0
    assert (sent.film.width_mm, sent.film.height_mm) == pytest.approx((36.0, 24.0))
    own.wide_open, own.f_number, own.blades, own.blade_rotation = False, 4.0, 7, 0.3
    own.blade_curvature = 0.4
    own.focal_mode, own.focal_length, own.focal_scale = "LENGTH", 35.0, 0.5
    own.film_mode, own.film_width, own.film_height = "SIZE", 60.0, 45.0
    own.tilt, own.swing, own.shift_x, own.shift_y = 0.1, -0.2, 3.0, -4.0
    own.spectrum, own.wavelength = "SINGLE", 486.0
    sent = description(parts)
    assert (sent.lens.f_number, sent.lens.blades, sent.lens.blade_rotation_rad) == pytest.approx((4.0, 7, 0.3))
    assert sent.lens.blade_curvature == pytest.approx(0.4)
    assert sent.lens.focal_length == {"MILLIMETRES": pytest.approx(35.0)}
    assert (sent.film.width_mm, sent.film.height_mm) == pytest.approx((60.0, 45.0))
    assert (sent.film.tilt_rad, sent.film.swing_rad) == pytest.approx((0.1, -0.2))
    assert sent.film.shift_mm == pytest.approx((3.0, -4.0))
    assert sent.wavelength_nm == pytest.approx(486.0)
    own.focal_mode = "SCALE"
    sent = description(parts)
    assert sent.lens.focal_length == {"SCALE": pytest.approx(0.5)}
    own.blades = 2
    assert description(parts).lens.blades == 0


def test_the_scale(parts, blender):
    scene = blender.context.scene
    own = scene.camera.data.petzval
    assert description(parts).scale_mm_per_unit == pytest.approx((1000.0,) * 3)
    scene.unit_settings.scale_length = 0.01
    assert description(parts).scale_mm_per_unit == pytest.approx((10.0,) * 3)
    own.scale_from_scene = False
    own.scale = (2.0, 3.0, 4.0)
    assert description(parts).scale_mm_per_unit == pytest.approx((2.0,) * 3)
    own.scale_locked = False
    assert description(parts).scale_mm_per_unit == pytest.approx((2.0, 3.0, 4.0))


def test_another_projection_is_said(parts, blender):
    blender.context.scene.camera.data.type = "CUSTOM"
    _, warnings, _ = parts.sent()
    assert len(warnings) == 1 and "custom cameras are not supported" in warnings[0] and "Camera 'Camera'" in warnings[0]


def test_a_panoramic_camera_has_no_lens(parts, blender):
    camera = blender.context.scene.camera.data
    camera.type, camera.petzval.model = "PANO", "LENS"
    camera.panorama_type, camera.shift_x = "EQUIANGULAR_CUBEMAP_FACE", 0.25
    _, warnings, sent = parts.sent()
    assert len(warnings) == 1 and "panoramic, so no lens" in warnings[0] and "Camera 'Camera'" in warnings[0]
    assert sent.model == "PANORAMIC" and sent.panorama.shift == (0.25, 0.0) and sent.lens.f_number is None
    camera.petzval.model = "PINHOLE"
    camera.dof.use_dof = True
    _, warnings, sent = parts.sent()
    assert not warnings and sent.lens.f_number is None
    camera.petzval.model, camera.dof.aperture_fstop = "THIN", 4.0
    _, warnings, sent = parts.sent()
    assert not warnings and sent.lens.f_number == 4.0


def test_an_orthographic_camera_has_no_lens(parts, blender):
    camera = blender.context.scene.camera.data
    camera.type, camera.ortho_scale, camera.petzval.model = "ORTHO", 3.0, "LENS"
    _, warnings, sent = parts.sent()
    assert len(warnings) == 1 and "orthographic" in warnings[0] and "Camera 'Camera'" in warnings[0]
    # The larger side of 120 x 80 pixels is the width.
    assert (sent.model, sent.orthographic_width) == ("ORTHOGRAPHIC", pytest.approx(3.0))
    camera.petzval.model = "PINHOLE"
    blender.context.scene.render.resolution_y = 240
    _, warnings, sent = parts.sent()
    assert not warnings and sent.orthographic_width == pytest.approx(1.5)


def test_clipping_is_sent(parts, blender):
    camera = blender.context.scene.camera.data
    camera.clip_start, camera.clip_end = 0.5, 40.0
    assert description(parts).clip == pytest.approx((0.5, 40.0))
    camera.clip_end = 0.2
    _, (warning,), sent = parts.sent()
    assert "Clip End" in warning and sent.clip == (0.0, np.inf)


def test_a_shift_that_moves_no_lens_is_said(parts, blender):
    fresh = blender.data.cameras.new("Fresh")
    fresh.shift_x = 0.2
    blender.context.scene.camera.data = fresh
    assert fresh.petzval.model == "LENS"
    # A lens that frames as Blender's camera does is shifted with it.
    assert not parts.sent()[1] and parts.sent()[2].film.shift_mm[0] == pytest.approx(0.2 * 36.0, rel=1e-2)
    fresh.petzval.match_viewport, fresh.petzval.focal_mode = False, "PUBLISHED"
    _, warnings, _ = parts.sent()
    assert len(warnings) == 1 and "shift" in warnings[0] and "Camera 'Camera'" in warnings[0]
    fresh.petzval.match_viewport, fresh.petzval.shift_x = True, 5.0
    assert fresh.shift_x == pytest.approx(5.0 / 36.0, rel=1e-3)
    assert not parts.sent()[1]
    fresh.petzval.model = "PINHOLE"
    assert not parts.sent()[1]


def test_a_film_format_is_chosen(parts, blender):
    camera = blender.context.scene.camera.data
    own = camera.petzval
    own.model = "LENS"
    assert own.film_mode == "SENSOR"
    assert blender.ops.petzval.choose_film(film="6x7cm") == {"FINISHED"}
    assert own.film_mode == "SIZE"
    sent = description(parts)
    assert (sent.film.width_mm, sent.film.height_mm) == pytest.approx((69.5, 56.0))


def test_the_mask_of_the_aperture(parts, blender):
    import numpy as np

    camera = blender.context.scene.camera.data
    mask_of = parts_of_addon().export.aperture_mask
    camera.petzval.model = "LENS"
    assert mask_of.read(camera) is None
    image = blender.data.images.new("Heart", 3, 3)
    image.colorspace_settings.name = "Non-Color"
    grey = np.array([[0.0, 0.2, 0.4], [0.6, 0.8, 1.0], [0.0, 0.0, 1.0]], np.float32)
    pixels = np.ones((3, 3, 4), np.float32)
    pixels[..., :3] = grey[..., None]
    image.pixels.foreach_set(pixels.ravel())
    camera.petzval.aperture_mask = image
    mask = mask_of.read(camera)
    assert (mask.name, mask.side) == ("Heart", 3)
    assert list(mask.values) == [0, 51, 102, 153, 204, 255, 0, 0, 255]
    camera.petzval.aperture_mask = blender.data.images.new("Wide", 4, 3)
    with pytest.raises(Exception, match="'Wide' is 4 x 3 pixels: make it square"):
        mask_of.read(camera)
    camera.petzval.model = "PINHOLE"
    assert mask_of.read(camera) is None


def parts_of_addon():
    import petzval

    return petzval.load_addon()
