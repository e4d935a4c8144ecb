# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval render`, driven as a user would: statistics, formats, frame, seed, output."""

from __future__ import annotations

import subprocess
import sys

import pytest

from cli_render_parts import picture


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


def test_the_frame(blender, cli_render):
    first, second = (picture(cli_render("--camera", "pinhole", "--frame", frame)[1]) for frame in (1, 2))
    assert first[..., 0].argmax(axis=1).max() < second[..., 0].argmax(axis=1).max()


@pytest.mark.once
def test_seed_and_offset(blender, cli_render):
    options = ("--lens", "cooke-triplet-50mm", "--samples", 2)
    same = [picture(cli_render(*options, "--seed", 3)[1]) for _ in range(2)]
    assert (same[0] == same[1]).all()
    assert (same[0] != picture(cli_render(*options, "--seed", 4)[1])).any()
    # Two halves make the whole.
    halves = [picture(cli_render(*options, "--seed", 3, "--sample-offset", offset)[1]) for offset in (0, 2)]
    whole = picture(cli_render("--lens", "cooke-triplet-50mm", "--samples", 4, "--seed", 3)[1])
    assert abs((halves[0] + halves[1]) / 2 - whole).max() < 1e-4 * max(whole.max(), 1.0)


@pytest.mark.once
def test_as_many_samples_as_the_noise_asks_for(blender, cli_render):
    options = ("--lens", "cooke-triplet-50mm", "--samples", 64, "--seed", 3)
    done, out, stats = cli_render(*options, "--noise-threshold", 0.1, "--min-samples", 4)
    assert done.returncode == 0, done.stderr
    least, mean, most = stats["samples"], stats["samples_mean"], stats["samples_most"]
    assert 4 <= least < mean < most <= 64
    # Some samples serve the error alone.
    assert mean * 48 * 32 - 1 <= stats["camera_rays"] < 64 * 48 * 32
    adaptive = picture(out)
    assert (adaptive == picture(cli_render(*options, "--noise-threshold", 0.1, "--min-samples", 4)[1])).all()
    # None: as many everywhere, and the same picture to the last bit as if nothing were said.
    _, out, stats = cli_render(*options, "--noise-threshold", 0)
    assert stats["samples"] == stats["samples_mean"] == stats["samples_most"] == 64
    whole = picture(out)
    assert (whole == picture(cli_render(*options)[1])).all()
    # The same light, to what the threshold leaves of noise: a mean over 1536 pixels.
    assert abs(adaptive[..., :3].mean() / whole[..., :3].mean() - 1.0) < 0.02


@pytest.mark.once
def test_blue_noise_is_another_picture_of_the_same_light(blender, cli_render):
    options = ("--camera", "pinhole", "--samples", 4)
    own, same, shared = (
        picture(cli_render(*options, *more)[1]) for more in ((), ("--blue-noise", "off"), ("--blue-noise", "on"))
    )
    assert (own == same).all() and (own != shared).any()
    assert abs(shared.mean() / own.mean() - 1.0) < 0.01


@pytest.mark.once
def test_the_default_output(petzval_cli, cli_scenes, tmp_path):
    command = [sys.executable, "-m", "petzval", "render", str(cli_scenes / "scene.blend"), "--samples", "1"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "scene.png").exists()
