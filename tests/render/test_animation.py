# SPDX-License-Identifier: GPL-3.0-or-later
"""What changes from frame to frame, or while the shutter is open."""

from __future__ import annotations

import numpy as np
import pytest


@pytest.mark.first_only("animated")
@pytest.mark.parametrize("animated", ["f_number", "focal_length", "focus_distance", "tilt"])
def test_an_animation_of_the_lens(parts, blender, tmp_path, animated):
    scene = parts.set_up(width=36, height=24, samples=16, model="LENS")
    scene.frame_start, scene.frame_end = 1, 2
    camera = scene.camera.data
    own = camera.petzval
    own.lens_file = "double-gauss-f2-tronnier.lens"
    own.focal_mode = "LENGTH"
    own.wide_open = False
    own.f_number = 2.0
    camera.dof.focus_distance = 1.0
    for x in (-0.2, 0.0, 0.2):
        parts.square(f"At {x}", (x, 2.0, x / 2), 0.1, parts.emitter((4.0, 4.0, 4.0)))
    holder, path, values = {
        "f_number": (own, "f_number", (2.0, 16.0)),
        "focal_length": (own, "focal_length", (50.0, 85.0)),
        "focus_distance": (camera.dof, "focus_distance", (1.0, 2.0)),
        "tilt": (own, "tilt", (0.0, 0.3)),
    }[animated]
    for frame, value in zip((1, 2), values, strict=True):
        setattr(holder, path, value)
        assert holder.keyframe_insert(path, frame=frame)
    scene.render.filepath = str(tmp_path / "frame-####")
    blender.ops.render.render(animation=True)
    first, second = (parts.read(tmp_path / f"frame-{frame:04}.exr") for frame in (1, 2))
    assert np.abs(first - second).mean() > 0.01
    # The second frame alone is the same picture.
    scene.frame_set(2)
    assert np.array_equal(second, parts.render(tmp_path, "alone.exr"))


def test_persistent_data_draws_trees_anew_around_what_moves(parts, blender, tmp_path):
    scene = parts.set_up(width=36, height=24, samples=16)
    scene.frame_start, scene.frame_end = 1, 3
    still = parts.square("Still", (0.1, 3.0, 0.0), 1.0, parts.emitter((1.0, 2.0, 4.0)))
    bent = parts.square("Bent", (-0.2, 2.5, 0.1), 0.4, parts.emitter((4.0, 2.0, 1.0)))
    bent.shape_key_add(name="Basis")
    key = bent.shape_key_add(name="Wide")
    for point in key.data:
        point.co = 1.5 * point.co
    for frame, amount in ((1, 0.0), (3, 1.0)):
        key.value = amount
        assert key.keyframe_insert("value", frame=frame)
        still.location.x = 0.1 + 0.1 * amount
        assert still.keyframe_insert("location", frame=frame)
    last = parts.part("render.statistics").last
    pictures = {}
    for kept in (False, True):
        scene.render.use_persistent_data = kept
        for frame in (1, 2, 3):
            scene.frame_set(frame)
            pictures[kept, frame] = parts.render(tmp_path, f"{kept}-{frame}.exr")
            assert last("Scene").stats["trees_refitted"] == int(kept and frame > 1)
    for frame in (1, 2, 3):
        assert np.array_equal(pictures[True, frame], pictures[False, frame])
    assert not np.array_equal(pictures[True, 1], pictures[True, 2])
    # Another triangle: the tree is built.
    parts.square("New", (0.0, 2.0, 0.0), 0.1, parts.emitter((1.0, 1.0, 1.0)))
    parts.render(tmp_path, "more.exr")
    assert last("Scene").stats["trees_refitted"] == 0
    scene.render.use_persistent_data = False
    parts.render(tmp_path, "off.exr")
    assert parts.part("render.persistent")._last is None


@pytest.mark.parametrize("use_motion_blur", [False, True])
def test_an_animation_of_an_image_sequence(parts, blender, tmp_path, use_motion_blur):
    """Each frame shows the image of its own middle; the same as rendered alone."""
    from support import image_files as files

    scene = parts.set_up(width=36, height=24, samples=4)
    scene.frame_start, scene.frame_end = 2, 4
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = use_motion_blur, 1.0
    colours = {frame: (0.2 * frame, 0.5, 1.0 - 0.2 * frame) for frame in (1, 2, 3)}
    material, tree, surface = parts.material("Filmed")
    texture, glow = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeEmission")
    texture.image = files.sequence(tmp_path, {frame: files.plain(colour) for frame, colour in colours.items()})
    texture.image.colorspace_settings.name = "Non-Color"
    texture.image_user.frame_start, texture.image_user.frame_duration = 2, 3
    texture.image_user.use_auto_refresh = True
    tree.links.new(texture.outputs[0], glow.inputs[0])
    tree.links.new(glow.outputs[0], surface)
    sheet = parts.square("Sheet", (0.0, 3.0, 0.0), 1.0, material)
    for frame, x in ((1, -0.1), (5, 0.1)):
        sheet.location.x = x
        sheet.keyframe_insert("location", frame=frame)
    scene.render.filepath = str(tmp_path / "picture-####")
    blender.ops.render.render(animation=True)
    for number, colour in colours.items():
        picture = parts.read(tmp_path / f"picture-{number + 1:04}.exr")
        # In the middle of the sheet; its file has eight bits.
        assert np.allclose(picture[12, 18, :3], colour, atol=0.5 / 255 + 1e-4), number
        scene.frame_set(number + 1)
        assert np.array_equal(picture, parts.render(tmp_path, "alone.exr")), number


@pytest.mark.once
def test_a_focus_pull_while_the_shutter_is_open(parts, blender, tmp_path):
    """From one lamp to another within a frame: the mean of the pictures before, between and after."""
    scene = parts.set_up(width=36, height=24, samples=64, model="LENS")
    camera = scene.camera.data
    camera.petzval.lens_file = "double-gauss-f2-tronnier.lens"
    for x, y in ((-0.2, 1.0), (0.3, 3.0)):
        parts.square(f"At {y}", (x, y, 0.0), 0.1 * y, parts.emitter((4.0, 4.0, 4.0)))
    for frame, distance in ((1, 1.0), (2, 3.0)):
        camera.dof.focus_distance = distance
        assert camera.dof.keyframe_insert("focus_distance", frame=frame)
    # bpy 5 keeps curves in layers; everything else about them is the default: eased in and out.
    scene.frame_set(1, subframe=0.5)
    camera_before = scene.camera.data.dof.focus_distance
    scene.render.motion_blur_shutter = 1.0
    scene.render.use_motion_blur = True
    blurred = parts.render(tmp_path, "blurred.exr")
    assert scene.frame_current == 1 and scene.frame_subframe == pytest.approx(0.5)
    assert scene.camera.data.dof.focus_distance == pytest.approx(camera_before)
    scene.render.use_motion_blur = False
    still = []
    for step in range(16):
        scene.frame_set(1, subframe=(step + 0.5) / 16)
        still.append(parts.render(tmp_path, f"still-{step}.exr"))
    mean = np.mean(still, axis=0)
    # 64 samples of the blurred picture; a lamp of radiance 4 that half of a pixel's rays see.
    assert np.abs(blurred - mean)[..., :3].mean() < 0.03
    assert np.abs(still[0] - mean)[..., :3].mean() > 0.06
