# SPDX-License-Identifier: GPL-3.0-or-later
"""Coatings and what glass takes of the light: on the command line, and in a picture, against the product of what surfaces pass."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from support.photograph import chart

#: Two plates of dense flint before a small stop: rays go nearly straight, so each of four surfaces passes what it does at right
#: angles. Bare glass, 6 mm of it in all.
FLINT = """# coating: none
300 3 N-SF66 20 0 0
-300 1 air 20 0 0
300 3 N-SF66 20 0 0
-300 1 air 20 0 0
0 60 air 6 0 1
"""
#: Linear Rec.709 luminance.
LUMINANCE = np.array([0.212671, 0.715160, 0.072169])


@pytest.fixture
def flint(tmp_path) -> Path:
    path = tmp_path / "flint.lens"
    path.write_text(FLINT)
    return path


def passed(nm: float) -> float:
    """The analytic product: Fresnel at right angles, four times, and the glass's own absorption."""
    from petzval import _native

    row = json.loads(_native.glass_json("N-SF66", None, [nm], 6.0))["indices"][0]
    index = row["index"]
    return (1.0 - ((index - 1.0) / (index + 1.0)) ** 2) ** 4 * row["transmittance"]


@pytest.mark.once
def test_a_report_is_the_product_of_surfaces_and_glass(petzval_cli, flint, tmp_path):
    out = tmp_path / "flint.json"
    done = petzval_cli("lens", "transmission", flint, "-o", out, "--spectrum", 420, 700, 40)
    assert done.returncode == 0, done.stderr
    found = json.loads(out.read_text())
    assert found["spectrum_nm"] == [420 + 40 * i for i in range(8)]
    axis = found["fields"][0]
    assert axis["angle_deg"] == 0.0
    # At 3 mm from the axis these weak lenses are up to 0.06 mm thinner than in their middle, a hundredth of their glass, which
    # takes a tenth at the blue end.
    assert axis["parts"] == pytest.approx([passed(nm) for nm in found["spectrum_nm"]], rel=1.5e-3)
    assert not found["coating_is_assumed"] and found["unknown_absorption"] == []
    assert [coating["name"] for coating in found["coatings"]] == ["none"]
    done = petzval_cli("lens", "transmission", flint, "-o", tmp_path / "flint.svg")
    assert done.returncode == 0 and (tmp_path / "flint.svg").stat().st_size > 5000, done.stderr


@pytest.mark.once
def test_coatings_are_shown_and_chosen(petzval_cli, flint):
    def info(lens, *options):
        done = petzval_cli("lens", "info", lens, "--json", *options)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    bare, coated = info(flint), info(flint, "--coating", "MgF2")
    assert bare["coatings"] == ["none"] and coated["coatings"] == ["MgF2"] and not coated["coating_is_assumed"]
    # T = N / sqrt(part of the light): less is lost by coated glass.
    light = [(one["f_number"] / one["t_number"]) ** 2 for one in (bare, coated)]
    assert light[0] == pytest.approx(passed(560.0), abs=0.02) and light[1] > light[0] + 0.2
    silent = info("cooke-triplet-50mm")
    assert silent["coatings"] == ["MgF2"] and silent["coating_is_assumed"]
    table = petzval_cli("lens", "info", "cooke-triplet-50mm").stdout
    assert "coatings: MgF2 (assumed: the file names none)" in table and "T-number" in table
    done = petzval_cli("lens", "info", flint, "--coating", "magic")
    assert done.returncode == 1 and "unknown coating 'magic'" in done.stderr and done.stderr.count("\n") == 1


@pytest.mark.once
def test_conversion_keeps_coatings(petzval_cli, flint, tmp_path):
    own = tmp_path / "own.lens"
    rows = [line + (" MgF2:99.6nm/1.65:0.25w@500" if i == 1 else " -") for i, line in enumerate(FLINT.splitlines()[1:])]
    own.write_text("\n".join(["# coating: triple", "#radius thickness glass diameter conic isstop coating", *rows]))
    for source, kinds in ((flint, ("lens", "zmx")), (own, ("lens",))):
        for kind in kinds:
            out = tmp_path / f"again.{kind}"
            assert petzval_cli("lens", "convert", source, out).returncode == 0
            both = [json.loads(petzval_cli("lens", "info", one, "--json").stdout) for one in (source, out)]
            assert both[0]["coatings"] == both[1]["coatings"]
            assert both[0]["t_number"] == both[1]["t_number"]
            assert not both[1]["coating_is_assumed"]
    done = petzval_cli("lens", "convert", own, tmp_path / "lost.zmx")
    assert "coatings that differ" in done.stderr


def expected_colour() -> np.ndarray:
    """A white world behind the flint by the film's own colours: those of a picture through the lens at single wavelengths are not
    needed, since white light's colour is the mean of what the observer sees of each, weighted by D65."""
    rows = np.array(observer())
    light = rows[:, 4] * np.array([passed(nm) for nm in rows[:, 0]])
    xyz = (rows[:, 1:4] * light[:, None]).sum(0) / (rows[:, 2] * rows[:, 4]).sum()
    rec709 = np.array(
        [[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560], [0.0556434, -0.2040259, 1.0572252]]
    )
    return rec709 @ xyz


def observer() -> list[tuple[float, float, float, float, float]]:
    """Wavelength, the CIE 1931 observer by Wyman, Sloan and Shirley's fits (JCGT 2(2), 2013, equation 4), and D65 by CIE 015,
    every 20 nm and straight between."""

    def lobe(nm, height, middle, below, above):
        t = (nm - middle) * (below if nm < middle else above)
        return height * math.exp(-0.5 * t * t)

    d65 = [49.98, 68.70, 82.75, 91.49, 93.43, 86.68, 104.86, 117.01, 117.81, 114.86, 115.92, 108.81, 109.35, 107.80, 104.79, 107.69,
           104.41, 104.05, 100.0, 96.33, 95.79, 88.69, 90.01, 89.60, 87.70, 83.29, 83.70, 80.03, 80.21, 82.28, 78.28]  # fmt: skip
    nms = [380, 395, *range(400, 690, 10)]
    rows = []
    for nm in range(385, 681, 5):
        x = (
            lobe(nm, 1.056, 599.8, 0.0264, 0.0323)
            + lobe(nm, 0.362, 442.0, 0.0624, 0.0374)
            + lobe(nm, -0.065, 501.1, 0.0490, 0.0382)
        )
        y = lobe(nm, 0.821, 568.8, 0.0213, 0.0247) + lobe(nm, 0.286, 530.9, 0.0613, 0.0322)
        z = lobe(nm, 1.217, 437.0, 0.0845, 0.0278) + lobe(nm, 0.681, 459.0, 0.0385, 0.0725)
        rows.append((float(nm), x, y, z, float(np.interp(nm, nms, d65))))
    return rows


@pytest.mark.once
def test_a_white_world_through_bare_flint_is_yellowish(blender, tmp_path, flint):
    """In Blender, by the plan's own choice: the middle is as bright as ever and has the product's colour; exposed by the f-number it
    is darker by what is lost; and without the effect it is white."""
    studio = chart.Studio(blender, tmp_path, (6, 4), samples=256)
    studio.lens("cooke-triplet-50mm", (0.2, 0.2), None)
    own, effects = studio.data.petzval, studio.scene.petzval.effects
    own.lens_file, own.spectrum, own.white_balance = str(flint), "VISIBLE", False
    effects.transmission = "AUTO"
    studio.white_world()
    expected = expected_colour()
    assert expected[2] < 0.9 * expected[0]

    def seen():
        pixels = studio.shoot().reshape(-1, 3)
        return pixels.mean(0), pixels.std(0) / math.sqrt(len(pixels))

    for by_f_number, level in ((False, 1.0 / float(LUMINANCE @ expected)), (True, 1.0)):
        own.exposes_by_f_number = by_f_number
        found, noise = seen()
        # The observer's fit and its steps are good to about half a per cent of white.
        assert np.all(np.abs(found - level * expected) < 0.008 + 4.0 * noise), (found, level * expected, noise)
        own.white_balance = True
        grey, noise = seen()
        own.white_balance = False
        assert np.all(np.abs(grey - level * float(LUMINANCE @ expected)) < 0.008 + 4.0 * noise), (grey, noise)
    own.coating, own.exposes_by_f_number = "TRIPLE", True
    found, noise = seen()
    assert float(LUMINANCE @ found) > float(LUMINANCE @ expected) + 0.2
    effects.transmission = "OFF"
    found, noise = seen()
    assert np.all(np.abs(found - 1.0) < 1e-3 + 4.0 * noise), (found, noise)
