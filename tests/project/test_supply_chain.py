# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts that Petzval is built from: licences, sources, known vulnerabilities, hashes."""

from __future__ import annotations

import re
import shutil

import pytest
import supply

pytestmark = pytest.mark.once


@pytest.fixture(scope="module")
def crates() -> list[supply.Crate]:
    if shutil.which("cargo") is None:
        pytest.skip("no cargo")
    return supply.linked_crates()


def test_every_linked_crate_may_be_linked(crates):
    assert len(crates) > 30
    assert [f"{one.name}: {one.licence}" for one in crates if not supply.is_compatible(one.licence)] == []


def test_notices_name_every_linked_crate(crates):
    text = supply.notices()
    assert [one.name for one in crates if f"\n{one.name} {one.version}: " not in text] == []
    # A licence that asks for its text has it.
    assert "Redistributions in binary form must reproduce the above copyright" in text
    silent = {one.name for one in crates if not one.texts()}
    assert silent <= {"pulp-wasm-simd-flag", "sobol_burley", "zune-inflate"}, "their packages hold no text"


def test_every_crate_is_of_the_registry_and_has_a_checksum():
    for (name, version), one in supply.locked_crates().items():
        assert one["source"].startswith("registry+") and len(one.get("checksum", "")) == 64, f"{name} {version}"


def test_nothing_that_is_locked_is_known_to_be_vulnerable():
    assert supply.vulnerable() == []
    assert supply.not_looked_up() == [], "PYTHONPATH=tools python3 -m supply advisories RUSTSEC PYPA"


def test_a_vulnerable_version_is_found(monkeypatch):
    locked = {("pyo3", "0.28.0"): {}, ("paste", "1.0.15"): {}, ("rand", "0.9.1"): {}}
    monkeypatch.setattr(supply, "locked_crates", lambda: locked)
    monkeypatch.setattr(supply, "pinned_packages", lambda: {("pillow", "9.0.0"): []})
    found = supply.vulnerable()
    assert any("pyo3 0.28.0" in one for one in found) and any("rand 0.9.1" in one for one in found)
    assert any("pillow 9.0.0" in one for one in found) and not any("paste" in one for one in found)


@pytest.mark.parametrize(
    ("version", "requirement", "holds"),
    [
        ("1.2.3", ">= 1.2, < 2", True), ("2.0.0", ">= 1.2, < 2", False), ("0.4.9", "^0.4.5", True), ("0.5.0", "^0.4.5", False),
        ("1.9.0", "^1.2", True), ("1.0.0-rc.1", ">= 1.0.0", False), ("1.0.0", "1.0.0", True),
    ],
)  # fmt: skip
def test_requirements_are_read(version, requirement, holds):
    assert supply.satisfies(version, requirement) == holds


@pytest.mark.parametrize(
    ("licence", "holds"),
    [
        ("MIT OR Apache-2.0", True), ("MIT/Apache-2.0", True), ("(MIT OR Apache-2.0) AND Unicode-3.0", True), ("GPL-2.0-only", False),
        ("MIT AND SSPL-1.0", False), ("(MIT OR SSPL-1.0) AND SSPL-1.0", False), ("", False), ("SSPL-1.0 OR Zlib", True),
    ],
)  # fmt: skip
def test_licence_expressions_are_read(licence, holds):
    assert supply.is_compatible(licence) == holds


def test_every_python_package_has_hashes():
    by_hand = {path.stem for path in supply.REQUIREMENTS.glob("*.txt")} - {"tests"}
    assert {path.stem for path in (supply.REQUIREMENTS / "locked").glob("*.txt")} == by_hand
    for path in (supply.REQUIREMENTS / "locked").glob("*.txt"):
        rows = [line for line in path.read_text().splitlines() if not line.startswith("#")]
        assert rows and all(re.fullmatch(r"\S+==\S+( --hash=sha256:[0-9a-f]{64})+", row) for row in rows), path
        # What is pinned by hand is what is locked.
        files = [supply.REQUIREMENTS / path.name]
        files += [supply.REQUIREMENTS / "tests.txt"] if path.stem.startswith("bpy") else []
        pins = {pin for file in files for pin in re.findall(r"^([\w-]+==[\w.]+)", file.read_text(), re.MULTILINE)}
        assert pins <= {row.split()[0] for row in rows}, path
