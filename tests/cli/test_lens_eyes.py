# SPDX-License-Identifier: GPL-3.0-or-later
"""Eyes at the command line: they accommodate, their pupils have diameters, and a gradient bends the rays of a drawing."""

from __future__ import annotations

import json
import re
from math import sin

import pytest

from support.command_line import answer, assert_complains

pytestmark = pytest.mark.once

#: A rod of 10 mm with plane ends behind a stop.
ROD = """\
# glass: ROD cauchy 380-750 1.6
# gradient: ROD r2=-0.002
#radius thickness glass diameter conic isstop
0 0 air 2 0 1
0 10 ROD 4 0 0
0 20 air 4 0 0
"""


def test_an_eye_accommodates_and_its_retina_stays(petzval_cli):
    far = answer(petzval_cli("lens", "info", "eye-navarro", "--json"))
    near = answer(petzval_cli("lens", "info", "eye-navarro", "--focus-distance", "250", "--json"))
    # The film is found for the distance, and stands where it stood: the lens has been bisected to a rounding.
    assert near["film_z_mm"] == pytest.approx(far["film_z_mm"], abs=1e-6)
    assert near["object_plane_mm"] == pytest.approx(near["entrance_pupil"]["z_mm"] - 250.0, abs=1e-9)
    # 4 dioptres more before the eye; behind it somewhat more, as the power is not all at the cornea.
    power = [1336.05 / info["efl_mm"] for info in (far, near)]
    assert 4.0 < power[1] - power[0] < 6.0
    assert_complains(
        petzval_cli("lens", "info", "eye-navarro", "--focus-distance", "60"), "60.0 mm", "too close", "108.1 mm"
    )


def test_a_pupil_has_a_diameter(petzval_cli):
    info = answer(petzval_cli("lens", "info", "eye-le-grand", "--pupil-diameter", "3", "--json"))
    assert info["entrance_pupil"]["diameter_mm"] == pytest.approx(3.0, rel=1e-12)
    done = petzval_cli("lens", "info", "eye-le-grand", "--pupil-diameter", "3", "--f-number", "4")
    assert_complains(done, "--pupil-diameter", status=2)
    assert_complains(petzval_cli("lens", "info", "eye-le-grand", "--pupil-diameter", "0"), "pupil's diameter")
    # Wider than the iris opens: as wide as it opens.
    wide = answer(petzval_cli("lens", "info", "eye-le-grand", "--pupil-diameter", "30", "--json"))
    assert wide["stop_diameter_mm"] == 4.0


def test_a_gradient_is_no_guess(petzval_cli, tmp_path):
    info = answer(petzval_cli("lens", "info", "eye-liou-brennan", "--wavelength", "555", "--json"))
    # 1 / 60.35 D in the vitreous of 1.33605.
    assert info["efl_mm"] == pytest.approx(1336.05 / 60.35, rel=1e-4)
    assert info["seidel"] is None and "gradient" in info["seidel_missing"]
    out = tmp_path / "eye.json"
    assert petzval_cli("lens", "draw", "eye-liou-brennan", "--fields", "0", "-o", out).returncode == 0
    drawn = json.loads(out.read_text())
    # More places than the start, six surfaces and the film; in the gradients they do not lie on a line.
    path = drawn["fields"][0]["rays"][0]
    assert len(path) > 10
    slopes = [(b[1] - a[1]) / (b[0] - a[0]) for a, b in zip(path, path[1:], strict=False) if a[0] > 3.8 and b[0] < 7.0]
    assert len(slopes) > 4 and max(slopes) - min(slopes) > 1e-3
    # The table of a rod whose index falls off from its axis: the eye's takes ten seconds.
    rod = tmp_path / "rod.lens"
    rod.write_text(ROD)
    table = petzval_cli("lens", "info", rod).stdout
    assert "no Seidel sums: a medium has a gradient" in table
    # n = n0 (1 - g² r² / 2): the focal length is 1 / (n0 g sin(g L)).
    n0, g, length_mm = 1.6, (2.0 * 0.002 / 1.6) ** 0.5, 10.0
    focal_length_mm = float(re.search(r"^focal length +([0-9.]+) mm$", table, re.MULTILINE)[1])
    assert focal_length_mm == pytest.approx(1.0 / (n0 * g * sin(g * length_mm)), rel=1e-6)
    written = tmp_path / "eye.zmx"
    done = petzval_cli("lens", "convert", "eye-liou-brennan", written)
    assert done.returncode == 0 and "the gradient of its medium stands in the notes only" in done.stderr
