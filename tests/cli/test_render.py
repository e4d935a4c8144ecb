# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval render`, driven as a user would: statistics, formats, frame, seed, output."""

from __future__ import annotations

import subprocess
import sys

import pytest

from support.render_commands import picture


@pytest.mark.once
def test_statistics_as_promised(cli_render):
    done, out, stats = cli_render("--camera", "pinhole", "--samples", 3, "--seed", 5, "--threads", 1)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert out.exists()
    number = (int, float)
    wanted = {
        "samples": int, "camera_rays": int, "camera_rays_lost": int, "rays": int, "peak_memory_mb": number,
        "plan": list, "seed": int, "threads": int, "non_finite_samples": int,
        "processor": str,
    }  # fmt: skip
    for key, kind in wanted.items():
        assert isinstance(stats[key], kind) and not isinstance(stats[key], bool), key
    assert set(stats["seconds"]) >= {"sync", "bvh", "plan", "render"}
    assert all(isinstance(value, number) and value >= 0.0 for value in stats["seconds"].values())
    assert (stats["samples"], stats["seed"], stats["threads"]) == (3, 5, 1)
    assert stats["camera_rays"] == 3 * 48 * 32 and stats["camera_rays_lost"] == 0
    assert stats["rays"] >= stats["camera_rays"]
    assert stats["non_finite_samples"] == 0
    assert 50.0 < stats["peak_memory_mb"] < 5000.0


def test_scripts_in_a_file_never_run(cli_render, cli_scenes):
    done, _, _ = cli_render("--camera", "pinhole", "--samples", 1)
    assert done.returncode == 0, done.stderr
    assert not (cli_scenes / "ran").exists()


def test_formats(blender, cli_render):
    for name in ("a.exr", "a.png", "A.PNG"):
        done, out, _ = cli_render("--camera", "pinhole", "--resolution", "40x20", name=name)
        assert done.returncode == 0, done.stderr
        assert picture(out).shape[:2] == (20, 40)
    assert out.read_bytes()[:4] == b"\x89PNG"


@pytest.mark.once
def test_the_frame(blender, cli_render):
    first, second = (picture(cli_render("--camera", "pinhole", "--frame", frame)[1]) for frame in (1, 2))
    assert first[..., 0].argmax(axis=1).max() < second[..., 0].argmax(axis=1).max()


@pytest.mark.once
def test_seed_and_offset(blender, cli_render, cli_renders):
    options = ("--lens", "cooke-triplet-50mm", "--samples", 2)
    # Two halves make the whole.
    halves = [(*options, "--seed", 3, "--sample-offset", offset) for offset in (0, 2)]
    several = cli_renders(
        (*options, "--seed", 3),
        (*options, "--seed", 4),
        *halves,
        (*options[:2], "--samples", 4, "--seed", 3, "--sample-offset", 0),
    )
    assert all(one.returncode == 0 for one in several), several
    three, four, *halves, whole = (picture(one.out) for one in several)
    # In a process of its own.
    assert (three == picture(cli_render(*options, "--seed", 3)[1])).all()
    assert (three != four).any()
    assert abs((halves[0] + halves[1]) / 2 - whole).max() < 1e-4 * max(whole.max(), 1.0)


@pytest.mark.once
def test_as_many_samples_as_the_noise_asks_for(blender, cli_renders):
    options = ("--lens", "cooke-triplet-50mm", "--samples", 64, "--seed", 3)
    asked = (*options, "--noise-threshold", 0.1, "--min-samples", 4)
    done = cli_renders(asked, asked, (*options, "--noise-threshold", 0), options)
    assert all(one.returncode == 0 for one in done), done
    adaptive, again, whole, unasked = (picture(one.out) for one in done)
    stats = done[0].stats
    least, mean, most = stats["samples"], stats["samples_mean"], stats["samples_most"]
    assert 4 <= least < mean < most <= 64
    # Some samples serve the error alone.
    assert mean * 48 * 32 - 1 <= stats["camera_rays"] < 64 * 48 * 32
    assert (adaptive == again).all()
    # None: as many everywhere, and the same picture to the last bit as if nothing were said.
    stats = done[2].stats
    assert stats["samples"] == stats["samples_mean"] == stats["samples_most"] == 64
    assert (whole == unasked).all()
    # The same light, to what the threshold leaves of noise: a mean over 1536 pixels.
    assert abs(adaptive[..., :3].mean() / whole[..., :3].mean() - 1.0) < 0.02


@pytest.mark.once
def test_blue_noise_is_another_picture_of_the_same_light(blender, cli_renders):
    options = ("--camera", "pinhole", "--samples", 4)
    off = (*options, "--blue-noise", "off")
    threshold = ("--noise-threshold", 1e-6)
    asked = [
        options,
        (*options, "--blue-noise", "on"),
        off,
        (*options, "--sample-offset", 0),
        (*options, *threshold),
        (*off, *threshold),
    ]
    same, shared, own, part, adaptive, plain = (picture(one.out) for one in cli_renders(*asked))
    assert (shared == same).all() and (own != shared).any()
    assert abs(shared.mean() / own.mean() - 1.0) < 0.01
    # Not for parts of a picture, and not where pixels stop by themselves.
    assert (part == own).all() and (adaptive == plain).all()


@pytest.mark.once
def test_the_default_output(petzval_cli, cli_scenes, tmp_path):
    command = [sys.executable, "-m", "petzval", "render", str(cli_scenes / "scene.blend"), "--samples", "1"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "scene.png").exists()


@pytest.mark.once
def test_a_scene_in_black_and_white_stays_so(blender, petzval_cli, tmp_path):
    """As when Blender itself saves its picture."""
    from support import scenes as parts

    scene = parts.set_up(48, 32, 4)
    parts.square("Square", (0.0, 5.0, 0.0), 4.0, parts.emitter((1.0, 0.5, 0.2), 2.0))
    shown = {}
    for mode in ("BW", "RGB"):
        scene.render.image_settings.color_mode = mode
        blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / f"{mode}.blend"))
        out = tmp_path / f"{mode}.exr"
        done = petzval_cli("render", tmp_path / f"{mode}.blend", "--camera", "pinhole", "-o", out)
        assert done.returncode == 0, done.stderr
        shown[mode] = picture(out)[..., :3]
    grey = shown["BW"]
    assert grey.max() > 0.5 and (grey == grey[..., :1]).all()
    assert (shown["RGB"] != shown["RGB"][..., :1]).any()


@pytest.mark.once
def test_an_animation_is_rendered_frame_by_frame(petzval_cli, cli_scenes, tmp_path):
    out, stats = tmp_path / "walk_###.exr", tmp_path / "stats.json"
    options = ("--camera", "pinhole", "--samples", 1, "--frames", "1-3,2", "-o", out, "--stats", stats)
    done = petzval_cli("render", cli_scenes / "scene.blend", *options)
    assert done.returncode == 0, done.stderr
    assert sorted(one.name for one in tmp_path.iterdir()) == [
        "stats_0001.json",
        "stats_0003.json",
        "walk_001.exr",
        "walk_003.exr",
    ]
    single = tmp_path / "single.exr"
    done = petzval_cli("render", cli_scenes / "scene.blend", *options[:4], "--frame", 3, "-o", single)
    assert done.returncode == 0, done.stderr
    assert (picture(single) == picture(tmp_path / "walk_003.exr")).all()
    assert (picture(single) != picture(tmp_path / "walk_001.exr")).any()


@pytest.mark.once
@pytest.mark.parametrize("frames", ["3-1", "one", "1-9,0"])
def test_bad_ranges_of_frames(petzval_cli, cli_scenes, frames):
    done = petzval_cli("render", cli_scenes / "scene.blend", "--frames", frames)
    assert done.returncode == 2 and "--frames" in done.stderr


@pytest.mark.once
def test_what_was_done_is_said_in_a_line(cli_render):
    done, _, stats = cli_render("--lens", "nikkor-z-50-f1.8", "--f-number", 1, "--samples", 1, "--focus-distance", 829)
    assert done.returncode == 0, done.stderr
    line = stats["camera"]
    assert f"Petzval: {line}" in done.stdout.splitlines()
    assert "Nikkor Z 50 mm F/1.8 S" in line and "(f/1 is wider than it opens)" in line
    assert "focused at 829 mm" in line and line.endswith(" mm")


@pytest.mark.once
def test_focus_on_an_object_by_its_name(cli_render):
    done, _, _ = cli_render("--lens", "cooke-triplet-50mm", "--samples", 1, "--focus-object", "Nobody")
    assert done.returncode == 1 and "no object 'Nobody'" in done.stderr
