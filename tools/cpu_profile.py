#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The processor's time of a sample by source file, scene by scene: docs/design/profile.md.

Run by `make profile SCENES=FOLDER` in an environment with bpy: renders every .blend under the folder through a pinhole under Linux's `perf`,
and finds for each of its looks the file of the engine's sources that the instruction was written in, inlined functions told apart
(`llvm-symbolizer`). `--only NAME ...` prints these scenes and leaves the page as it is; `--lines` prints the costliest lines, too.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import NamedTuple

import blend_files
import pages

ROOT = Path(__file__).resolve().parent.parent
PAGE = "docs/design/profile.md"
SIZE, SAMPLES, SEED = "160x90", 128, 1
#: Looks a second: another than that of any clock.
FREQUENCY = 1997
#: A render that takes longer, s, is given up.
LONGEST_S = 900
#: Parts of the time by the sources' folders under engine/, the first that fits; a part without any takes the rest of the engine.
PARTS = {
    "trees": ("render/src/accel",),
    "nodes, textures": ("nodes/src", "render/src/nodes", "render/src/scene/texture", "render/src/scene/graph", "render/src/scene/corners"),
    "closures": ("render/src/shading",),
    "lights": ("render/src/lights",),
    "points hit": ("render/src/surface", "render/src/scene"),
    "paths": ("render/src/integrator",),
    "random numbers": ("render/src/sampler",),
    "camera, film": ("render/src/camera", "render/src/film", "render/src/pipeline", "optics/src", "render/src/job"),
    "other": (),
}  # fmt: skip
#: Functions of C's libraries, and the system.
LIBRARIES = "libraries, system"
WAITING = "waiting"
#: The files whose first and last look bound the samples.
SAMPLING = "render/src/integrator/path"


class Look(NamedTuple):
    """One look of `perf`: when, in which program file, at which address in memory."""

    second: float
    file: str
    address: int


class Source(NamedTuple):
    """A place in the engine's sources."""

    #: The source file from engine/ on; empty where none is known.
    file: str
    function: str
    line: int


class Failed(Exception):
    """A scene has no profile; the message says why."""


def main() -> int:
    asked = argparse.ArgumentParser(
        prog="cpu_profile", description="Where the time of a sample goes on scenes by others."
    )
    asked.add_argument("folder", type=Path, help="of .blend files")
    asked.add_argument("--engine", type=Path, required=True, help="the compiled engine, with the lines of its sources")
    asked.add_argument("--only", nargs="+", metavar="NAME", help="files of these names; the page stays as it is")
    asked.add_argument("--lines", action="store_true", help="print the costliest functions and lines, too")
    options = asked.parse_args()
    for tool, package in (("perf", "linux-perf"), ("llvm-symbolizer", "llvm"), ("readelf", "binutils")):
        if shutil.which(tool) is None:
            print(f"petzval: make profile needs {tool}: apt install {package}", file=sys.stderr)
            return 1
    scenes = [path for path in blend_files.under(options.folder) if not options.only or path.stem in options.only]
    if not scenes:
        print(f"petzval: no .blend to profile in {options.folder}", file=sys.stderr)
        return 1
    began, made, rows = time.monotonic(), pages.made(PAGE), {}
    package = tempfile.TemporaryDirectory()
    engine = beside_package(options.engine.resolve(), Path(package.name))
    for path in scenes:
        try:
            seconds, sources, libraries, idle = profiled(path, engine)
        except (Failed, subprocess.TimeoutExpired) as why:
            print(f"{path.stem}: left out: {why}", flush=True)
            continue
        rows[path.stem] = seconds, shares(sources, libraries, idle)
        print(path.stem, " ".join(f"{part} {share:.0%}" for part, share in rows[path.stem][1].items()), flush=True)
        if options.lines:
            costliest(sources)
    if not options.only:
        (ROOT / PAGE).write_text(pages.stamped(written(rows), made.took(time.monotonic() - began)), encoding="utf-8")
    return 0


def beside_package(engine: Path, folder: Path) -> Path:
    """The compiled engine in a copy of the package whose other files are links: that of the checkout stays as it is."""
    package = folder / "petzval"
    package.mkdir()
    for one in (ROOT / "engine" / "python" / "petzval").iterdir():
        if not one.name.startswith(("_native.", "_engines")) or one.suffix == ".pyi":
            (package / one.name).symlink_to(one)
    return Path(shutil.copy(engine, package / "_native.abi3.so"))


def profiled(path: Path, engine: Path) -> tuple[dict, Counter[Source], int, int]:
    """The seconds that the render tells; the looks in the engine by their place in the sources, and those in libraries and the system, while
    samples were taken; and the looks in which cores were idle meanwhile."""
    with tempfile.TemporaryDirectory() as folder:
        ready, told, data = (Path(folder) / name for name in ("scene.blend", "told.json", "perf.data"))
        python_path = f"{engine.parent.parent}{os.pathsep}{ROOT / 'tools'}"
        tools = os.environ | {"PYTHONPATH": python_path}
        run(sys.executable, "-m", "other_scenes.job", "prepare", path, ready, env=tools)
        command = [sys.executable, "-m", "petzval", "render", ready, "--camera", "pinhole", "--resolution", SIZE]
        command += [
            "--samples",
            SAMPLES,
            "--seed",
            SEED,
            "--noise-threshold",
            0,
            "--denoise",
            "off",
            "--checkpoint",
            "off",
        ]
        command += ["-o", Path(folder) / "out.exr", "--stats", told]
        run("perf", "record", "-q", "-F", FREQUENCY, "-e", "cpu-clock", "-o", data, "--", *command, env=tools)
        script = run("perf", "script", "-i", data, "--show-mmap-events", "-F", "time,event,ip,dso")
        seconds = json.loads(told.read_text())["seconds"]
    starts, looks = read(script, engine.name)
    if not starts:
        raise Failed("perf has not seen the engine")
    found = placed(engine, {look.address for look in looks if look.file == engine.name}, starts)
    times = [look.second for look in looks if found.get(look.address, NOWHERE).file.startswith(SAMPLING)]
    if not times:
        raise Failed("no path was followed")
    while_sampling = [look for look in looks if times[0] <= look.second <= times[-1]]
    inside = Counter(found[look.address] for look in while_sampling if look.file == engine.name)
    cores = os.cpu_count() or 1
    idle = round((times[-1] - times[0]) * FREQUENCY * cores) - len(while_sampling)
    return seconds, inside, len(while_sampling) - inside.total(), max(idle, 0)


def run(*command: object, env: dict[str, str] | None = None) -> str:
    """The output of a command that ends well."""
    done = subprocess.run(
        [*map(str, command)], capture_output=True, text=True, errors="replace", timeout=LONGEST_S, env=env, check=False
    )
    if done.returncode:
        raise Failed((done.stderr.strip().splitlines() or [f"exit {done.returncode}"])[-1][:200])
    return done.stdout


def read(script: str, engine: str) -> tuple[list[tuple[int, int, int]], list[Look]]:
    """The places of parts of the engine's file in memory (start, length, offset in the file), and the looks, in the order of time."""
    starts, looks = [], []
    mapped = re.compile(r"PERF_RECORD_MMAP2? .*\[(0x[0-9a-f]+)\((0x[0-9a-f]+)\) @ (0x[0-9a-f]+|0) .*/([^/\s]+)$")
    look = re.compile(r"^\s*([\d.]+):.*?\s([0-9a-f]+)\s+\((.*)\)\s*$")
    for line in script.splitlines():
        if (one := mapped.search(line)) is not None:
            if one[4] == engine:
                starts.append((int(one[1], 16), int(one[2], 16), int(one[3], 16)))
        elif (one := look.match(line)) is not None:
            looks.append(Look(float(one[1]), one[3].rpartition("/")[2], int(one[2], 16)))
    return starts, sorted(looks)


NOWHERE = Source("", "?", 0)


def placed(engine: Path, addresses: set[int], starts: list[tuple[int, int, int]]) -> dict[int, Source]:
    """The innermost place in the engine's own sources of each address in memory: code of libraries that is inlined counts for its caller."""
    number = r"(0x[0-9a-f]+)"
    loads = re.findall(rf"LOAD\s+{number} {number} {number} {number}", run("readelf", "-lW", engine))
    parts = [tuple(int(part, 16) for part in load) for load in loads]

    def in_file(address: int) -> int | None:
        for start, length, offset in starts:
            if start <= address < start + length:
                at = address - start + offset
                return next((at - low + virtual for low, virtual, _, size in parts if low <= at < low + size), None)
        return None

    known = {address: at for address in addresses if (at := in_file(address)) is not None}
    asked = "\n".join(map(hex, known.values()))
    symbolizer = ["llvm-symbolizer", "-e", str(engine), "--output-style=JSON", "--inlines"]
    done = subprocess.run(symbolizer, input=asked, capture_output=True, text=True, timeout=LONGEST_S, check=True)
    lines = [json.loads(line)["Symbol"] for line in done.stdout.splitlines() if line.strip()]
    found = {address: own(frames) for address, frames in zip(known, lines, strict=True)}
    return dict.fromkeys(addresses, NOWHERE) | found


def own(frames: list[dict]) -> Source:
    """The innermost frame that lies in the engine's sources; else the outermost function."""
    for frame in frames:
        _, is_own, file = frame["FileName"].rpartition("/engine/")
        if is_own:
            return Source(file, short(frame["FunctionName"]), frame["Line"])
    return Source("", short(frames[-1]["FunctionName"]) if frames else "?", 0)


def short(function: str) -> str:
    """The last parts of a function's name, without its types and its number."""
    name = re.sub(r"::h[0-9a-f]{16}$", "", function)
    while (bare := re.sub(r"<[^<>]*>", "", name)) != name:
        name = bare
    return "::".join(name.split("::")[-2:])


def shares(sources: Counter[Source], libraries: int, idle: int) -> dict[str, float]:
    """The parts of the processors' time while samples are taken, 0 to 1; all together are 1."""
    sums = Counter(dict.fromkeys([*PARTS, LIBRARIES, WAITING], 0))
    for source, looks in sources.items():
        fits = (name for name, folders in PARTS.items() if source.file.startswith(folders) and source.file)
        sums[next(fits, "other")] += looks
    sums[LIBRARIES] += libraries
    sums[WAITING] += idle
    return {part: looks / sums.total() for part, looks in sums.items()}


def costliest(sources: Counter[Source], rows: int = 25) -> None:
    whole = sources.total()
    functions, lines = Counter(), Counter()
    for source, looks in sources.items():
        functions[source.file, source.function] += looks
        lines[f"{source.file}:{source.line}"] += looks
    for counted in (functions, lines):
        for name, looks in counted.most_common(rows):
            print(f"  {looks / whole:6.1%} {name if isinstance(name, str) else ' '.join(name)}")


def written(rows: dict[str, tuple[dict, dict[str, float]]]) -> str:
    parts = [*PARTS, LIBRARIES, WAITING]
    lines = [
        "# Where the time of a sample goes",
        "",
        f"Scenes by others through a pinhole, {SIZE.replace('x', ' x ')} pixels, {SAMPLES} samples, all cores, by an engine of Cargo's profile `release`.",
        "Percent of the cores' time from the first path that is followed to the last, by the file that an instruction was written in:",
        "inlined functions count for their own file, those of libraries for their caller. Before that, s: export (*sync*), and trees, lights",
        "and tables (*trees*).",
        "",
        f"| scene | sync | trees | samples | {' | '.join(parts)} |",
        "|---|" + "---:|" * (len(parts) + 3),
    ]
    for name, (seconds, row) in sorted(rows.items()):
        told = " | ".join(f"{seconds[one]:.2f}" for one in ("sync", "bvh", "render"))
        lines.append(f"| {name} | {told} | " + " | ".join(f"{100 * row[part]:.0f}" for part in parts) + " |")
    if rows:
        middle = {part: sorted(row[part] for _, row in rows.values())[len(rows) // 2] for part in parts}
        lines.append("| *in the middle* | | | | " + " | ".join(f"{100 * middle[part]:.0f}" for part in parts) + " |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    raise SystemExit(main())
