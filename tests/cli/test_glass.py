# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval glass`: numbers of the catalogues, of files, and pictures."""

import json
import math
from xml.etree import ElementTree

import pytest

from support.places import REFERENCE

pytestmark = pytest.mark.once
REFERENCE = REFERENCE / "glasses.json"

#: Schott's data sheet of N-BK7 as of 2014: coefficients, and internal transmittance of 25 mm at 400 and 350 nm.
AGF = """CC a test
NM N-BK7 2 517642 1.5168 64.17 0 1
CD 1.03961212 0.00600069867 0.231792344 0.0200179144 1.01046945 103.560653
LD 0.3 2.5
IT 0.35 0.92 25.0
IT 0.4 0.992 25.0
"""


def told(petzval_cli, *more):
    done = petzval_cli("glass", *more, "--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_every_glass_has_the_references_index_and_abbe_number(petzval_cli):
    reference = json.loads(REFERENCE.read_text())
    by_name = {}
    for glass in told(petzval_cli, "--list")["glasses"]:
        by_name.setdefault(glass["token"].split(":")[1], []).append(glass)
    compared = 0
    for name, entry in reference.items():
        # Several makers have glasses of one name. The reference prints seven and four decimals.
        same = [abs(glass["nd"] - entry["nd"]) < 6e-8 for glass in by_name.get(name.lower(), []) if name != "_meta"]
        assert not same or any(same), name
        compared += any(same)
    for glass in by_name["n-sf11"]:
        assert glass["abbe"] == pytest.approx(reference["N-SF11"]["Vd"], abs=6e-5)
    assert compared > 1000


def test_a_glass_is_told_line_by_line(petzval_cli):
    done = petzval_cli("glass", "n-bk7")
    assert done.returncode == 0 and done.stderr == ""
    # Schott's data sheet: n_F 1.52238, n_e 1.51872, n_C' 1.51472, V_d 64.17.
    table = [
        line.split()
        for line in done.stdout.splitlines()
        if line[:1] in ("F", "d", "C", "e") and line[3:4].strip() == ""
    ]
    rows = {words[0]: words[2] for words in table if len(words) == 4}
    assert float(rows["F"]) == pytest.approx(1.52238, abs=6e-6)
    assert float(rows["e"]) == pytest.approx(1.51872, abs=6e-6)
    assert float(rows["C'"]) == pytest.approx(1.51472, abs=6e-6)
    # 10 mm of it let through 0.998 at e, says the sheet.
    assert [float(words[3]) for words in table if words[0] == "e"] == [pytest.approx(0.998, abs=1.1e-3)]
    assert "64.167" in done.stdout and "300.0 to 2500.0 nm" in done.stdout


def test_what_lies_beyond_the_range_and_who_else_makes_it_is_said(petzval_cli):
    done = petzval_cli("glass", "F2", "--wavelength", "200", "550")
    assert "(beyond)" in done.stdout.splitlines()[-2] and "(beyond)" not in done.stdout.splitlines()[-1]
    assert "glass F2: its index is known from 320 to 2500 nm" in done.stderr
    assert "made by schott" in done.stderr
    found = told(petzval_cli, "F2", "--wavelength", "200", "320")
    assert [row["is_known"] for row in found["indices"]] == [False, True]
    assert found["indices"][0]["index"] == found["indices"][1]["index"]
    assert told(petzval_cli, "1.62/60.3")["abbe"] == pytest.approx(60.3) and told(petzval_cli, "air")["abbe"] is None


def test_catalogues_of_ones_own(petzval_cli, tmp_path):
    file = tmp_path / "mine.agf"
    file.write_text(AGF)
    found = told(petzval_cli, "N-BK7", "--catalogue", file, "--wavelength", "400", "587.5618", "--thickness", "10")
    # Bouguer's law from 25 mm to 10.
    assert found["indices"][0]["transmittance"] == pytest.approx(math.pow(0.992, 10 / 25), rel=1e-9)
    assert found["indices"][1]["index"] == pytest.approx(told(petzval_cli, "N-BK7")["nd"], abs=1e-12)
    out = tmp_path / "glass.svg"
    done = petzval_cli("glass", "N-BK7", "--catalogue", file, "-o", out)
    assert done.returncode == 0, done.stderr
    text = out.read_text()
    assert ElementTree.fromstring(text).tag.endswith("svg") and "let through by 10 mm" in text and "N-BK7" in text


def test_errors_are_one_line_that_helps(petzval_cli, tmp_path):
    file = tmp_path / "broken.agf"
    file.write_text("NM X 2 1 1.5\nCD one two\n")
    for more, words in (
        (["N-BK8"], "did you mean N-BK7"),
        (["X", "--catalogue", file], f"{file}:2:4"),
        (["X", "--catalogue", tmp_path / "none.agf"], "none.agf"),
        (["N-BK7", "--wavelength", "5"], "wavelength 5 nm"),
        (["N-BK7", "--thickness", "0"], "give more than 0"),
    ):
        done = petzval_cli("glass", *more)
        assert done.returncode == 1 and done.stderr.count("\n") == 1 and words in done.stderr, done.stderr
    assert petzval_cli("glass").returncode == 2 and petzval_cli("glass", "F2", "--list").returncode == 2
