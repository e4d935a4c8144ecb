#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fuzzes the engine's readers from their kept corpora, one target after the other, and fails where an input breaks a property.

    tools/fuzz.py                          every target, a minute each
    tools/fuzz.py --seconds 3600 system    one of them, for an hour
    tools/fuzz.py --keep                   then the corpora are made as small as they can be, and kept

What the fuzzer finds new stays in output/fuzz, from which the next run goes on. Needs a nightly compiler and cargo-fuzz.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FUZZ = ROOT / "engine/fuzz"
KEPT = FUZZ / "corpus"
FOUND = ROOT / "output/fuzz"
#: What an input may take: memory, time, and its length, beyond which more bytes say nothing new.
MEMORY_MB = 2048
INPUT_SECONDS = 25
LONGEST_BYTES = 20_000
#: Longest kept input, and number of kept inputs of a target: the largest are left out first.
KEPT_BYTES = 4096
KEPT_FILES = 40
#: Without the compiler's checks of memory, as the engine has no unsafe code, and without a look at every comparison: on the lens kernels, which
#: are compiled for many widths of registers, either takes a quarter of an hour.
TARGET_DIR = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve() / "fuzz"
BUILD = ("--fuzz-dir", str(FUZZ), "--target-dir", str(TARGET_DIR), "--sanitizer", "none")
BUILD += ("--codegen-units", "16", "--no-trace-compares")
CARGO = ("cargo", "+nightly", "fuzz")


def targets() -> list[str]:
    return sorted(path.stem for path in (FUZZ / "fuzz_targets").glob("*.rs"))


def missing() -> str | None:
    """What has to be installed first, in one line."""

    def works(*command: str) -> bool:
        if shutil.which(command[0]) is None:
            return False
        return subprocess.run(command, capture_output=True, check=False).returncode == 0

    if not works("cargo", "+nightly", "--version"):
        return "fuzzing needs a nightly compiler: rustup toolchain install nightly"
    if not works("cargo", "fuzz", "--version"):
        return "fuzzing needs cargo-fuzz: cargo install --locked cargo-fuzz"
    return None


def run(target: str, seconds: int) -> str | None:
    """Fuzzes a target; the file of an input that breaks its property."""
    found, broken = FOUND / "corpus" / target, FOUND / "broken" / target
    for folder in (found, broken, KEPT / target):
        folder.mkdir(parents=True, exist_ok=True)
    limits = [f"-max_total_time={seconds}", f"-rss_limit_mb={MEMORY_MB}", f"-timeout={INPUT_SECONDS}"]
    # New inputs go into the first folder; the kept ones stay as they are.
    folders = [str(found), str(KEPT / target)]
    command = [*CARGO, "run", *BUILD, target, *folders, "--", *limits, f"-max_len={LONGEST_BYTES}"]
    command += [f"-artifact_prefix={broken}/", "-print_final_stats=1", "-verbosity=1"]
    began = time.monotonic()
    done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    took = time.monotonic() - began
    executions = re.search(r"stat::number_of_executed_units: (\d+)", done.stdout)
    said = f"{int(executions[1])} inputs" if executions else "no count of inputs"
    print(f"{target:12} {said} in {took:.0f} s", flush=True)
    if done.returncode == 0:
        return None
    print(done.stdout[-6000:], file=sys.stderr)
    written = re.search(r"Test unit written to (\S+)", done.stdout)
    return written[1] if written else f"{target}: it ended with status {done.returncode}"


def keep(target: str) -> None:
    """Puts the smallest set of inputs that reaches as much code into the kept corpus."""
    whole, least = FOUND / "corpus" / target, FOUND / "least" / target
    shutil.rmtree(least, ignore_errors=True)
    least.mkdir(parents=True)
    for path in (KEPT / target).iterdir():
        shutil.copy(path, whole)
    # cargo-fuzz makes a folder smaller in its place.
    for path in whole.iterdir():
        if path.stat().st_size <= KEPT_BYTES:
            shutil.copy(path, least)
    subprocess.run([*CARGO, "cmin", *BUILD, target, str(least)], cwd=ROOT, check=True, capture_output=True)
    smallest = sorted(least.iterdir(), key=lambda path: (path.stat().st_size, path.name))[:KEPT_FILES]
    names = {path.name for path in smallest}
    for path in (KEPT / target).iterdir():
        # Those with names of their own are seeds, or inputs that have broken the property once.
        if re.fullmatch(r"[0-9a-f]{40}", path.name) and path.name not in names:
            path.unlink()
    for path in smallest:
        shutil.copy(path, KEPT / target)


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description="Fuzz the engine's readers.")
    parser.add_argument("targets", nargs="*", metavar="TARGET", help=f"of {', '.join(targets())}; else all")
    parser.add_argument("--seconds", type=int, default=int(os.environ.get("FUZZ_SECONDS", "60")))
    parser.add_argument("--keep", action="store_true", help="keep the smallest corpora that reach as much")
    options = parser.parse_args(arguments)
    unknown = [name for name in options.targets if name not in targets()]
    if unknown:
        parser.error(f"there is no target {unknown[0]}; they are {', '.join(targets())}")
    if options.seconds < 1:
        parser.error("--seconds: give 1 or more")
    why = missing()
    if why is not None:
        print(f"petzval: {why}", file=sys.stderr)
        return 1
    broken = []
    for target in options.targets or targets():
        found = run(target, options.seconds)
        if found is not None:
            broken.append(found)
        elif options.keep:
            keep(target)
    for found in broken:
        print(f"petzval: fuzzing found {found}", file=sys.stderr)
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
