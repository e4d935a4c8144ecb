# SPDX-License-Identifier: GPL-3.0-or-later
"""`python3 -m platforms`, tools/ on the path: `wheels` builds those of other systems into dist/, `check` lists the faults of the wheels and
extensions there, `test` runs the engine's tests for other systems by emulators, `repository` makes an extensions repository of the zips."""

from __future__ import annotations

import argparse
import sys
import time

from . import PLATFORMS, ROOT, building, checking, emulated, host


def main() -> int:
    parser = argparse.ArgumentParser(prog="platforms", description="Petzval for every system that has a Blender.")
    actions = parser.add_subparsers(dest="action", required=True)
    wheels = actions.add_parser("wheels")
    wheels.add_argument("--only", nargs="+", choices=sorted(PLATFORMS), help="default: all but this machine's own")
    wheels.add_argument("--fast", action="store_true", help="the development build, to try")
    check = actions.add_parser("check")
    check.add_argument("--all", action="store_true", help="one that is missing is wrong, too")
    test = actions.add_parser("test")
    test.add_argument("--only", nargs="+", choices=sorted(emulated.EMULATORS), help="default: all that can be emulated")
    test.add_argument("--filter", nargs="+", default=[], metavar="TEST", help="tests with these in their names")
    test.add_argument(
        "--crates", nargs="+", metavar="NAME", help="files, optics, ...; default: all that each emulator can bear"
    )
    options = parser.parse_args()
    return {"wheels": _wheels, "check": _check, "test": _test}[options.action](options)


def _wheels(options: argparse.Namespace) -> int:
    own = host()
    names = options.only or [one.name for one in PLATFORMS.values() if one.triple != own]
    failed = 0
    for name in names:
        began = time.monotonic()
        print(f"petzval: compiling the wheel of {name} (about 10 minutes on 2 cores)", file=sys.stderr, flush=True)
        try:
            made = building.wheel(PLATFORMS[name], is_fast=options.fast)
        except building.BuildError as error:
            print(f"petzval: {name}: {error}", file=sys.stderr)
            failed += 1
            continue
        print(
            f"{made.relative_to(ROOT)}  {made.stat().st_size / 1e6:.1f} MB  {time.monotonic() - began:.0f} s",
            flush=True,
        )
    return min(failed, 1)


def _test(options: argparse.Namespace) -> int:
    is_good = True
    for name in options.only or emulated.EMULATORS:
        try:
            is_good &= emulated.test(name, options.filter, options.crates)
        except building.BuildError as error:
            print(f"petzval: {name}: {error}", file=sys.stderr)
            is_good = False
    return 0 if is_good else 1


def _check(options: argparse.Namespace) -> int:
    folder, wrong = ROOT / "dist", []
    wheels, zips = sorted(folder.glob("petzval-*.whl")), sorted(folder.glob("petzval-*.zip"))
    for file in wheels:
        wrong += checking.of_wheel(file, file.name)
    for file in zips:
        wrong += checking.of_extension(file)
    if options.all:
        for one in PLATFORMS.values():
            wrong += [] if any(one.tag in file.name for file in wheels) else [f"{one.name}: no wheel"]
            wrong += [] if any(file.stem.endswith(one.name) for file in zips) else [f"{one.name}: no extension"]
    for line in wrong:
        print(f"petzval: {line}", file=sys.stderr)
    for file in (*wheels, *zips):
        print(f"{file.stat().st_size / 1e6:6.1f} MB  {file.relative_to(ROOT)}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
