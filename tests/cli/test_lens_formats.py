# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval lens` with lens files of other programs: any is read, .lens and .zmx are written, and what is lost is said."""

from __future__ import annotations

import json

import pytest

from support.command_line import GOOD_LENS, answer, assert_complains
from support.places import REFERENCE

pytestmark = pytest.mark.once

FOREIGN = REFERENCE / "foreign"
#: Focal lengths of rayoptics and optiland at the files' own wavelengths (figures.json, tools/foreign-figures.py).
FIGURES = json.loads((FOREIGN / "figures.json").read_text())
FILES = ["ag_dblgauss.seq", "questar35.seq", "planar-1897.zmx", "cooke.len"]
MM = {"questar35.seq": 25.4}


def first_order(info):
    return {key: value for key, value in info.items() if key not in ("notes", "name")}


@pytest.mark.parametrize("name", FILES)
def test_info_is_what_other_packages_say(petzval_cli, name):
    figures = FIGURES[name].get("rayoptics") or FIGURES[name]["optiland"]
    info = answer(petzval_cli("lens", "info", FOREIGN / name, "--wavelength", str(figures["wavelength_nm"]), "--json"))
    # Their catalogues print six or seven digits of an index.
    assert abs(info["efl_mm"]) == pytest.approx(abs(figures["efl"]) * MM.get(name, 1.0), rel=2e-5)


@pytest.mark.parametrize("name", [*FILES, "canon-11-24.txt"])
@pytest.mark.parametrize("kind", ["lens", "zmx"])
def test_a_converted_lens_is_the_same(petzval_cli, tmp_path, name, kind):
    out = tmp_path / f"out.{kind}"
    done = petzval_cli("lens", "convert", FOREIGN / name, out)
    assert done.returncode == 0, done.stderr
    assert all(line.startswith("petzval: note: ") for line in done.stderr.splitlines())
    before = answer(petzval_cli("lens", "info", FOREIGN / name, "--json"))
    after = answer(petzval_cli("lens", "info", out, "--json"))
    assert first_order(after) == first_order(before)
    assert "notes" not in after, "what was left out of the first file is not in the second"


def test_what_a_file_does_not_say_is_noted(petzval_cli, tmp_path):
    zmx = tmp_path / "a.zmx"
    zmx.write_text((FOREIGN / "planar-1897.zmx").read_text().replace("SURF 3", "SURF 3\n  COAT AR\n  QTYP 1", 1))
    done = petzval_cli("lens", "check", zmx)
    assert (done.returncode, done.stdout) == (0, "ok: Original Double Gauss, 11 surfaces\n")
    assert any("coatings are left out" in line for line in done.stderr.splitlines())
    assert any("'QTYP' is not understood" in line for line in done.stderr.splitlines())
    info = answer(petzval_cli("lens", "info", zmx, "--json"))
    assert [note for note in info["notes"] if "coatings" in note]


def test_a_glass_beyond_its_range_is_named(petzval_cli, tmp_path):
    lens = tmp_path / "a.lens"
    lens.write_text("60 6 robb1983:BAF5 30 0 1\n-60 50 air 30 0 0\n")
    info = answer(petzval_cli("lens", "info", lens, "--wavelength", "1000", "--json"))
    edge = answer(petzval_cli("lens", "info", lens, "--wavelength", "2000", "--json"))
    assert "BAF5" in info["notes"][0]
    assert info["efl_mm"] == edge["efl_mm"], "beyond its range the index stands still"
    assert "notes" not in answer(petzval_cli("lens", "info", lens, "--json"))


def test_what_cannot_be_written_is_refused(petzval_cli, tmp_path):
    good = tmp_path / "good.lens"
    good.write_text(GOOD_LENS)
    assert_complains(
        petzval_cli("lens", "convert", good, tmp_path / "out.seq"), "lenses cannot be written as .seq", ".zmx"
    )
    assert_complains(
        petzval_cli("lens", "convert", good, tmp_path / "none" / "out.zmx"), "cannot write", "choose another place"
    )
    assert_complains(petzval_cli("lens", "convert", tmp_path / "none.zmx", tmp_path / "out.lens"), "no such lens")


def test_hostile_files_get_one_line(petzval_cli, tmp_path):
    for name, content, word in [
        ("a.zmx", b"SURF 0\n  CURV nan\n", "not a finite number"),
        ("b.zmx", b"\xff\xfeM\x00O", "neither UTF-8 nor UTF-16"),
        ("c.seq", b"\x00\x01\x02\x03\x04", "not text"),
        ("d.len", b"(" * 1000000, "no line END"),
    ]:
        path = tmp_path / name
        path.write_bytes(content)
        assert_complains(petzval_cli("lens", "info", path), name, word)
    # A gigabyte of one line, in a file that takes no room.
    for name in ("long.zmx", "long.lens"):
        path = tmp_path / name
        with path.open("wb") as file:
            file.truncate(1 << 30)
        assert_complains(petzval_cli("lens", "check", path), name, "longer than")
