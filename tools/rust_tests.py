# SPDX-License-Identifier: GPL-3.0-or-later
"""Compiles and runs the engine's unit and integration tests, and hands on the time of each: rust_tests.py [FILTER...]

The same as `cargo test --lib --tests`, but that the test programs report the time of each test. Examples are left out: clippy has
compiled them, and the lens kernels take long for each program.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
#: Property tests take the same random inputs in every run, so that only a change makes a test fail; `make test-all`, and
#: `cargo test` by itself, take others each time.
SEEDS = {} if os.environ.get("PETZVAL_TEST_ALL") else {"PROPTEST_RNG_SEED": "1"}
#: A line of a test program: name and seconds.
LINE = re.compile(r"^test (\S+).* \.\.\. ok <([0-9.]+)s>$", re.MULTILINE)


def programs(
    which: Sequence[str] = ("--workspace",), own: Mapping[str, str] | None = None
) -> list[tuple[str, Path, Path]]:
    """Every test program that cargo compiles by these options, in this environment: the target's name, the file, the folder of its package."""
    command = ["cargo", "test", *which, "--locked", "--tests", "--no-run", "--message-format=json"]
    done = subprocess.run(
        command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=False, env=os.environ | dict(own or {})
    )
    if done.returncode:
        messages = (json.loads(line) for line in done.stdout.splitlines() if line.startswith("{"))
        for message in messages:
            if message["reason"] == "compiler-message":
                print(message["message"]["rendered"], file=sys.stderr)
        raise SystemExit(done.returncode)
    found = []
    for line in done.stdout.splitlines():
        message = json.loads(line) if line.startswith("{") else {}
        if message.get("reason") == "compiler-artifact" and message["profile"]["test"] and message["executable"]:
            package = Path(message["manifest_path"]).parent
            name = f"{package.name} {message['target']['kind'][0]} {message['target']['name']}"
            found.append((name, Path(message["executable"]), package))
    return found


def main() -> int:
    durations = os.environ.get("PETZVAL_DURATIONS")
    failed = 0
    for name, program, package in programs():
        print(f"== {name}", flush=True)
        # Stable test programs report times with this variable only.
        done = subprocess.run(
            [program, "-Zunstable-options", "--report-time", *sys.argv[1:]],
            cwd=package,
            env=os.environ | SEEDS | {"RUSTC_BOOTSTRAP": "1", "CARGO_MANIFEST_DIR": str(package)},
            stdout=subprocess.PIPE,
            text=True,
            check=False,
        )
        print(done.stdout, end="", flush=True)
        failed |= done.returncode != 0
        if durations:
            rows = (f"{float(seconds):8.1f}  {name}: {test}\n" for test, seconds in LINE.findall(done.stdout))
            with open(durations, "a", encoding="utf-8") as out:
                out.writelines(rows)
    return int(failed)


if __name__ == "__main__":
    raise SystemExit(main())
