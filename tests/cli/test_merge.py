# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders of one picture with other samples, joined by `petzval merge`: the picture of one render, in each pass."""

from __future__ import annotations

import json

import numpy as np
import pytest

from support.multilayer import exr_channels

pytestmark = pytest.mark.once


def room(parts, blender):
    """Things before and behind the focus, a lamp in a light group, sky beside them, through a real lens."""
    scene = parts.set_up(width=64, height=40)
    parts.square("Near", (-0.6, 2.5, 0.1), 0.8, parts.emitter((1.0, 0.5, 0.2), 2.0))
    parts.square("Wall", (1.5, 6, 0.2), 3.0, parts.emitter((0.3, 0.5, 0.9), 0.5))
    camera = scene.camera.data.petzval
    camera.model, camera.lens_file = "LENS", "double-gauss-f2-tronnier.lens"
    layer = scene.view_layers[0]
    layer.use_pass_z = layer.use_pass_normal = layer.use_pass_position = layer.use_pass_cryptomatte_object = True
    layer.petzval.use_pass_mergeable = True
    parts.exr(scene, "OPEN_EXR_MULTILAYER")
    scene.render.image_settings.exr_codec = "NONE"
    scene.render.image_settings.color_depth = "32"
    return scene


def shot(blender, scene, path, samples: int, offset: int = 0, seed: int = 0) -> dict[str, np.ndarray]:
    own = scene.petzval
    own.samples, own.sample_offset, own.seed = samples, offset, seed
    scene.render.filepath = str(path)
    blender.ops.render.render(write_still=True, scene=scene.name)
    return exr_channels(path)


def merged(petzval_cli, out, *files) -> tuple[dict[str, np.ndarray], dict]:
    done = petzval_cli("merge", *files, "-o", out, "--json")
    assert done.returncode == 0, done.stderr
    return exr_channels(out), json.loads(done.stdout)


def test_parts_make_the_whole(parts, blender, petzval_cli, tmp_path):
    scene = room(parts, blender)
    whole = shot(blender, scene, tmp_path / "whole.exr", 24)
    names = ("a.exr", "b.exr", "c.exr")
    for name, offset, samples in zip(names, (0, 10, 17), (10, 7, 7), strict=True):
        shot(blender, scene, tmp_path / name, samples, offset)
    a, b, c = (tmp_path / name for name in names)
    # In two steps: what is joined can be joined again.
    _, first = merged(petzval_cli, tmp_path / "ca.exr", c, a)
    joined, second = merged(petzval_cli, tmp_path / "all.exr", tmp_path / "ca.exr", b)
    assert first == {"samples": 17.0, "is_exact": True}
    assert second == {"samples": 24.0, "is_exact": True}
    assert set(joined) == set(whole)
    for name, values in joined.items():
        if ".Combined." in name or ".Remainder" in name or ".Debug Sample Count." in name:
            assert (values == whole[name]).all(), name
    # Coverages count the rays that come through the lens: with one in 24 lost, that much either way.
    cover = "ViewLayer.CryptoObject00.G"
    np.testing.assert_allclose(joined[cover], whole[cover], atol=1.0 / 24.0)
    assert joined[cover].mean() == pytest.approx(whole[cover].mean(), abs=1e-3)
    assert (joined["ViewLayer.CryptoObject00.R"] == whole["ViewLayer.CryptoObject00.R"]).mean() > 0.98
    # Means over what was seen: where that is all, to the rounding of three numbers of single precision, and of their sums;
    # but places differ over a pixel (by 0.05 where it is not sharp), and a ray that was lost changes their mean by a 24th.
    covered = sum(whole[f"ViewLayer.CryptoObject0{i}.{c}"] for i in range(3) for c in "GA")
    solid, empty = covered > 1.0 - 1e-6, covered == 0.0
    assert solid.mean() > 0.1 and empty.mean() > 0.1
    for name in ("Depth.Z", "Normal.X", "Normal.Y", "Normal.Z", "Position.X", "Position.Y", "Position.Z"):
        ours, theirs = joined[f"ViewLayer.{name}"], whole[f"ViewLayer.{name}"]
        within = 0.05 / 24.0 if name.startswith("Position") else 3e-6
        np.testing.assert_allclose(ours[solid], theirs[solid], rtol=1e-5, atol=within, err_msg=name)
        assert (ours[empty] == theirs[empty]).all(), name


def test_counts_that_differ_weigh(parts, blender, petzval_cli, tmp_path):
    """With a noise threshold: each pixel by its own samples, to rounding."""
    scene = room(parts, blender)
    scene.petzval.use_noise_threshold, scene.petzval.noise_threshold = True, 0.05
    a = shot(blender, scene, tmp_path / "a.exr", 128, seed=1)
    b = shot(blender, scene, tmp_path / "b.exr", 128, seed=2)
    joined, said = merged(petzval_cli, tmp_path / "ab.exr", tmp_path / "a.exr", tmp_path / "b.exr")
    count = "ViewLayer.Debug Sample Count.X"
    assert len(np.unique(a[count])) > 1
    total = a[count] + b[count]
    assert (joined[count] == total).all()
    assert not said["is_exact"] and said["samples"] == pytest.approx(total.mean())
    for channel in "RGBA":
        name = f"ViewLayer.Combined.{channel}"
        expected = (a[name].astype(float) * a[count] + b[name].astype(float) * b[count]) / total
        np.testing.assert_allclose(joined[name], expected, rtol=1e-6)


def test_from_the_command_line(blender, petzval_cli, cli_scenes, tmp_path):
    """The command that a user types; and what it refuses."""

    def render(name: str, *options):
        done = petzval_cli(
            "render", cli_scenes / "scene.blend", "--lens", "cooke-triplet-50mm", *options, "-o", tmp_path / name
        )
        assert done.returncode == 0, done.stderr

    render("a.exr", "--samples", 3, "--mergeable")
    render("b.exr", "--samples", 5, "--sample-offset", 3, "--mergeable")
    done = petzval_cli("merge", tmp_path / "a.exr", tmp_path / "b.exr", "-o", tmp_path / "ab.exr")
    assert (done.returncode, done.stderr) == (0, "")
    assert "8 samples a pixel, as one render would have it" in done.stdout
    again = petzval_cli("merge", tmp_path / "a.exr", tmp_path / "ab.exr", "-o", tmp_path / "c.exr")
    assert again.returncode == 1
    assert "samples 0 to 2 of seed 0 are in" in again.stderr and not (tmp_path / "c.exr").exists()
    # Plain pictures can be joined, too: by their metadata.
    render("d.exr", "--samples", 4, "--seed", 9)
    render("e.exr", "--samples", 4, "--seed", 8)
    done = petzval_cli("merge", tmp_path / "d.exr", tmp_path / "e.exr", "-o", tmp_path / "de.exr")
    assert done.returncode == 0, done.stderr
    assert "8 samples a pixel, to the rounding of its numbers" in done.stdout
    for options, said in (((), "bad usage"), (("-o", tmp_path / "x.png"), "end its name in .exr")):
        done = petzval_cli("merge", tmp_path / "d.exr", tmp_path / "e.exr", *options)
        assert done.returncode in (1, 2) and said in done.stderr


def test_the_file_of_one_eye_is_not_joined_with_that_of_the_other(parts, blender, petzval_cli, tmp_path):
    """Both have the same names of channels, and the same metadata."""
    scene = room(parts, blender)
    scene.render.use_multiview, scene.camera.data.stereo.interocular_distance = True, 0.3
    scene.render.image_settings.views_format = "INDIVIDUAL"
    own = scene.petzval
    own.samples = 4
    for offset in (0, 4, 8):
        own.sample_offset, scene.render.filepath = offset, str(tmp_path / f"{offset}.exr")
        blender.ops.render.render(write_still=True, scene=scene.name)
    for eye in "LR":
        merged(petzval_cli, tmp_path / f"both_{eye}.exr", tmp_path / f"0_{eye}.exr", tmp_path / f"4_{eye}.exr")
    # Joined ones know their eye, too.
    for first in ("0", "both"):
        done = petzval_cli("merge", tmp_path / f"{first}_L.exr", tmp_path / "8_R.exr", "-o", tmp_path / "x.exr")
        assert done.returncode == 1 and "it is the view 'right'" in done.stderr, done.stderr
        assert done.stderr.count("\n") == 1 and not (tmp_path / "x.exr").exists()


def test_views_in_one_file_are_joined_each_by_itself(parts, blender, petzval_cli, tmp_path):
    """Their channels have the same names."""
    scene = room(parts, blender)
    scene.render.use_multiview, scene.camera.data.stereo.interocular_distance = True, 0.3
    scene.render.image_settings.views_format = "MULTIVIEW"
    first, second = (shot(blender, scene, tmp_path / f"{seed}.exr", 4, seed=seed) for seed in (1, 2))
    both, _ = merged(petzval_cli, tmp_path / "both.exr", tmp_path / "1.exr", tmp_path / "2.exr")
    red = {view: f"{view}:ViewLayer.Combined.R" for view in ("left", "right")}
    assert not np.array_equal(first[red["left"]], first[red["right"]])
    for name in red.values():
        np.testing.assert_allclose(both[name], 0.5 * (first[name] + second[name]), rtol=1e-5, atol=1e-6)
