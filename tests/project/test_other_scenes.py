# SPDX-License-Identifier: GPL-3.0-or-later
"""What pictures of several seeds say of a program's noise, and of how far two programs are apart."""

import os
import subprocess
import sys

import blend_files
import numpy as np
import pytest
from other_scenes import compare

from support.places import ROOT

pytestmark = pytest.mark.once

SHAPE = (45, 80, 3)


def pictures(count: int, spread: np.ndarray | float, seed: int = 0) -> list[np.ndarray]:
    """Of brightness one, with normal noise of this standard deviation, alike in all channels as that of light is."""
    random = np.random.default_rng(seed)
    return [1.0 + random.normal(size=(*SHAPE[:2], 1)) * spread * np.ones(SHAPE) for _ in range(count)]


@pytest.mark.parametrize("count", [2, 8])
def test_noise_is_the_variance_of_a_pixel(count):
    found = compare.noise(pictures(count, 0.1), np.ones(SHAPE))
    # The brightest thousandth of the pixels is left out.
    assert found.variance == pytest.approx(0.01, rel=0.05)
    assert found.error < 0.05


def test_noise_in_few_pixels_is_known_badly_and_better_with_more_pictures():
    spread = np.zeros(SHAPE)
    # More than the thousandth that is left out.
    spread[10, 20:60] = 1.0
    errors = []
    for count in (2, 4, 8):
        variances = [compare.noise(pictures(count, spread, seed), np.ones(SHAPE)) for seed in range(60)]
        said = np.mean([one.error for one in variances])
        errors.append(said)
        # As far as they lie apart, within what 60 say of that, and what the pixels left out take.
        found = np.std([one.variance for one in variances]) / np.mean([one.variance for one in variances])
        assert said == pytest.approx(found, rel=0.5)
    assert errors[0] > 0.15 and errors == sorted(errors, reverse=True)


def test_programs_agree_beyond_noise_where_only_noise_parts_them():
    ours, theirs = pictures(2, 0.1, 1), pictures(2, 0.1, 2)
    assert compare.difference(ours, theirs).beyond_noise < 0.005
    brighter = [1.03 * one for one in theirs]
    assert compare.difference(ours, brighter).beyond_noise == pytest.approx(0.03, abs=0.006)


def test_more_pictures_leave_less_noise_in_the_difference():
    spread = np.zeros(SHAPE)
    spread[::7, ::5] = 2.0
    found = {
        count: [
            compare.difference(pictures(count, spread, seed), pictures(count, spread, 100 + seed)) for seed in range(20)
        ]
        for count in (2, 8)
    }
    said = {count: np.mean([one.of_noise for one in all_of_it]) for count, all_of_it in found.items()}
    beyond = {count: np.mean([one.beyond_noise for one in all_of_it]) for count, all_of_it in found.items()}
    assert said[8] == pytest.approx(said[2] / 2, rel=0.2) and beyond[8] < 0.7 * beyond[2]
    # A true difference stays, of the means of both and a twentieth.
    brighter = [1.2 * one for one in pictures(8, spread, 300)]
    assert compare.difference(brighter, pictures(8, spread, 301)).beyond_noise == pytest.approx(0.2 / 1.15, abs=0.012)


def test_a_folder_that_is_called_like_a_scene_is_not_one(tmp_path):
    """Poly Haven's archives of textures unpack into `worn_planks_2k.blend/textures`."""
    (tmp_path / "planks.blend" / "textures").mkdir(parents=True)
    (tmp_path / "planks.blend" / "planks.blend").write_bytes(b"BLENDER")
    assert blend_files.under(tmp_path) == [tmp_path / "planks.blend" / "planks.blend"]


def test_a_first_look_at_scenes(blender, tmp_path):
    """With a camera and without, and one that is no scene."""
    from support import scenes as parts

    scene = parts.set_up(64, 36, 4)
    parts.square("Square", (0.0, 5.0, 0.0), 2.0, parts.material()[0])
    blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "seen.blend"))
    blender.data.objects.remove(scene.camera)
    scene.world = None
    blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "part.blend"))
    (tmp_path / "broken.blend").write_bytes(b"BLENDER")
    done = subprocess.run(
        [sys.executable, "-m", "other_scenes", tmp_path, "--look", "--size", "64x36", "--samples", "16"],
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
        env=os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT / "tools"), os.environ.get("PYTHONPATH", "")])},
    )
    assert done.returncode == 0, done.stderr
    told = {line.split()[-1].rsplit("/")[-1]: line for line in done.stdout.splitlines()[:-1]}
    assert "beyond noise" in told["seen.blend"] and "APART" not in told["seen.blend"], told
    assert "beyond noise" in told["part.blend"] and "APART" not in told["part.blend"], told
    assert "beyond noise" not in told["broken.blend"]
    assert done.stdout.splitlines()[-1] == "3 scenes, 0 of them apart"
