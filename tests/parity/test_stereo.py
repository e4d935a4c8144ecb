# SPDX-License-Identifier: GPL-3.0-or-later
"""Both eyes of stereo pictures, and the views of multiview, against Cycles in the same Blender."""

from __future__ import annotations

from math import radians

import numpy as np
import pytest

# Blender before 5 does not read an EXR of one view as it has written it.
pytestmark = pytest.mark.once

WIDTH, HEIGHT, SAMPLES = 48, 32, 64
EYES = ("left", "right")


@pytest.fixture
def row(blender):
    """Glowing cubes near and far of a camera that is turned and scaled, for two eyes far apart."""
    from support import scenes as parts

    scene = parts.set_up(WIDTH, HEIGHT, SAMPLES)
    dice = np.random.default_rng(5)
    for index in range(20):
        towards = dice.normal(size=3)
        blender.ops.mesh.primitive_cube_add(
            size=0.6,
            # Before the camera, and a few around it.
            location=dice.uniform((-2.0, -1.4, -6.0), (2.0, 1.4, -1.6)) if index < 14 else towards * 2.5,
            rotation=dice.uniform(0.0, 3.0, 3),
        )
        colour = tuple(dice.uniform(0.2, 1.0, 3))
        blender.context.object.data.materials.append(parts.emitter(colour, 1.0, name=f"Glow {index}"))
    camera = scene.camera
    camera.location, camera.rotation_euler, camera.scale = (0.3, 0.1, 0.2), (0.1, 0.2, 0.15), (1.5, 1.5, 1.5)
    camera.data.lens, camera.data.shift_x, camera.data.shift_y = 24.0, 0.04, -0.03
    scene.render.use_multiview = True
    stereo = camera.data.stereo
    stereo.interocular_distance, stereo.convergence_distance = 0.5, 3.0
    return scene


def views(folder, engine: str) -> dict[str, np.ndarray]:
    """Each view's picture, of the file that Blender has written for it."""
    import bpy

    from support import scenes as parts

    scene = bpy.context.scene
    scene.render.engine, scene.render.filepath = engine, str(folder / f"{engine.lower()}.exr")
    try:
        bpy.ops.render.render(write_still=True)
    finally:
        scene.render.engine = "PETZVAL"
    used = [one for one in scene.render.views if one.use]
    return {one.name: parts.read(folder / f"{engine.lower()}{one.file_suffix}.exr")[..., :3] for one in used}


def alike(folder, names=EYES, samples: int = SAMPLES, **limits) -> dict[str, np.ndarray]:
    """Each view is as Cycles has it, which is not how it has the other: edges between glowing colours, pixel by pixel."""
    from support import beside_cycles

    beside_cycles.prepare(samples)
    ours, theirs = views(folder, "PETZVAL"), views(folder, "CYCLES")
    assert set(ours) == set(theirs) == set(names)
    limits = {"mean": 0.003, "block": 0.1} | limits
    for name in names:
        mean, block = beside_cycles.apart(ours[name], theirs[name], 1, 0.5)
        print(f"{name}: mean {mean:.4f}, pixel {block:.4f}")
        assert mean < limits["mean"] and block < limits["block"], name
    first, second = list(names)[:2]
    apart = np.abs(theirs[first] - theirs[second]).mean()
    assert apart > 4.0 * max(np.abs(ours[name] - theirs[name]).mean() for name in names)
    return ours


@pytest.mark.parametrize("pivot", ["LEFT", "RIGHT", "CENTER"])
@pytest.mark.parametrize("mode", ["OFFAXIS", "PARALLEL", "TOE"])
def test_eyes(row, tmp_path, mode, pivot):
    row.camera.data.stereo.convergence_mode, row.camera.data.stereo.pivot = mode, pivot
    alike(tmp_path)


@pytest.mark.parametrize("fit", ["VERTICAL", "AUTO"])
def test_upright_pictures(row, tmp_path, fit):
    """Blender counts the eyes' shift by the sensor's width, whatever side of the picture it fits."""
    row.camera.data.sensor_fit, row.camera.data.stereo.pivot = fit, "CENTER"
    row.render.resolution_x, row.render.resolution_y = HEIGHT, WIDTH
    row.render.pixel_aspect_x = 1.2
    alike(tmp_path)


def test_parallel_rays(row, tmp_path):
    """An orthographic camera has two eyes, too, each with Blender's shift."""
    row.camera.data.type, row.camera.data.ortho_scale, row.camera.data.stereo.pivot = "ORTHO", 4.0, "CENTER"
    alike(tmp_path)


@pytest.mark.parametrize("mode", ["OFFAXIS", "PARALLEL"])
@pytest.mark.parametrize("kind", ["PERSP", "PANO"])
@pytest.mark.parametrize("merges", [False, True])
def test_spherical_stereo(row, tmp_path, kind, mode, merges):
    """Each ray has its own pair of eyes, which may draw together above and below."""
    camera = row.camera.data
    camera.type, camera.stereo.use_spherical_stereo, camera.stereo.convergence_mode = kind, True, mode
    camera.panorama_type = "EQUIRECTANGULAR"
    row.camera.rotation_euler = (1.2, 0.2, 0.15)
    stereo = camera.stereo
    stereo.use_pole_merge, stereo.pole_merge_angle_from, stereo.pole_merge_angle_to = merges, radians(15), radians(50)
    row.render.resolution_x, row.render.resolution_y = 64, 32
    alike(tmp_path, samples=256)


def test_depth_of_field_of_spherical_stereo(row, tmp_path, monkeypatch):
    from support import beside_cycles

    camera = row.camera.data
    camera.type, camera.stereo.use_spherical_stereo, camera.panorama_type = "PANO", True, "FISHEYE_EQUIDISTANT"
    camera.petzval.model, row.camera.rotation_euler = "THIN", (1.2, 0.2, 0.15)

    def focus(*_arguments):
        camera.dof.use_dof, camera.dof.focus_distance, camera.dof.aperture_fstop = True, 2.0, 0.05

    # The comparison is without depth of field else.
    plain = beside_cycles.without_tricks
    monkeypatch.setattr(beside_cycles, "without_tricks", lambda samples: (plain(samples), focus()))
    alike(tmp_path, samples=256)


def test_eyes_that_move(row, tmp_path):
    """Each eye moves with the camera while the shutter is open."""
    camera = row.camera
    for frame, x in ((0, 0.1), (2, 0.5)):
        camera.location[0] = x
        camera.keyframe_insert("location", frame=frame)
    row.frame_set(1)
    row.render.use_motion_blur, row.render.motion_blur_shutter = True, 1.0
    alike(tmp_path, samples=256)


def test_cameras_of_multiview(row, blender, tmp_path):
    """Each view has the camera whose name ends with its suffix; one without such a camera has the scene's."""
    row.render.views_format = "MULTIVIEW"
    row.camera.name = "Eye_L"
    other = row.camera.copy()
    other.data, other.name = row.camera.data.copy(), "Eye_R"
    other.data.lens, other.location[0] = 35.0, 0.9
    row.collection.objects.link(other)
    third = row.render.views.new("third")
    third.file_suffix, third.camera_suffix = "_third", "_none"
    ours = alike(tmp_path, ("left", "right", "third"))
    assert np.abs(ours["left"] - ours["third"]).mean() < 0.1 * np.abs(ours["left"] - ours["right"]).mean()
    # Both eyes have noise of their own.
    assert not np.array_equal(ours["left"], ours["third"])


def _middle(picture: np.ndarray) -> float:
    """Where the light of a picture is, across: pixels from its middle."""
    light = picture.sum(axis=(0, 2))
    return float((light * (np.arange(len(light)) + 0.5)).sum() / light.sum() - 0.5 * len(light))


@pytest.fixture
def ball(blender):
    """A small ball that glows in the dark, before a real lens and two eyes."""
    from support import scenes as parts

    scene = parts.set_up(96, 64, 128, "LENS")
    parts.straight(scene)
    scene.world = parts.grey_world(0.0)
    blender.ops.mesh.primitive_uv_sphere_add(radius=0.03, location=(0.0, 2.0, 0.0))
    blender.context.object.data.materials.append(parts.emitter())
    camera = scene.camera.data
    own = camera.petzval
    own.lens_file, own.wide_open, own.f_number = "double-gauss-f2-tronnier.lens", False, 11.0
    camera.dof.focus_distance = 2.0
    camera.stereo.interocular_distance, camera.stereo.convergence_distance, camera.stereo.pivot = 0.2, 2.0, "CENTER"
    scene.render.use_multiview = True
    return scene


@pytest.mark.parametrize("focal_mode", ["BLENDER", "LENGTH"])
def test_eyes_of_a_real_lens(ball, blender, tmp_path, focal_mode):
    """Each is a whole lens moved aside. What lies in the convergence plane is in one place of both pictures, as the film is shifted; a
    nearer ball is as far apart as the lens's own perspective has it, which is nearly that of Cycles' camera."""
    from support import scenes as parts

    camera = ball.camera.data
    camera.petzval.focal_mode, camera.petzval.focal_length, camera.lens = focal_mode, 45.0, 45.0
    info = parts.part("queries.lens_info").of_camera(ball.camera, ball)
    pixels = info["viewport_focal_length_mm"] / info["picture_width_mm"] * ball.render.resolution_x
    for distance in (2.0, 1.4):
        blender.context.object.location[1] = distance
        blender.context.view_layer.update()
        ours = views(tmp_path, "PETZVAL")
        for name, aside in (("left", 0.1), ("right", -0.1)):
            expected = aside * pixels * (1.0 / distance - 1.0 / 2.0)
            print(name, distance, _middle(ours[name]), expected)
            assert _middle(ours[name]) == pytest.approx(expected, abs=0.06)
    theirs = views(tmp_path, "CYCLES")
    for name in EYES:
        assert _middle(ours[name]) == pytest.approx(_middle(theirs[name]), rel=0.1)
    camera.stereo.convergence_mode = "PARALLEL"
    parallel = views(tmp_path, "PETZVAL")
    assert _middle(parallel["left"]) - _middle(parallel["right"]) > 10.0


def test_what_a_lens_cannot_do_is_said(ball, tmp_path):
    """Panoramas have their eyes, whatever lens the camera names."""
    from support import scenes as parts

    camera, last = ball.camera.data, parts.part("render.statistics").last
    camera.stereo.use_spherical_stereo = True
    views(tmp_path, "PETZVAL")
    (warning,) = last(ball.name).warnings
    assert "spherical stereo" in warning
    camera.type = "PANO"
    seen = views(tmp_path, "PETZVAL")
    (warning,) = last(ball.name).warnings
    assert "panoramic" in warning and not np.array_equal(seen["left"], seen["right"])


def test_the_3d_view_knows_eyes_as_blender_does(row, blender):
    """The shift of an eye and the camera of a view, which a final render asks Blender for."""
    from types import SimpleNamespace

    from mathutils import Matrix

    from support import scenes as parts

    stereo, camera, found = parts.part("export.stereo"), row.camera.data, []

    class Probe(blender.types.RenderEngine):
        bl_idname, bl_label = "PROBE", "Probe"

        def render(self, depsgraph):
            for name in EYES:
                self.active_view_set(name)
                holder = self.camera_override
                found.append((holder.name, self.camera_model_matrix(holder), self.camera_shift_x(holder)))

    blender.utils.register_class(Probe)
    try:
        row.render.engine = "PROBE"
        for mode, pivot, which in (("OFFAXIS", "LEFT", 0), ("OFFAXIS", "CENTER", 1), ("TOE", "RIGHT", 0)):
            camera.stereo.convergence_mode, camera.stereo.pivot = mode, pivot
            found.clear()
            blender.ops.render.render()
            matrix = found[which][1]
            space = SimpleNamespace(stereo_3d_camera=EYES[which].upper(), stereo_3d_eye="")
            eye = stereo.eye_of_3d_view(row.camera, row, space, matrix.inverted())
            assert eye.shift_x == pytest.approx(found[which][2], abs=1e-6)
            np.testing.assert_allclose(eye.matrix, matrix, atol=1e-5)
            # A window in stereo draws both in turn, any other shows the camera as it is.
            space = SimpleNamespace(stereo_3d_camera="S3D", stereo_3d_eye=f"{EYES[which].upper()}_EYE")
            moved = stereo.eye_of_3d_view(row.camera, row, space, matrix.inverted())
            assert moved is None or moved.shift_x == eye.shift_x
            assert (
                stereo.eye_of_3d_view(row.camera, row, space, row.camera.matrix_world.normalized().inverted()) is None
            )
        row.render.views_format, row.camera.name = "MULTIVIEW", "Eye_R"
        other = row.camera.copy()
        other.name = "Eye_L"
        row.collection.objects.link(other)
        found.clear()
        blender.ops.render.render()
        space = SimpleNamespace(stereo_3d_camera="LEFT", stereo_3d_eye="")
        assert found[0][0] == stereo.eye_of_3d_view(row.camera, row, space, Matrix()).holder.name == "Eye_L"
    finally:
        row.render.engine = "PETZVAL"
        blender.utils.unregister_class(Probe)
