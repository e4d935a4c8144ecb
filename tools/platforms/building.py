# SPDX-License-Identifier: GPL-3.0-or-later
"""Wheels for other systems, compiled on this one: the Rust compiler knows all of them, and zig brings their C libraries."""

from __future__ import annotations

import fcntl
import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

from . import ROOT, Platform, binaries, checking

_BUNDLED = ROOT / "engine/python/petzval/_bundled"
_NEW = ROOT / "dist/new"
_LOG = ROOT / "output/platforms"


class BuildError(Exception):
    """An error of a build. The message is one line: the fault and the remedy."""


def run(command: list[str | Path], log: Path, environment: dict[str, str]) -> None:
    """Runs a step and keeps its output. Raises `BuildError`."""
    log.parent.mkdir(parents=True, exist_ok=True)
    with log.open("wb") as out:
        done = subprocess.run(
            command, cwd=ROOT, stdout=out, stderr=subprocess.STDOUT, env=os.environ | environment, check=False
        )
    if done.returncode:
        raise BuildError(f"'{command[0]} {command[1]}' failed: read {log.relative_to(ROOT)}")


def cross_environment(platform: Platform) -> dict[str, str]:
    """The environment variables with which Cargo compiles and links for a platform."""
    upper = platform.triple.upper().replace("-", "_")
    return {
        "PATH": f"{ROOT / '.venv-wheels/bin'}{os.pathsep}{os.environ['PATH']}",
        f"CARGO_TARGET_{upper}_LINKER": str(ROOT / "tools/zig-linker.sh"),
        "PETZVAL_ZIG_TARGET": platform.zig,
        # As in the linker's own flags, where they are asked for.
        "MACOSX_DEPLOYMENT_TARGET": ".".join(map(str, platform.oldest)),
    }


def add_target(platform: Platform) -> None:
    """Fetches by rustup the standard library of a platform. Raises `BuildError`."""
    sysroot = subprocess.run(["rustc", "--print", "sysroot"], capture_output=True, text=True, check=True).stdout.strip()
    if (Path(sysroot) / "lib/rustlib" / platform.triple / "lib").is_dir():
        return
    if shutil.which("rustup") is None:
        raise BuildError(f"{platform.name}: Rust has no standard library for {platform.triple}: install Rust by rustup")
    run(["rustup", "target", "add", platform.triple], _LOG / f"{platform.name}-target.log", {})


def bundle(platform: Platform) -> None:
    """Copies the files of a wheel, but for the engine, into the package."""
    shutil.rmtree(_BUNDLED, ignore_errors=True)
    for folder in ("addon", "lenses"):
        shutil.copytree(ROOT / folder, _BUNDLED / folder, ignore=shutil.ignore_patterns("__pycache__"))
    for what, name in (("notices", "THIRD-PARTY-NOTICES.txt"), ("sbom", "SBOM.cdx.json")):
        command = [sys.executable, "-m", "supply", what, _BUNDLED / name, "--target", platform.triple]
        subprocess.run(command, cwd=ROOT, env=os.environ | {"PYTHONPATH": str(ROOT / "tools")}, check=True)


def _unknown_of_mac(made: Path) -> list[str]:
    """Functions that a Mac's modules ask for, and neither Python nor the system has: its linker leaves them for later."""
    command = [ROOT / ".venv-wheels/bin/python", "-c", "import ziglang; print(ziglang.__file__)"]
    zig = Path(subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()).parent
    known = set(re.findall(r"[\w$.]+", (zig / "lib/libc/darwin/libSystem.tbd").read_text()))
    wrong = []
    with zipfile.ZipFile(made) as archive:
        for name in archive.namelist():
            if name.endswith(".so"):
                imports = binaries.read(archive.read(name)).imports
                wrong += [f"{name}: {one}: of no library" for one in sorted(imports)
                          if not one.startswith(("Py", "_Py")) and not {f"_{one}", one} & known]  # fmt: skip
    return wrong


def wheel(platform: Platform, *, is_fast: bool) -> Path:
    """Builds a platform's wheel into dist/. Raises `BuildError`."""
    add_target(platform)
    (ROOT / "dist").mkdir(exist_ok=True)
    # One build at a time: tools/build-wheel.sh lays its files into the same folder.
    with (ROOT / "dist/.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        return _wheel(platform, is_fast=is_fast)


def _wheel(platform: Platform, *, is_fast: bool) -> Path:
    target = os.environ.get("CARGO_TARGET_DIR", str(ROOT / "target"))
    cargo_home = os.environ.get("CARGO_HOME", str(Path.home() / ".cargo"))
    sources = f"--remap-path-prefix={ROOT}=petzval --remap-path-prefix={cargo_home}/registry/src=crates"
    new = _NEW / platform.name
    shutil.rmtree(new, ignore_errors=True)
    bundle(platform)
    try:
        for level in platform.levels or ("",):
            flags = f"{os.environ.get('RUSTFLAGS', '')} {sources}" + (f" -C target-cpu={level}" if level else "")
            words = ["build", "--target", platform.triple, "--auditwheel", "skip", "--out", new / level]
            words += ["--profile", "dev"] if is_fast else ["--release"]
            words += ["--compatibility", platform.tag] if platform.system == "linux" else []
            # A folder for each level: the flags of one would have the other compiled again.
            words += ["--target-dir", f"{target}/{level or 'cross'}"]
            log = _LOG / f"{platform.name}{level and '-' + level}.log"
            run(["maturin", *words], log, cross_environment(platform) | {"RUSTFLAGS": flags})
    finally:
        shutil.rmtree(_BUNDLED, ignore_errors=True)
    if platform.levels:
        subprocess.run([sys.executable, ROOT / "tools/join-wheels.py", new, *platform.levels], check=True)
    (made,) = new.glob("petzval-*.whl")
    wrong = checking.of_wheel(made, made.name)
    wrong += _unknown_of_mac(made) if platform.system == "macos" else []
    if wrong:
        raise BuildError("; ".join(wrong))
    for old in (ROOT / "dist").glob(f"petzval-*-{platform.tag}.whl"):
        old.unlink()
    place = ROOT / "dist" / made.name
    made.replace(place)
    shutil.rmtree(new)
    return place
