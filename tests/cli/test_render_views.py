# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval render` of scenes in stereo and multiview: the files of their views, named and formatted as Blender does it."""

from __future__ import annotations

import numpy as np
import pytest

from support.render_commands import many, one_line, picture

pytestmark = pytest.mark.once


@pytest.fixture
def stereo(parts, blender, tmp_path):
    """Saves a scene of two eyes with other settings of its pictures; gives its path."""
    scene = parts.set_up(48, 32, 4)
    parts.square("Square", (0.1, 5, 0.2), 0.6, parts.emitter((1.0, 0.5, 0.2), 2.0))
    scene.render.use_multiview = True
    scene.camera.data.stereo.interocular_distance = 0.5

    def save(name: str, **settings):
        for key, value in settings.items():
            setattr(scene.render.image_settings, key, value)
        path = tmp_path / f"{name}.blend"
        blender.ops.wm.save_as_mainfile(filepath=str(path))
        return path

    return save


def names(folder) -> list[str]:
    return sorted(one.name for one in folder.iterdir() if one.suffix != ".blend" and one.is_file())


def test_a_file_for_each_eye(stereo, tmp_path):
    scene, out = stereo("scene"), tmp_path / "out"
    out.mkdir()
    done, frames = many(
        [["render", scene, "-o", out / "p.exr"], ["render", scene, "--frames", "1-2", "-o", out / "f_##.exr"]], tmp_path
    )
    assert done.returncode == frames.returncode == 0, done.stderr + frames.stderr
    assert names(out) == [*(f"f_{frame:02d}_{eye}.exr" for frame in (1, 2) for eye in "LR"), "p_L.exr", "p_R.exr"]
    left, right = (picture(out / f"p_{eye}.exr") for eye in "LR")
    # The square stands before the convergence plane: 0.5 / 5 of the focal length less than it would without.
    columns = [np.argmax(one[..., 0].sum(0)) for one in (left, right)]
    assert columns[0] != columns[1]
    assert np.array_equal(picture(out / "f_01_R.exr"), right)


def test_both_eyes_in_one_file(stereo, blender, tmp_path):
    """Side by side, as one who looks crosses them; in a file of many layers each view is its own."""
    blender.context.scene.render.image_settings.stereo_3d_format.display_mode = "SIDEBYSIDE"
    side = stereo("side", file_format="PNG", views_format="STEREO_3D")
    alone = stereo("alone", views_format="INDIVIDUAL")
    both, each, layers = many(
        [["render", path, *more, "-o", tmp_path / name] for path, more, name in (
            (side, [], "side.png"), (alone, [], "alone.png"), (stereo("layers"), ["--passes"], "layers.exr"))],
        tmp_path,
    )  # fmt: skip
    assert both.returncode == each.returncode == layers.returncode == 0, both.stderr + each.stderr + layers.stderr
    assert names(tmp_path)[:4] == ["alone_L.png", "alone_R.png", "layers_L.exr", "layers_R.exr"]
    whole = picture(tmp_path / "side.png")
    assert whole.shape[:2] == (32, 96)
    for begin, eye in ((0, "L"), (48, "R")):
        np.testing.assert_array_equal(whole[:, begin : begin + 48], picture(tmp_path / f"alone_{eye}.png"))


def test_views_that_would_have_one_file_are_refused(stereo, blender, tmp_path):
    blender.context.scene.render.views["right"].file_suffix = "_L"
    (done,) = many([["render", stereo("same"), "-o", tmp_path / "p.exr"]], tmp_path)
    assert done.returncode == 1 and "file suffix '_L'" in done.stderr
    one_line(done)
    assert not (tmp_path / "p_L.exr").exists()
