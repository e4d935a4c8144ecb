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
DESCRIPTIONS = ROOT / "engine/python/petzval/description.py"
#: The struct of each dataclass, and its file in engine/.
READERS = {
    "LensSettings": ("LensSettings", "optics/src/system.rs"),
    "Focusing": ("Focusing", "optics/src/focus/scale.rs"),
    "ApertureMask": ("GreyPicture", "optics/src/diaphragm/mask.rs"),
    "LensReportSettings": ("ReportSettings", "render/src/reports/mod.rs"),
    "Perspective": ("Perspective", "render/src/camera/description.rs"),
    "FocusSettings": ("FocusSettings", "render/src/camera/description.rs"),
    "Panorama": ("Panorama", "render/src/projection.rs"),
    "CalibrationSettings": ("CalibrationSettings", "render/src/camera/description.rs"),
    "SphericalStereo": ("SphericalStereo", "render/src/camera/stereo.rs"),
    "FilmSettings": ("FilmSettings", "render/src/camera/description.rs"),
    "CameraDescription": ("CameraDescription", "render/src/camera/description.rs"),
    "Scattering": ("Scattering", "render/src/camera/scattering.rs"),
    "PhysicalExposure": ("PhysicalExposure", "render/src/camera/exposure.rs"),
    "Caustics": ("Caustics", "render/src/shading/mod.rs"),
    "KindLimits": ("KindLimits", "render/src/integrator/path.rs"),
    "Approximations": ("Approximations", "render/src/integrator/path/approximations.rs"),
    "SettingsDescription": ("Settings", "render/src/job/settings.rs"),
    "BakeDescription": ("BakeSettings", "render/src/job/bake.rs"),
    "DenoisingDescription": ("Denoising", "render/src/job/denoise.rs"),
    "ShutterDescription": ("Shutter", "render/src/camera/shutter.rs"),
    "MaterialDescription": ("PyMaterial", "python/src/material.rs"),
    "LightDescription": ("PyLight", "python/src/material.rs"),
    "WorldDescription": ("PyWorld", "python/src/material.rs"),
}


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


def test_every_description_is_compared():
    assert READERS.keys() == {name for name, node in classes(DESCRIPTIONS).items() if node.decorator_list}


@pytest.mark.parametrize("name", READERS)
def test_a_description_has_one_list_of_fields(name):
    declared = [node.target.id for node in classes(DESCRIPTIONS)[name].body if isinstance(node, ast.AnnAssign)]
    struct, file = READERS[name]
    source = (ROOT / "engine" / file).read_text(encoding="utf-8")
    (body,) = re.findall(rf"struct {struct} \{{(.*?)\n\}}", source, re.DOTALL)
    # What a plan decides does not come from Python.
    body = re.sub(r"#\[serde\(skip\)\]\s*pub(?:\(\w+\))? \w+:", "", body)
    read = re.findall(r"^    (?:pub(?:\(crate\))? )?(\w+):", body, re.MULTILINE)
    assert sorted(read) == sorted(declared)
