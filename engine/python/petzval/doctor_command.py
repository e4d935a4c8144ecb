# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval doctor`: the installed parts, the missing ones, and the remedies. Starts each Blender that it finds, for its version alone."""

from __future__ import annotations

import argparse
import importlib.metadata
import importlib.util
import json
import os
import platform
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from . import denoiser_library, processors
from .places import lenses_folder

#: Seconds that a program may take to say its version.
_PATIENCE_S = 60.0
_OLDEST_BLENDER = (4, 2)


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `doctor`."""
    p = subparsers.add_parser(
        "doctor",
        help="say what is installed, what is missing, and what to do",
        description="Says which engine this processor runs, which Python, which Blender and Open Image Denoise there are, and what to do about "
        "what is missing. Exit status 1 if Petzval cannot render here.",
        allow_abbrev=False,
    )
    p.add_argument("--blender", metavar="PATH", help="a Blender program to look at, too")
    p.add_argument("--json", action="store_true", help="one JSON object on stdout")


def run(arguments: argparse.Namespace) -> int:
    """Looks, and tells; the exit status."""
    found = examine(arguments.blender)
    if arguments.json:
        print(json.dumps(found))
    else:
        for name, value in _rows(found):
            print(f"{name:<12} {value}")
        for line in found["missing"]:
            print(f"! {line}")
        for line in found["advice"]:
            print(f"- {line}")
        if not found["missing"] and not found["advice"]:
            print("Nothing is missing.")
    return 1 if found["missing"] else 0


def examine(blender: str | None = None) -> dict[str, Any]:
    """The parts of the installation. `missing` are lines on parts without which Petzval cannot render, `advice` on optional ones."""
    engine = _engine()
    programs = _programs(blender)
    blenders = [{"program": str(program), "version": _version_of(program)} for program in programs]
    bpy = _installed("bpy")
    homes = [_home(program) for program in programs]
    spec = importlib.util.find_spec("bpy")
    homes += [Path(place) for place in (spec.submodule_search_locations or ())] if spec else []
    denoiser = denoiser_library.find(homes)
    found: dict[str, Any] = {
        "engine": engine,
        "system": f"{platform.system()} {platform.release()}, {platform.machine()}",
        "processor_level": _level(),
        "python": {"version": platform.python_version(), "program": sys.executable},
        "packages": {name: _installed(name) for name in ("numpy", "bpy", "matplotlib", "dask", "pyoidn")},
        "blenders": blenders,
        "extensions": [{"folder": str(folder), "version": version} for folder, version in _extensions()],
        "denoiser": None if denoiser is None else str(denoiser),
        "lenses": len(list(lenses_folder().glob("*.lens"))),
        "missing": [],
        "advice": [],
    }
    missing, advice = found["missing"], found["advice"]
    if "error" in engine:
        missing.append(f"no engine: {engine['error']}")
    if not found["lenses"]:
        missing.append(f"no lenses in {lenses_folder()}: install Petzval again")
    if found["packages"]["numpy"] is None:
        missing.append("no numpy: pip install numpy")
    fitting = [one for one in blenders if one["version"] and _numbers(one["version"]) >= _OLDEST_BLENDER]
    if bpy is None and not fitting:
        advice.append(
            'no Blender of 4.2 or later: `petzval render` needs one: pip install "petzval[bpy]", or install Blender and say --blender PATH'
        )
    for one in blenders:
        if one["version"] is None:
            advice.append(f"{one['program']} does not say its version: does it run?")
        elif one not in fitting:
            advice.append(f"{one['program']} is {one['version']}, and the add-on needs 4.2 or later: update it")
    if denoiser is None:
        advice.append("no Open Image Denoise: pictures are not denoised: pip install pyoidn, or a Blender that has it")
    if found["packages"]["matplotlib"] is None:
        advice.append('no matplotlib: `petzval cost` draws no plots: pip install "petzval[plots]"')
    own = engine.get("version")
    for one in found["extensions"]:
        if own and one["version"] != own:
            advice.append(
                f"the extension in {one['folder']} is {one['version']}, and this is {own}: update the older one"
            )
    return found


def _rows(found: dict[str, Any]) -> Iterator[tuple[str, str]]:
    engine = found["engine"]
    yield "petzval", engine.get("version", "cannot be loaded")
    if "file" in engine:
        yield "engine", f"for {engine['processor']}, {engine['file']}"
    yield "processor", found["processor_level"]
    yield "system", found["system"]
    yield "python", f"{found['python']['version']}, {found['python']['program']}"
    for name, version in found["packages"].items():
        yield name, version or "-"
    for one in found["blenders"]:
        yield "blender", f"{one['version'] or '?'}, {one['program']}"
    if not found["blenders"]:
        yield "blender", "-"
    for one in found["extensions"]:
        yield "extension", f"{one['version']}, {one['folder']}"
    yield "denoiser", found["denoiser"] or "-"
    yield "lenses", str(found["lenses"])


def _engine() -> dict[str, str]:
    try:
        from . import _native
    except ImportError as error:
        return {"error": f"{error}: install the wheel for this system again, or build it (make build)"}
    return {"version": _native.__version__, "processor": _native.PROCESSOR, "file": str(_native.__file__)}


def _level() -> str:
    """The best level of engines that this processor runs."""
    flags = processors.flags_of_this_processor()
    if flags is None or platform.machine().lower() not in ("x86_64", "amd64"):
        return platform.machine() or "unknown"
    fitting = [level for level in processors.LEVELS if not processors.lacking(level, flags)]
    return fitting[-1] if fitting else f"below {next(iter(processors.LEVELS))}"


def _installed(package: str) -> str | None:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def _programs(named: str | None) -> list[Path]:
    """Blender programs: the one that is named, that on PATH, and those in the folders of installers."""
    found: dict[Path, None] = {}
    on_path = shutil.which("blender")
    places = [Path(one) for one in (named, on_path) if one]
    home = Path.home()
    if sys.platform == "win32":
        for name in ("ProgramFiles", "ProgramW6432"):
            installed = Path(os.environ.get(name) or ".", "Blender Foundation")
            places += sorted(installed.glob("Blender */blender.exe"), reverse=True)
    elif sys.platform == "darwin":
        for root in (Path("/Applications"), home / "Applications"):
            places += sorted(root.glob("Blender*.app/Contents/MacOS/Blender"), reverse=True)
    else:
        for root in (Path("/opt"), home):
            places += sorted(root.glob("[Bb]lender*/blender"), reverse=True)
    for place in places:
        if place.is_file() or str(place) == named:
            found.setdefault(place.resolve() if str(place) != named else place, None)
    return list(found)


def _version_of(program: Path) -> str | None:
    try:
        done = subprocess.run(
            [program, "--version"], stdin=subprocess.DEVNULL, capture_output=True, timeout=_PATIENCE_S, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    told = re.search(r"^Blender (\d+\.\d+\S*)", done.stdout.decode(errors="replace"), re.MULTILINE)
    return told[1] if told else None


def _home(program: Path) -> Path:
    """The folder beside whose libraries a program lies."""
    return program.parent.parent / "Resources" if sys.platform == "darwin" else program.parent


def _numbers(version: str) -> tuple[int, ...]:
    return tuple(int(part) for part in re.findall(r"\d+", version)[:2])


def _extensions() -> Iterator[tuple[Path, str]]:
    """Petzval among the extensions that Blender's user has, and its version."""
    if sys.platform == "win32":
        root = Path(os.environ.get("APPDATA", Path.home()), "Blender Foundation", "Blender")
    elif sys.platform == "darwin":
        root = Path.home() / "Library/Application Support/Blender"
    else:
        root = Path(os.environ.get("XDG_CONFIG_HOME") or Path.home() / ".config", "blender")
    folders = [folder / "extensions" for folder in sorted(root.glob("*.*"), reverse=True)]
    own = os.environ.get("BLENDER_USER_RESOURCES")
    folders = [Path(own, "extensions"), *folders] if own else folders
    for folder in folders:
        for manifest in sorted(folder.glob("*/petzval/blender_manifest.toml")):
            try:
                yield manifest.parent, str(tomllib.loads(manifest.read_text(encoding="utf-8"))["version"])
            except (OSError, ValueError, KeyError):
                yield manifest.parent, "broken"
