# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval lens prove`: certificates, and the checker, which must refuse false ones."""

import copy
import json
from pathlib import Path

import pytest

from petzval.proof_check.check import CheckError, check, partition_hash

pytestmark = pytest.mark.once
ROOT = Path(__file__).resolve().parents[2]
LENS = "biconvex-50mm"
FILE = ROOT / "lenses" / f"{LENS}.lens"
ZONE, FROM, TO, FATE, SURFACE = range(5)


@pytest.fixture(scope="module")
def certificate(petzval_cli, tmp_path_factory):
    out = tmp_path_factory.mktemp("proof") / "certificate.json"
    done = petzval_cli("lens", "prove", LENS, "--undecided", "0.1", "--film-radius", "10", "-o", out)
    assert done.returncode == 0, done.stderr
    assert "undecided" in done.stdout
    done = petzval_cli("lens", "prove", FILE, "--check", out)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("ok: ")
    return json.loads(out.read_text())


def changed(certificate, change):
    """A certificate with something changed and its hash made right again."""
    false = copy.deepcopy(certificate)
    change(false)
    false["partition_sha256"] = partition_hash(false["columns"])
    return false


def cells(certificate, fate):
    return [cell for column in certificate["columns"] for cell in column[4] if cell[FATE] == fate]


def test_a_certificate_is_confirmed(certificate):
    done = check(certificate, FILE, None)
    assert done.undecided == pytest.approx(certificate["undecided"], rel=1e-3)
    assert done.undecided <= 0.1
    assert done.followed == len(cells(certificate, "passes")) + len(cells(certificate, "stopped")) > 100
    # Its own enclosures are others, and now and then wider.
    assert done.unconfirmed < 0.05 * done.followed
    total = certificate["passes"] + certificate["stopped"] + certificate["undecided"]
    assert total == pytest.approx(1.0, abs=1e-3)


def test_a_change_without_its_hash_is_seen(certificate):
    false = copy.deepcopy(certificate)
    false["columns"][0][4][0][TO] += 1e-9
    with pytest.raises(CheckError, match="changed"):
        check(false, None, 10)


def test_another_lens_file_is_seen(certificate):
    with pytest.raises(CheckError, match="hash is another"):
        check(certificate, ROOT / "lenses/ball-lens-10mm.lens", 10)


@pytest.mark.parametrize(
    ("change", "what"),
    [
        (lambda c: c["columns"].pop(), "gap"),
        (lambda c: c["columns"].append(c["columns"][0]), "lie on each other"),
        (lambda c: c["columns"][0][4].pop(), "end before the rim"),
        (lambda c: c["columns"][0][4].pop(0), "gap"),
        (lambda c: c["centres"][0].__setitem__(0, 1e3), "outside of the disc"),
        (lambda c: c.update(undecided=0.5 * c["undecided"]), "undecided"),
    ],
)
def test_a_false_partition_is_seen(certificate, change, what):
    with pytest.raises(CheckError, match=what):
        check(changed(certificate, change), None, 10)


def test_a_false_fate_is_contradicted(certificate):
    def lie(false):
        cells(false, "stopped")[0][FATE] = "passes"

    with pytest.raises(CheckError, match="the contrary is proved"):
        check(changed(certificate, lie), None, None)

    def lie_darkly(false):
        cells(false, "passes")[0][FATE : SURFACE + 1] = ["stopped", 0]

    with pytest.raises(CheckError, match="the contrary is proved"):
        check(changed(certificate, lie_darkly), None, None)


def test_a_wrong_rim_is_contradicted(certificate):
    def close(false):
        for surface in false["surfaces"]:
            surface["clear_squared_mm2"] *= 0.8

    with pytest.raises(CheckError, match="the contrary is proved"):
        check(changed(certificate, close), None, None)
    with pytest.raises(CheckError, match="radius or diameter"):
        check(changed(certificate, close), FILE, 10)


def test_what_is_not_covered_is_named(petzval_cli):
    done = petzval_cli("lens", "prove", "anamorphic-2x-double-gauss")
    assert done.returncode == 1
    assert "not covered" in done.stderr
    assert "toroid" in done.stderr
