# SPDX-License-Identifier: GPL-3.0-or-later
"""The package is typed, its stub says what the compiled module has, and what crosses from Python to Rust has one list of fields."""

from __future__ import annotations

import ast
import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from support.places import ROOT

pytestmark = pytest.mark.once

STUB = ROOT / "engine/python/petzval/_native.pyi"
DESCRIPTIONS = ROOT / "addon/description.py"
#: By dataclass: the struct that reads it by attribute.
READERS = {
    "ApertureMask": "PyApertureMask",
    "CameraDescription": "PyCamera",
    "SettingsDescription": "PySettings",
    "ShutterDescription": "PyShutter",
    "MaterialDescription": "PyMaterial",
    "LightDescription": "PyLight",
    "WorldDescription": "PyWorld",
}
#: Fields that the add-on resolves before the engine reads the rest.
RESOLVED = {"CameraDescription": {"autofocus"}}


def checked(module: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    if importlib.util.find_spec("mypy") is None:
        pytest.skip("no mypy in this environment")
    paths = {"MYPYPATH": str(STUB.parent.parent), "PYTHONPATH": str(STUB.parent.parent)}
    command = [sys.executable, "-m", module, *arguments]
    return subprocess.run(command, cwd=ROOT, env=os.environ | paths, capture_output=True, text=True, check=False)


def test_the_package_is_typed():
    done = checked("mypy")
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_stub_is_the_compiled_module():
    done = checked("mypy.stubtest", "petzval._native", "--concise")
    assert done.returncode == 0, done.stdout + done.stderr


def classes(path: Path) -> dict[str, ast.ClassDef]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}


def fields(described: ast.ClassDef) -> dict[str, str]:
    """The types of a class's fields or properties, by name."""
    found = {}
    for node in described.body:
        if isinstance(node, ast.AnnAssign):
            found[node.target.id] = ast.unparse(node.annotation)
        elif isinstance(node, ast.FunctionDef):
            found[node.name] = ast.unparse(node.returns)
    # A protocol may ask for less than what it gets, and names no private type as the dataclass does.
    return {name: re.sub(r"\b_|\bSequence\b|\blist\b", "", kind) for name, kind in found.items()}


@pytest.mark.parametrize("name", READERS)
def test_a_description_has_one_list_of_fields(name):
    told = fields(classes(DESCRIPTIONS)[name])
    stub = fields(classes(STUB)[name])
    assert told == stub
    sources = "\n".join(path.read_text(encoding="utf-8") for path in (ROOT / "engine/python/src").glob("*.rs"))
    (body,) = re.findall(rf"struct {READERS[name]} \{{(.*?)\n\}}", sources, re.DOTALL)
    read = set(re.findall(r"^    (?:pub\(crate\) )?(\w+):", body, re.MULTILINE))
    assert read == told.keys() - RESOLVED.get(name, set())
