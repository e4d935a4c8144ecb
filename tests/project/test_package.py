# SPDX-License-Identifier: GPL-3.0-or-later
"""The wheel by itself, installed where the checkout cannot be seen."""

from __future__ import annotations

import base64
import csv
import hashlib
import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from petzval.processors import LEVELS, choose, flags_of_this_processor
from support.command_line import assert_complains
from support.places import ROOT, SCENES
from support.render_commands import picture

DEMO = SCENES / "demo.blend"
LENS = ROOT / "lenses/wide-angle-smith-f3.4.lens"

# The development build, and release wheels of other machines, hold one engine, beside the package's own files.
STAMP = ROOT / "dist/.petzval-wheel"
IS_RELEASE = STAMP.exists() and STAMP.read_text().split()[0] == "release"
SEVERAL_ENGINES = IS_RELEASE and (sys.platform, os.uname().machine) == ("linux", "x86_64")
several_engines = pytest.mark.skipif(
    not SEVERAL_ENGINES, reason="the wheel in dist/ has one engine: run make wheels, or make test-all"
)


@pytest.fixture(scope="session")
def wheel() -> Path:
    """This machine's: those of others may lie beside it."""
    if not STAMP.exists() or not (found := ROOT / "dist" / STAMP.read_text().split()[1]).exists():
        pytest.skip("no wheel in dist/: run make build")
    return found


@pytest.fixture(scope="session")
def run_installed(wheel, tmp_path_factory):
    """Runs Python with the wheel installed in a folder of its own, which comes before everything else."""
    folder = tmp_path_factory.mktemp("installed")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder)

    def run(*arguments, **environment) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, *map(str, arguments)],
            env={**os.environ, "PYTHONPATH": str(folder), **environment},
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
    assert shipped | addon | {"petzval/_native.py", "petzval/_native.pyi", "petzval/cli.py"} <= names
    assert not [name for name in names if "__pycache__" in name or "sbom" in name]


@pytest.mark.once
def test_the_wheel_carries_the_licences_of_what_it_is_linked_from(wheel):
    with zipfile.ZipFile(wheel) as archive:
        text = archive.read("petzval/_bundled/THIRD-PARTY-NOTICES.txt").decode()
    # MIT and BSD ask for their notices.
    assert (
        "Redistributions in binary form must reproduce the above copyright" in text and text.count("\nMIT License") > 0
    )


@pytest.mark.once
@pytest.mark.skipif(not IS_RELEASE, reason="a release wheel: make wheels, or make test-all")
def test_the_wheel_names_no_folder_of_the_machine_that_built_it(wheel):
    folders = [str(ROOT), str(Path.home()), "/.cargo/registry"]
    with zipfile.ZipFile(wheel) as archive:
        for name in archive.namelist():
            if name.endswith(".so"):
                data = archive.read(name)
                assert [folder for folder in folders if folder.encode() in data] == [], name


@pytest.mark.once
def test_the_wheel_holds_an_engine_for_each_level(wheel):
    with zipfile.ZipFile(wheel) as archive:
        modules = {name for name in archive.namelist() if name.endswith(".so")}
        assert len({archive.getinfo(name).CRC for name in modules}) == len(modules)
    # One beside the package's own files is loaded before the processor is asked, so then there is no other.
    beside = "petzval/_native.abi3.so"
    if SEVERAL_ENGINES:
        assert {f"petzval/_engines/x86-64-{level}/_native.abi3.so" for level in ("v2", "v3")} <= modules
        assert beside not in modules
        assert {Path(name).parent.name for name in modules} <= set(LEVELS)
    else:
        assert modules == {beside}


@pytest.mark.once
def test_the_record_names_every_file(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        (record,) = (name for name in names if name.endswith(".dist-info/RECORD"))
        rows = {name: (digest, size) for name, digest, size in csv.reader(archive.read(record).decode().splitlines())}
        assert sorted(rows) == sorted(names)
        assert rows.pop(record) == ("", "")
        for name, (digest, size) in rows.items():
            data = archive.read(name)
            right = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            assert (digest, size) == (f"sha256={right}", str(len(data))), name


@pytest.mark.once
def test_the_engine_is_one_module_under_one_name(run_installed):
    program = (
        "import sys, petzval\n"
        "assert not {'petzval._native', 'numpy', 'bpy'} & set(sys.modules), 'loaded too early'\n"
        "import petzval._native\n"
        "from petzval import _native\n"
        "assert petzval._native is _native is sys.modules['petzval._native']\n"
        "print(_native.__name__, _native.__spec__.name, _native.PROCESSOR, _native.__file__)\n"
    )
    done = run_installed("-c", program)
    assert done.returncode == 0, done.stderr
    name, spec_name, processor, file = done.stdout.split(maxsplit=3)
    assert (name, spec_name) == ("petzval._native", "petzval._native")
    assert Path(file.strip()).is_relative_to(run_installed.folder)
    version = run_installed("-m", "petzval", "--version")
    assert version.stdout.endswith(f", engine for {processor}\n")


@pytest.mark.once
@several_engines
def test_every_engine_draws_the_same_picture(wheel, run_installed, tmp_path):
    pytest.importorskip("bpy")
    with zipfile.ZipFile(wheel) as archive:
        levels = sorted(Path(name).parent.name for name in archive.namelist() if name.endswith(".so"))
    best = choose(levels, flags_of_this_processor())
    pictures = {}
    for level in levels[: levels.index(best) + 1]:
        out, stats = tmp_path / f"{level}.exr", tmp_path / f"{level}.json"
        done = run_installed(
            "-m", "petzval", "render", DEMO, "--lens", LENS, "--resolution", "48x27", "--samples", "4", "-o", out,
            "--stats", stats, PETZVAL_PROCESSOR=level,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        assert json.loads(stats.read_text())["processor"] == level
        pictures[level] = picture(out)
    first = pictures[levels[0]]
    assert first.max() > 0.0
    for level, other in pictures.items():
        # Products are fused from v3 on: last digits differ, and now and then a path that turns on one of them.
        apart = abs(other - first).max(axis=-1) > 1e-3 * (first.max(axis=-1) + 1e-3)
        assert apart.mean() < 0.05, f"{level}: {apart.mean():.1%} of the pixels differ from {levels[0]}'s"
        assert abs(other.mean() / first.mean() - 1.0) < 0.01, level


@pytest.mark.once
@several_engines
@pytest.mark.parametrize("command", [["--version"], ["lens", "info", "tessar-brendel"]])
def test_an_unknown_processor_is_named(run_installed, command):
    done = run_installed("-m", "petzval", *command, PETZVAL_PROCESSOR="v9")
    assert_complains(done, "PETZVAL_PROCESSOR is 'v9'", "x86-64-v2", "x86-64-v3", "unset it")


@pytest.mark.once
@several_engines
def test_blender_too_is_told_of_an_unknown_processor(run_installed, tmp_path):
    pytest.importorskip("bpy")
    program = (
        "import os, petzval\n"
        "print(petzval.load_addon().native.missing(), flush=True)\n"
        "os._exit(0)\n"
    )  # fmt: skip
    done = run_installed("-c", program, PETZVAL_PROCESSOR="v9")
    assert "engine cannot be loaded: PETZVAL_PROCESSOR is 'v9'" in done.stdout, done.stderr


@pytest.mark.once
@pytest.mark.skipif(
    not IS_RELEASE or sys.platform != "linux", reason="a release wheel of Linux: make wheels, or make test-all"
)
def test_the_wheel_is_for_every_linux_that_blender_is_for(wheel):
    assert wheel.name.endswith("-cp311-abi3-manylinux_2_28_x86_64.whl") or os.uname().machine != "x86_64"
