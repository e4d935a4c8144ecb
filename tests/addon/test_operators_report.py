# SPDX-License-Identifier: GPL-3.0-or-later
"""Lens reports in Blender: a picture for each kind, of the lens as the camera has it."""

from __future__ import annotations

import math

import numpy as np
import pytest

KINDS = ("DRAWING", "SPOTS", "FANS", "MTF", "PSF", "DISTORTION", "ILLUMINATION", "TRANSMISSION")


@pytest.fixture
def scene(blender):
    from support import scenes

    made = scenes.set_up(width=96, height=64, model="LENS")
    own = made.camera.data.petzval
    own.lens_file, own.wide_open, own.f_number = "cooke-triplet-50mm", False, 8.0
    made.camera.data.dof.focus_distance = 4.0
    return made


def pixels_of(image) -> np.ndarray:
    width, height = image.size
    values = np.empty(width * height * 4, dtype=np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(height, width, 4)


def asked(monkeypatch, name: str) -> list:
    """What the engine is asked for by that function."""
    from petzval import _native

    calls = []
    real = getattr(_native, name)

    def told(*arguments, **named):
        calls.append((arguments, named))
        return real(*arguments, **named)

    monkeypatch.setattr(_native, name, told)
    return calls


@pytest.mark.first_only("kind")
@pytest.mark.parametrize("kind", KINDS)
def test_each_report_is_a_picture(blender, scene, kind):
    bpy = blender
    kept = [set(group.keys()) for group in (bpy.data.curves, bpy.data.objects, bpy.data.fonts)]
    assert bpy.ops.petzval.lens_report(kind=kind) == {"FINISHED"}
    # Letters are drawn through a text object of which nothing stays.
    assert [set(group.keys()) for group in (bpy.data.curves, bpy.data.objects, bpy.data.fonts)] == kept
    (image,) = [one for one in bpy.data.images if one.name.startswith("Lens Report")]
    pixels = pixels_of(image)
    assert pixels.shape[1] >= 900 and np.isfinite(pixels).all()
    # White paper with dark letters and coloured lines.
    assert np.median(pixels[:, :, :3]) == 1.0
    head = pixels[-60:, : pixels.shape[1] // 2, :3]
    assert head.min() < 0.2
    saturation = pixels[:, :, :3].max(axis=2) - pixels[:, :, :3].min(axis=2)
    assert (saturation > 0.3).sum() > 300
    # Asked again, it is the same image.
    assert bpy.ops.petzval.lens_report(kind=kind) == {"FINISHED"}
    assert len([one for one in bpy.data.images if one.name.startswith("Lens Report")]) == 1


def test_the_report_is_of_the_camera_as_it_is_set(blender, scene, monkeypatch):
    from support import scenes

    own = scene.camera.data.petzval
    own.focal_mode, own.focal_length = "LENGTH", 75.0
    own.blades, own.spectrum, own.wavelength = 5, "SINGLE", 632.8
    calls = asked(monkeypatch, "lens_report_json")
    assert blender.ops.petzval.lens_report(kind="SPOTS") == {"FINISHED"}
    (((name, _, setting, look, _), _),) = calls
    assert name == "spots"
    assert (setting.focal_length, setting.f_number, setting.blades) == ({"MILLIMETRES": 75.0}, 8.0, 5)
    assert look.wavelengths_nm == pytest.approx((632.8,), rel=1e-6)
    info = scenes.part("queries.lens_info").of_camera(scene.camera, scene)
    # To the corner of the film, focused where the camera is.
    assert look.fields_deg[-1] == pytest.approx(math.degrees(info["fov_diagonal_rad"]) / 2.0)
    assert look.focus_distance_mm == pytest.approx(4000.0)


def test_another_camera_model_has_no_report_and_a_bad_lens_is_said(blender, scene):
    own = scene.camera.data.petzval
    own.model = "PINHOLE"
    assert not blender.ops.petzval.lens_report.poll()
    own.model, own.lens_file = "LENS", "no-such-lens"
    with pytest.raises(RuntimeError, match="no such lens"):
        blender.ops.petzval.lens_report(kind="FANS")


def test_letters_are_as_wide_as_they_look(blender):
    from support import scenes

    with scenes.part("drawing.lettering").Letters() as letters:
        shapes, width = letters.outline("H")
        assert max(shape[:, 1].max() for shape in shapes) == pytest.approx(1.0, abs=1e-6)
        assert letters.outline("HH")[1] == pytest.approx(2.0 * width, rel=0.1)
        assert letters.outline(" ")[1] > 0.1 and letters.outline(" ")[0] == []
        # Greek, primes and signs that reports have are there.
        assert all(letters.outline(sign)[0] for sign in "θµ′⁴−°")
