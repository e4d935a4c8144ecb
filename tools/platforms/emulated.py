# SPDX-License-Identifier: GPL-3.0-or-later
"""The engine's Rust tests, compiled for other systems and run here: for Windows by Wine, for Linux on ARM by QEMU."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import rust_tests

from . import PLATFORMS, ROOT, Platform, building

#: The flags of .cargo/config.toml for x86-64, without those for Linux alone: equal arithmetic, so that tests of bits hold alike.
_X64_FLAGS = "-C target-cpu=x86-64-v3 --cfg disable_dispatch_avx512 -C llvm-args=-inline-threshold=300"


@dataclass(frozen=True)
class Emulator:
    """The emulator of a platform's programs."""

    name: str
    #: The program's name in tools/setup-emulators.sh.
    program: str
    flags: str
    #: Crates whose tests are run; None: all.
    packages: tuple[str, ...] | None
    #: The reason why the others are not.
    reason: str = ""


EMULATORS = {
    "windows-x64": Emulator("Wine", "wine", _X64_FLAGS, None),
    "linux-arm64": Emulator(
        "QEMU", "qemu", "", ("denoise", "files", "nodes", "optics", "pictures", "testkit"),
        "each takes dozens of times as long there, and renders take minutes here",
    ),
}  # fmt: skip


def command_of(emulator: Emulator) -> list[str]:
    """The command that a program is appended to. Raises `building.BuildError` where there is none."""
    setup = ROOT / "tools/setup-emulators.sh"
    done = subprocess.run([setup], stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode:
        raise building.BuildError(done.stderr.strip().removeprefix("petzval: "))
    told = subprocess.run([setup, "--where", emulator.program], stdout=subprocess.PIPE, text=True, check=False)
    if told.returncode:
        raise building.BuildError(f"there is no {emulator.name}: install it")
    return shlex.split(told.stdout)


def environment(folder: Path, emulator: Emulator, platform: Platform) -> dict[str, str]:
    """The environment variables of an emulator's programs, with their files in a folder of its own."""
    if emulator.program != "wine":
        return {}
    # Windows looks into its own folder first: a Wine that has the library takes that.
    libraries = folder / "libraries"
    libraries.mkdir(exist_ok=True)
    source, out = Path(__file__).with_name("bcryptprimitives.c"), libraries / "bcryptprimitives.dll"
    words = ["-m", "ziglang", "cc", "-target", platform.zig, "-O2", "-s", "-shared", source, "-ladvapi32", "-o", out]
    building.run([ROOT / ".venv-wheels/bin/python", *words], folder / "libraries.log", {})
    # Quiet, and without a window.
    return {"WINEPREFIX": str(folder / "wine"), "WINEPATH": f"Z:{libraries}".replace("/", "\\"), "WINEDEBUG": "-all",
            "WINEDLLOVERRIDES": "mscoree,mshtml=", "DISPLAY": ""}  # fmt: skip


def test(name: str, filters: list[str], crates: list[str] | None = None) -> bool:
    """Compiles and runs the tests for a platform, of these crates or all that are named above; prints the findings of each program; whether
    all passed."""
    platform, emulator = PLATFORMS[name], EMULATORS[name]
    runner = command_of(emulator)
    building.add_target(platform)
    own = building.cross_environment(platform) | {"RUSTFLAGS": emulator.flags}
    packages = ["--workspace", "--exclude", "petzval-python", "--exclude", "petzval-benches"]
    if chosen := crates or emulator.packages:
        packages = [word for one in chosen for word in ("-p", f"petzval-{one}")]
    programs = rust_tests.programs(["--target", platform.triple, *packages], own)
    scratch = ROOT / "output/platforms"
    scratch.mkdir(parents=True, exist_ok=True)
    around = environment(scratch, emulator, platform)
    passed = failed = skipped = 0
    for title, program, package in programs:
        began = time.monotonic()
        done = subprocess.run(
            [*runner, program, *filters], cwd=package, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False,
            env=os.environ | rust_tests.SEEDS | around | {"CARGO_MANIFEST_DIR": str(package)},
        )  # fmt: skip
        text = done.stdout.decode(errors="replace")
        (scratch / f"{name}-{title.replace(' ', '-')}.log").write_text(text, encoding="utf-8")
        counts = re.search(r"^test result: \w+\. (\d+) passed; (\d+) failed; (\d+) ignored", text, re.MULTILINE)
        found = [int(one) for one in counts.groups()] if counts else [0, 1, 0]
        # A program that ended by itself has failed, whatever it had counted.
        found[1] += int(done.returncode != 0 and found[1] == 0)
        passed, failed, skipped = passed + found[0], failed + found[1], skipped + found[2]
        print(
            f"{name}  {title}: {found[0]} passed, {found[1]} failed, {found[2]} ignored, {time.monotonic() - began:.0f} s",
            flush=True,
        )
        if found[1]:
            print(text[-8000:], file=sys.stderr, flush=True)
    if emulator.reason and not crates:
        print(f"{name}: not run: tests of the other crates: {emulator.reason}")
    print(f"{name} by {emulator.name}: {passed} passed, {failed} failed, {skipped} skipped", flush=True)
    return failed == 0 and passed > 0
