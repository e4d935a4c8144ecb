# SPDX-License-Identifier: GPL-3.0-or-later
"""Wheels and extensions for every system: what their files ask of it, as far as a machine without it can tell."""

from __future__ import annotations

import base64
import csv
import hashlib
import io
import os
import shutil
import subprocess
import tomllib
import zipfile
from pathlib import Path

import platforms
import pytest
import supply
from platforms import binaries, building, checking

from petzval import processors
from support.places import ROOT

pytestmark = pytest.mark.once

ZIG = ROOT / ".venv-wheels/bin/python"
WHEELS = sorted((ROOT / "dist").glob("petzval-*.whl"))
EXTENSIONS = sorted((ROOT / "dist").glob("petzval-*.zip"))


# Reading modules -------------------------------------------------------------------------------------------------


def own_module() -> Path:
    package = ROOT / "engine/python/petzval"
    found = [*package.glob("_native.abi3.so"), *processors.engines().values()]
    if not found:
        pytest.skip("no compiled module: run make build")
    return found[0]


@pytest.mark.skipif(
    platforms.host() not in {one.triple for one in platforms.PLATFORMS.values() if one.system == "linux"},
    reason="Linux",
)
def test_the_own_module_is_read():
    module = binaries.read(own_module().read_bytes())
    assert module.system == "linux" and module.machine == {"x86_64": "x64", "aarch64": "arm64"}[os.uname().machine]
    assert "libc.so.6" in module.libraries and "PyInit__native" in module.exports
    assert "PyErr_SetObject" in module.imports or any(name.startswith("Py") for name in module.imports)
    assert (2, 17) <= module.oldest < (3, 0)


def launchers() -> dict[str, bytes]:
    """Windows programs that pip brings along, by their machine."""
    import pip

    folder = Path(pip.__file__).parent / "_vendor/distlib"
    files = {"x64": folder / "t64.exe", "arm64": folder / "t64-arm.exe"}
    if not all(file.exists() for file in files.values()):
        pytest.skip("this pip has no launchers for Windows")
    return {name: file.read_bytes() for name, file in files.items()}


@pytest.mark.parametrize("machine", ["x64", "arm64"])
def test_a_windows_program_is_read(machine):
    module = binaries.read(launchers()[machine])
    assert (module.system, module.machine) == ("windows", machine)
    assert "kernel32.dll" in module.libraries and "GetModuleFileNameW" in module.imports and module.exports == set()
    assert (4, 0) <= module.oldest <= (10, 0)


SOURCE = (
    "int PyNumber_Long(int); int PyInit__native(int x) { return PyNumber_Long(x); } int other(int x) { return x; }\n"
)
FLAGS = {"linux": ["-fPIC", "-shared"], "macos": ["-shared", "-Wl,-undefined,dynamic_lookup"]}


@pytest.fixture(scope="module", params=["linux-arm64", "macos-arm64", "macos-x64"])
def made(request, tmp_path_factory):
    """A small module for a platform, by zig; and the platform."""
    if not ZIG.exists() or subprocess.run([ZIG, "-c", "import ziglang"], capture_output=True, check=False).returncode:
        pytest.skip("no zig: run make wheels, or tools/setup-python.sh wheels")
    one, folder = platforms.PLATFORMS[request.param], tmp_path_factory.mktemp("made")
    (folder / "module.c").write_text(SOURCE)
    command = [ZIG, "-m", "ziglang", "cc", "-target", one.zig, *FLAGS[one.system], "module.c", "-o", "module.so"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return one, (folder / "module.so").read_bytes()


def test_a_module_of_another_system_is_read(made):
    one, data = made
    module = binaries.read(data)
    assert (module.system, module.machine) == (one.system, one.machine)
    assert {"PyInit__native", "other"} <= module.exports and "PyNumber_Long" in module.imports - module.exports
    assert checking.of_module("module", data, one) == []
    if one.system == "macos":
        assert module.oldest == (11, 0) and module.libraries == ["/usr/lib/libSystem.B.dylib"]


def test_what_is_wrong_with_a_module_is_named(made):
    one, data = made
    other = platforms.PLATFORMS["linux-x64" if one.name != "linux-x64" else "linux-arm64"]
    assert any(f"it is for {one.name}" in line for line in checking.of_module("m", data, other))
    wrong = checking.of_module("m", data.replace(b"PyInit__native", b"PyInit__notive"), one)
    assert any("it is no module of Python" in line for line in wrong)
    if one.system == "macos":
        strange = data.replace(b"/usr/lib/libSystem.B", b"/opt/lib/libSystem.B")
        assert any("it asks for /opt/lib/libSystem.B.dylib" in line for line in checking.of_module("m", strange, one))
    if one.name == "macos-arm64":
        assert binaries.read(data).is_signed
        changed = data.replace(b"PyNumber_Long", b"PyNumber_Lone")
        assert any("signature" in line for line in checking.of_module("m", changed, one))


def test_a_newer_system_is_named(monkeypatch):
    one = platforms.PLATFORMS["windows-x64"]
    module = binaries.Module(
        "windows", "x64", ["kernel32.dll", "libgcc_s_seh-1.dll"], (10, 0), set(), {"PyInit__native"}
    )
    monkeypatch.setattr(binaries, "read", lambda data: module)
    assert checking.of_module("m", b"", one) == [
        "m: it asks for libgcc_s_seh-1.dll",
        "m: it asks for 10.0, and Blender for 6.3",
        "m: it is not of Python's stable interface",
    ]


@pytest.mark.parametrize(
    "data", [b"", b"\x7fELF", b"MZ" + bytes(80), b"\xcf\xfa\xed\xfe" + bytes(40), b"#!/bin/sh\n", bytes(500)]
)
def test_what_is_no_module_is_named(data):
    with pytest.raises(binaries.BinaryError, match="module"):
        binaries.read(data)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["windows-x64", "windows-arm64", "macos-x64", "macos-arm64"])
def test_a_linked_library_hands_out_what_is_listed_alone(tmp_path, name):
    if not ZIG.exists() or shutil.which("rustc") is None:
        pytest.skip("no zig, or no Rust: run make wheels")
    one = platforms.PLATFORMS[name]
    (tmp_path / "module.c").write_text(
        SOURCE if one.system == "macos" else "int PyInit__native(int x) { return x; } int other(int x) { return x; }\n"
    )
    compiled = ["-m", "ziglang", "cc", "-target", one.zig, "-c", "module.c", "-o", "module.o"]
    subprocess.run([ZIG, *compiled], cwd=tmp_path, check=True, capture_output=True)
    # As rustc has them.
    if one.system == "windows":
        (tmp_path / "list.def").write_text('EXPORTS\n    "PyInit__native"\n')
        words = [f"-Wl,{tmp_path}/list.def", "module.o", "-shared"]
    else:
        (tmp_path / "list").write_text("_PyInit__native\n")
        words = ["-Wl,-exported_symbols_list", f"-Wl,{tmp_path}/list", "module.o", "-lSystem", "-lc", "-lm", "-liconv", "-arch",
                 {"x64": "x86_64", "arm64": "arm64"}[one.machine], "-mmacosx-version-min=11.0.0", "-Wl,-dead_strip", "-dynamiclib",
                 "-nodefaultlibs", "-undefined", "dynamic_lookup", "-Wl,-install_name,@rpath/a.so"]  # fmt: skip
    environment = os.environ | {"PETZVAL_ZIG_TARGET": one.zig}
    command = [ROOT / "tools/zig-linker.sh", *words, "-o", "out"]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    module = binaries.read((tmp_path / "out").read_bytes())
    assert module.exports == {"PyInit__native"} and (module.system, module.machine) == (one.system, one.machine)
    if one.system == "macos":
        assert module.libraries == ["/usr/lib/libSystem.B.dylib"] and module.oldest == (11, 0)
        assert "PyNumber_Long" in module.imports and module.is_signed == (one.machine == "arm64")


def test_what_a_mac_has_not_is_named(tmp_path, monkeypatch):
    if not ZIG.exists():
        pytest.skip("no zig: run make wheels")
    with zipfile.ZipFile(tmp_path / "a.whl", "w") as archive:
        archive.writestr("petzval/_native.abi3.so", "")
    module = binaries.Module("macos", "arm64", imports={"PyLong_Type", "memcpy", "no_such_function"})
    monkeypatch.setattr(binaries, "read", lambda data: module)
    assert building._unknown_of_mac(tmp_path / "a.whl") == ["petzval/_native.abi3.so: no_such_function: of no library"]


# Wheels and extensions -------------------------------------------------------------------------------------------


def test_every_wheel_in_dist_is_right():
    """A development build of this machine has its own C library, and one engine."""
    release = [file for file in WHEELS if not is_development(file.name)]
    if not release:
        pytest.skip("no release wheel in dist/: make wheels-all")
    assert [line for file in release for line in checking.of_wheel(file, file.name)] == []


def test_every_extension_in_dist_is_right():
    release = [file for file in EXTENSIONS if not is_development(wheel_of(file))]
    if not release:
        pytest.skip("no extension of a release wheel in dist/: make extensions-all")
    assert [line for file in release for line in checking.of_extension(file)] == []


def is_development(wheel: str) -> bool:
    """True of a wheel that asks for the C library of the Linux on which it was made."""
    return "linux" in wheel and "manylinux_2_28" not in wheel


def wheel_of(extension: Path) -> str:
    with zipfile.ZipFile(extension) as archive:
        return tomllib.loads(archive.read("blender_manifest.toml").decode())["wheels"][0]


def test_modules_of_all_systems_ask_python_for_the_same():
    """The functions of the stable interface, which on Windows a library of its own has."""
    asked = {}
    for file in WHEELS:
        with zipfile.ZipFile(file) as archive:
            for name in archive.namelist():
                if name.endswith((".so", ".pyd")):
                    imports = binaries.read(archive.read(name)).imports
                    asked[file.name, name] = {one for one in imports if one.startswith(("Py", "_Py"))}
    windows = [names for (file, _), names in asked.items() if "-win_" in file]
    if not windows or len(asked) == len(windows):
        pytest.skip("no wheels of Windows and of another system in dist/: make wheels-all")
    # What compilers leave out as never called may differ by a few.
    every = set().union(*windows)
    assert {key: names - every for key, names in asked.items() if len(names - every) > 3} == {}


def wheel(tag: str, modules: dict[str, bytes]) -> io.BytesIO:
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as archive:
        for name, data in modules.items():
            archive.writestr(f"petzval/{name}", data)
    return made


def test_what_is_wrong_with_a_wheel_is_named(made):
    one, data = made
    name = f"petzval-1.0-cp311-abi3-{one.tag}.whl"
    (place, *_) = [f"_engines/{level}/_native.abi3.so" for level in one.levels] or ["_native.abi3.so"]
    wrong = checking.of_wheel(wheel(one.tag, {place: data}), name)
    assert any("SBOM.cdx.json is missing" in line for line in wrong)
    assert any("it holds" in line for line in wrong) == bool(one.levels), "an engine for each level"
    assert any(
        "not for every Python" in line
        for line in checking.of_wheel(wheel(one.tag, {place: data}), name.replace("abi3", "cp311"))
    )
    assert checking.of_wheel(io.BytesIO(), "petzval-1.0-cp311-abi3-plan9.whl") == [
        "petzval-1.0-cp311-abi3-plan9.whl: of no platform that is known"
    ]


@pytest.mark.parametrize("module", ["_native.abi3.so", "_native.pyd"])
def test_wheels_of_several_levels_are_joined(tmp_path, module):
    for level in ("low", "high"):
        (tmp_path / level).mkdir()
        with zipfile.ZipFile(tmp_path / level / "petzval-1-cp311-abi3-any.whl", "w") as archive:
            archive.writestr("petzval/__init__.py", "")
            archive.writestr(f"petzval/{module}", level)
            archive.writestr("petzval-1.dist-info/RECORD", "")
    command = [shutil.which("python3") or "python3", ROOT / "tools/join-wheels.py", tmp_path, "low", "high"]
    subprocess.run(command, check=True)
    with zipfile.ZipFile(tmp_path / "petzval-1-cp311-abi3-any.whl") as archive:
        assert {name: archive.read(name).decode() for name in archive.namelist() if "_engines" in name} == {
            f"petzval/_engines/low/{module}": "low", f"petzval/_engines/high/{module}": "high"
        }  # fmt: skip
        rows = list(csv.reader(archive.read("petzval-1.dist-info/RECORD").decode().splitlines()))
        digest = base64.urlsafe_b64encode(hashlib.sha256(b"high").digest()).rstrip(b"=").decode()
        assert [f"petzval/_engines/high/{module}", f"sha256={digest}", "4"] in rows


def test_each_platform_has_names_that_fit():
    for one in platforms.PLATFORMS.values():
        assert platforms.platform_of(f"petzval-1.0-cp311-abi3-{one.tag}.whl") is one
        assert {"x64": "x86_64", "arm64": "aarch64"}[one.machine] == one.triple.split("-")[0] == one.zig.split("-")[0]
        assert one.system in (one.triple.replace("apple-darwin", "macos"))


# Licences --------------------------------------------------------------------------------------------------------


@pytest.mark.skipif(shutil.which("cargo") is None, reason="no cargo")
def test_the_bill_of_materials_names_every_linked_crate():
    crates, told = supply.linked_crates(), supply.sbom()
    assert told["bomFormat"] == "CycloneDX"
    assert (
        told["metadata"]["component"]["version"]
        == tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["version"]
    )
    named = {(one["name"], one["version"]) for one in told["components"]}
    assert named == {(one.name, one.version) for one in crates} and len(named) > 30
    for one in told["components"]:
        assert one["purl"] == f"pkg:cargo/{one['name']}@{one['version']}" and len(one["hashes"][0]["content"]) == 64
        assert supply.is_compatible(one["licenses"][0]["expression"]), one["name"]
    assert supply.sbom() == told
