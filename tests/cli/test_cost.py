# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval cost`: its statistics on numbers that are known, and a small run of all of it."""

from __future__ import annotations

import json
import random

import numpy as np
import pytest

from petzval.cost import accuracy, advice, flip, intervals, ladder, tables
from petzval.description import CameraDescription

pytestmark = pytest.mark.once


def test_an_interval_holds_the_median_as_often_as_it_says():
    draw = random.Random(4)
    for count in (5, 9, 20):
        held = 0
        for _ in range(2000):
            values = [draw.expovariate(1.0) for _ in range(count)]
            middle, low, high = intervals.median_interval(values)
            assert low <= middle <= high
            held += low <= np.log(2.0) <= high
        # The share of 2000 varies by 0.007; it may be larger than was asked for, as ranks are whole numbers.
        assert held / 2000 > intervals.CONFIDENCE - 0.025


def test_few_values_have_no_interval():
    assert intervals.median_interval([1.0, 1.0, 1.0, 1.0])[1:] == (-np.inf, np.inf)
    assert not intervals.is_settled([1.0] * 4)
    assert intervals.is_settled([1.0, 1.001, 1.002, 1.003, 1.004])


def sums(limit, noise: float, count: int, random_numbers) -> accuracy.Sums:
    made = accuracy.Sums()
    for _ in range(count):
        made.add(limit + noise * random_numbers.standard_normal(limit.shape))
    return made


@pytest.mark.parametrize("off", [0.0, 0.05])
def test_bias_is_told_from_noise(off):
    random_numbers = np.random.default_rng(2)
    truth = 0.5 + random_numbers.random((60, 80, 3))
    halves = tuple(sums(truth, 0.1, 8, random_numbers) for _ in range(2))
    found = accuracy.error(sums(truth * (1.0 + off), 0.4, 40, random_numbers), halves)
    # The floor takes 4 hundredths off, at most. A pixel's means vary by 0.16 / 40 and 0.01 / 16; relative to squares of 0.25
    # and more the estimate of 14400 values varies by 1e-4.
    assert found.bias == pytest.approx(off**2, abs=4e-4)
    assert abs(found.bias - off**2) < 4.0 * found.bias_uncertainty
    assert (found.sure_bias > 0.0) == (off > 0.0)
    # Of one picture: 0.16 over the squares of 0.5 to 1.5, whose mean inverse is 4/3.
    assert found.noise == pytest.approx(0.16 * 4.0 / 3.0, rel=0.05)


def test_a_part_of_the_light_is_as_large_as_it_is():
    """Beside pixels of 1, a part of 0.1 with noise of a fifth of that is a change of a hundredth, whatever the noise of the rest."""
    random_numbers = np.random.default_rng(3)
    truth, part = np.ones((60, 80, 3)), np.full((60, 80, 3), 0.1)
    found = accuracy.change(sums(part, 0.02, 8, random_numbers), truth)
    # The floor adds a hundredth to the square of the truth. Of 14400 values.
    assert found.bias == pytest.approx(0.01 / 1.01, rel=0.02)
    assert found.sure_bias > 0.0 and found.noise == pytest.approx(0.0004 / 1.01, rel=0.05)
    # Noise alone is nothing.
    assert accuracy.change(sums(0.0 * part, 0.05, 8, random_numbers), truth).sure_bias == 0.0
    assert accuracy.size(part, truth) == pytest.approx(0.01 / 1.01)


def test_flip_is_that_of_its_authors():
    y, x = np.mgrid[0:48, 0:64]
    first = np.stack([x / 63, y / 47, ((x // 8 + y // 8) % 2) * 0.8 + 0.1], -1)
    second = np.roll(first, 2, axis=1)
    second[10:20, 10:30] *= 0.5
    assert flip.flip(first, first) == 0.0
    # By flip-evaluator 1.7, of the same pictures in sRGB.
    assert flip.flip(second, first) == pytest.approx(0.313248, abs=1e-5)


def row(key: str, bias: float, us: float, **more) -> dict:
    return {
        "key": key, "name": key, "group": "camera", "is_measured": True, "bias": bias, "bias_estimate": bias,
        "bias_uncertainty": 1e-6, "noise_of_one_sample": 1.0, "us_a_sample": us, "setup_s": 0.0, "ratio": us, "ratio_interval": [us, us],
        "seconds": 1e-6 * us * 64e4, "rel_mse": bias + 1.0 / 64, "is_on_front": True, "effect": None,
    } | more  # fmt: skip


def found(**rows) -> dict:
    return {"rungs": list(rows.values()), "size": [100, 100], "samples": 64, "base": "pinhole"}


def test_a_faster_camera_is_advised_only_if_its_picture_is_the_same():
    pinhole, hero = row("pinhole", 0.2, 1.0), row("hero", 0.0, 2.0)
    said = advice.advice(found(pinhole=pinhole, hero=hero, auto=row("auto", 0.0, 1.5)))
    assert said[0].startswith("Use auto.") and "33% longer" in said[1]
    assert "pinhole 45 %" in said[2]
    # The plan chose badly: something that is the truth too, is faster.
    said = advice.advice(found(pinhole=pinhole, hero=hero, auto=row("auto", 0.0, 3.0)))
    assert said[0].startswith("Use hero.")


def test_time_to_an_error_is_that_of_its_noise():
    one = row("thick", 0.01, 2.0)
    # Of 0.02 a half is noise: a hundred samples of ten thousand pixels.
    assert advice.seconds_to(one, 0.02, found()) == pytest.approx(2.0)
    assert advice.seconds_to(one, 0.01, found()) is None


def test_simple_cameras_frame_what_the_lens_does():
    camera = CameraDescription("Camera", np.eye(4).tolist())
    info = {"viewport_focal_length_mm": 50.0, "entrance_pupil_diameter_mm": 20.0, "picture_width_mm": 36.0,
            "viewport_shift": [0.1, 0.0], "focus_distance_mm": 2000.0}  # fmt: skip
    rungs = {
        one.key: one
        for one in ladder.ladder(camera, info, ["defocus", "lateral_colour"], {"effects": {}, "quality": 1.0})
    }
    assert rungs["thin"].camera["lens.f_number"] == 2.5 and rungs["thin"].camera["focus.distance"] == 2.0
    assert rungs["pinhole"].camera["perspective.shift"] == (0.1, 0.0)
    assert "lateral_colour" not in rungs["one-f32"].effects and rungs["no-defocus"].effects["defocus"] == "off"
    assert rungs["with-transmission"].missing and rungs["with-ghosts"].missing
    able = {one.key: one for one in ladder.ladder(camera, info, ["ghosts"], {"effects": {}, "quality": 1.0})}
    assert able["with-ghosts"].effects == {"ghosts": "on"} and able["hero"].effects == {"ghosts": "off"}


@pytest.mark.slow
def test_a_small_run(petzval_cli, cli_scenes, tmp_path):
    lens = ["--lens", "cooke-triplet-50mm", "--film", "36x24"]
    small = ["--resolution", "24x16", "--samples", "4", "--rounds", "4", "--seconds", "8", "--threads", "1"]
    done = petzval_cli(
        "cost", cli_scenes / "scene.blend", *lens, *small, "-o", tmp_path / "costs", "--json", timeout_s=400.0
    )
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told == json.loads((tmp_path / "costs/costs.json").read_text())
    rows = {row["key"]: row for row in told["rungs"]}
    assert told["rounds"] == 4 and told["scene"] == "scene" and told["threads"] == 1
    assert rows["with-ghosts"]["is_measured"] and rows["with-ghosts"]["effect"] == "ghosts"
    assert not any(row["is_on_front"] for row in rows.values() if row["group"] in ("effect", "stray"))
    strays = {row["effect"]: row for row in rows.values() if row["group"] == "stray"}
    assert strays.keys() == {"ghosts", "glare", "diffraction"} and rows["no-transmission"]["is_measured"]
    for stray in strays.values():
        assert stray["is_measured"] and stray["stray_s"] > 0.0
        # What these change is the same in every picture, but for the little noise that is spread with it.
        assert stray["bias"] <= told["strays"]["bias"] + 3.0 * stray["bias_uncertainty"] + 1e-9
    # A hundredth of what lights the front lies over all of the picture: without it pixels are off, and it looks different.
    assert 1e-6 < strays["glare"]["bias"] < 0.1 and strays["glare"]["flip"] > 0.003
    assert told["strays"]["stray_s"] == pytest.approx(sum(row["stray_s"] for row in strays.values()))
    assert rows["pinhole"]["ratio"] == 1.0
    for row in rows.values():
        if row["is_measured"]:
            assert row["us_a_sample"] > 0.0 and row["noise_of_one_sample"] >= 0.0 and 0.0 <= row["flip"] <= 1.0
    assert rows["hero"]["wavelengths"] >= 8 and rows["one-f32"]["wavelengths"] == 1
    page = (tmp_path / "costs/costs.md").read_text()
    for effect in (
        "| without transmission (coatings, glass) |",
        "| ghosts |",
        "| veiling glare |",
        "| diffraction |",
        "| all of it |",
    ):
        assert effect in page
    assert page == tables.markdown(told, picture="costs.png" if (tmp_path / "costs/costs.png").exists() else None)
    if not (tmp_path / "costs/costs.png").exists():
        assert done.stderr.count("\n") == 1 and "petzval[plots]" in done.stderr


def test_a_camera_of_its_own_is_refused(petzval_cli, cli_scenes, tmp_path):
    done = petzval_cli("cost", cli_scenes / "scene.blend", "--camera", "thin", "-o", tmp_path / "costs")
    assert done.returncode == 2 and "--lens" in done.stderr
