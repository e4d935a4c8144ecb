# SPDX-License-Identifier: GPL-3.0-or-later
"""The checks of a wheel or an extension, as far as its files tell."""

from __future__ import annotations

import io
import tomllib
import zipfile
from pathlib import Path

from . import LARGEST_ZIP, LIBRARIES, PLATFORMS, Platform, binaries, platform_of


def of_module(name: str, data: bytes, platform: Platform) -> list[str]:
    """The faults that keep a compiled module from being loaded by Python on a platform."""
    try:
        module = binaries.read(data)
    except binaries.BinaryError as error:
        return [f"{name}: {error}"]
    wrong = []
    if (module.system, module.machine) != (platform.system, platform.machine):
        wrong.append(f"it is for {module.system}-{module.machine}")
    if foreign := [one for one in module.libraries if not LIBRARIES[platform.system].fullmatch(one)]:
        wrong.append(f"it asks for {', '.join(foreign)}")
    if module.oldest > platform.oldest:
        wrong.append(
            f"it asks for {'.'.join(map(str, module.oldest))}, and Blender for {'.'.join(map(str, platform.oldest))}"
        )
    if "PyInit__native" not in module.exports:
        wrong.append("it is no module of Python")
    # The stable interface: on Windows its functions come from a library of its own.
    if platform.system == "windows" and "python3.dll" not in module.libraries:
        wrong.append("it is not of Python's stable interface")
    if platform.name == "macos-arm64" and not module.is_signed:
        wrong.append("its signature is not that of its bytes")
    return [f"{name}: {one}" for one in wrong]


def of_wheel(file: Path | io.BytesIO, name: str) -> list[str]:
    """The faults of a wheel of this name."""
    try:
        platform = platform_of(name)
    except KeyError:
        return [f"{name}: of no platform that is known"]
    wrong = [] if name.split("-")[2:4] == ["cp311", "abi3"] else [f"{name}: it is not for every Python from 3.11 on"]
    with zipfile.ZipFile(file) as archive:
        modules = [one for one in archive.namelist() if one.endswith((".so", ".pyd", ".dll", ".dylib"))]
        ending = "_native.pyd" if platform.system == "windows" else "_native.abi3.so"
        wanted = {f"petzval/_engines/{level}/{ending}" for level in platform.levels} or {f"petzval/{ending}"}
        if set(modules) != wanted:
            wrong.append(f"{name}: it holds {', '.join(modules)}, and not {', '.join(sorted(wanted))}")
        for one in modules:
            wrong += of_module(f"{name}/{one}", archive.read(one), platform)
        wrong += [
            f"{name}: {one} is missing" for one in _MUST_HOLD if f"petzval/_bundled/{one}" not in archive.namelist()
        ]
    return wrong


_MUST_HOLD = ("addon/__init__.py", "lenses/wide-angle-smith-f3.4.lens", "THIRD-PARTY-NOTICES.txt", "SBOM.cdx.json")


def of_extension(file: Path) -> list[str]:
    """The faults of an extension."""
    wrong = []
    if (size := file.stat().st_size) > LARGEST_ZIP:
        wrong.append(f"{file.name}: {size:,} bytes, and at most {LARGEST_ZIP:,} are wanted")
    with zipfile.ZipFile(file) as archive:
        manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
        (wheel,) = manifest["wheels"]
        (named,) = manifest["platforms"]
        name = wheel.removeprefix("./wheels/")
        wrong += [f"{file.name}: {one} is there, and the manifest does not name it" for one in archive.namelist()
                  if one.startswith("wheels/") and one not in ("wheels/", wheel.removeprefix("./"))]  # fmt: skip
        of_this = PLATFORMS.get(named)
        is_of_this = of_this is not None and of_this.tag in Path(name).stem.rpartition("-")[2].split(".")
        if not is_of_this or file.name != f"petzval-{manifest['version']}-{named}.zip":
            wrong.append(f"{file.name}: it is for {named}, and its wheel is {name}")
        wrong += [f"{file.name}: {one}" for one in of_wheel(io.BytesIO(archive.read(wheel.removeprefix("./"))), name)]
    return wrong
