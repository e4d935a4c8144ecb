# SPDX-License-Identifier: GPL-3.0-or-later
"""The wheel by itself, installed where the checkout cannot be seen."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="session")
def wheel() -> Path:
    found = sorted((ROOT / "dist").glob("petzval-*.whl"))
    if not found:
        pytest.skip("no wheel in dist/: run make build")
    return found[-1]


@pytest.fixture(scope="session")
def run_installed(wheel, tmp_path_factory):
    """Runs Python with the wheel installed in a folder of its own, which comes before everything else."""
    folder = tmp_path_factory.mktemp("installed")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder)

    def run(*arguments) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, *map(str, arguments)],
            env={**os.environ, "PYTHONPATH": str(folder)},
            cwd=folder,
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )

    run.folder = folder
    return run


def test_the_installed_command_finds_its_lenses(run_installed):
    done = run_installed("-m", "petzval", "lens", "info", "wide-angle-smith-f3.4")
    assert done.returncode == 0, done.stderr
    where = run_installed("-c", "import petzval; print(petzval.lenses_folder())")
    assert Path(where.stdout.strip()).is_relative_to(run_installed.folder)


def test_the_installed_addon_registers_in_blender(run_installed):
    # bpy ends by itself badly while an engine is registered: see conftest.py.
    program = (
        "import bpy, os, petzval\n"
        "addon = petzval.load_addon()\n"
        "addon.register()\n"
        "print('from', addon.__file__, flush=True)\n"
        "addon.unregister()\n"
        "os._exit(0)\n"
    )
    done = run_installed("-c", program)
    assert done.returncode == 0, done.stderr
    where = done.stdout.split("from ", 1)[1].strip()
    assert Path(where).is_relative_to(run_installed.folder)


@pytest.mark.once
def test_the_wheel_holds_what_it_must_and_no_more(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    shipped = {
        f"petzval/_bundled/lenses/{path.relative_to(ROOT / 'lenses')}" for path in (ROOT / "lenses").rglob("*.*")
    }
    addon = {f"petzval/_bundled/addon/{path.relative_to(ROOT / 'addon')}" for path in (ROOT / "addon").rglob("*.py")}
    assert shipped | addon | {"petzval/_native.abi3.so", "petzval/cli.py"} <= names
    assert not [name for name in names if "__pycache__" in name or "sbom" in name]


@pytest.mark.once
@pytest.mark.skipif(sys.platform != "linux", reason="manylinux is of Linux")
def test_the_wheel_is_for_every_linux_that_blender_is_for(wheel):
    assert wheel.name.endswith("-cp311-abi3-manylinux_2_28_x86_64.whl") or os.uname().machine != "x86_64"
