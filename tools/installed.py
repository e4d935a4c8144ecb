#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tries the Petzval that is installed in this Python, as its users do, on any system: installed.py [SCENE.blend]

Lens files with the line ends of Windows, in folders with spaces, of names that are no ASCII; and where this Python has bpy, the scene is
rendered through a lens. Prints its findings, and ends with 1 where something is wrong. Needs nothing of a checkout but the scene.
"""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
import tempfile
from pathlib import Path

LENS = "# name: Ein Prüfling\n#radius thickness glass diameter conic isstop\n50 4 N-BK7 20 0 0\n-50 5 air 20 0 0\n0 85 air 10 0 1\n"


def petzval(*arguments: object, folder: Path) -> str:
    """The output of a command on stdout; ends this program where it fails."""
    command = [sys.executable, "-m", "petzval", *map(str, arguments)]
    done = subprocess.run(command, cwd=folder, capture_output=True, timeout=1200, check=False)
    said = done.stdout.decode("utf-8", errors="replace")
    if done.returncode:
        sys.exit(
            f"petzval {' '.join(map(str, arguments))}: status {done.returncode}\n{said}{done.stderr.decode(errors='replace')}"
        )
    return said


def expect(what: str, is_so: bool) -> None:
    print(f"{'ok' if is_so else 'WRONG':<6} {what}", flush=True)
    if not is_so:
        sys.exit(1)


def main(scene: Path | None) -> None:
    # Not of the checkout, which may be the current folder.
    found = importlib.util.find_spec("petzval")
    expect(f"petzval is {found.origin if found else 'not installed'}", found is not None)
    with tempfile.TemporaryDirectory(prefix="petzval ü ") as name:
        folder = Path(name)
        expect(petzval("--version", folder=folder).strip(), True)
        told = json.loads(petzval("doctor", "--json", folder=folder))
        expect(
            f"the engine is for {told['engine']['processor']}, {told['lenses']} lenses, {told['system']}",
            told["missing"] == [],
        )
        unix, windows = folder / "unix.lens", folder / "Fenster é.lens"
        unix.write_bytes(LENS.encode())
        windows.write_bytes(LENS.replace("\n", "\r\n").encode())
        one, other = (json.loads(petzval("lens", "info", file, "--json", folder=folder)) for file in (unix, windows))
        expect("a lens file with line ends of Windows is the same lens", {**one, "file": ""} == {**other, "file": ""})
        petzval("lens", "convert", windows.name, "out put.zmx", folder=folder)
        expect("files in a folder with spaces are read and written", (folder / "out put.zmx").is_file())
        petzval("lens", "convert", windows.name, "out put.zmx", folder=folder)
        expect("a file that is there is replaced", (folder / "out put.zmx").is_file())
        petzval("lens", "draw", "tessar-brendel", "-o", "tessar.svg", folder=folder)
        expect("line ends are the same on every system", b"\r\n" not in (folder / "tessar.svg").read_bytes())
        if told["packages"]["bpy"] is None or scene is None:
            print("not run: a render: " + ("give a scene" if scene is None else "this Python has no bpy"))
            return
        words = ("--lens", "wide-angle-smith-f3.4", "--resolution", "48x27", "--samples", "4", "--denoise", "off")
        petzval("render", scene, *words, "-o", "picture é.png", "--stats", "stats.json", folder=folder)
        stats = json.loads((folder / "stats.json").read_text(encoding="utf-8"))
        picture = (folder / "picture é.png").read_bytes()
        expect(
            f"bpy {told['packages']['bpy']} renders, {stats['processor']}",
            picture.startswith(b"\x89PNG") and not stats["interrupted"],
        )


if __name__ == "__main__":
    main(Path(sys.argv[1]).absolute() if len(sys.argv) > 1 else None)
