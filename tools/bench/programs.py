# SPDX-License-Identifier: GPL-3.0-or-later
"""The programs that are compared, the cameras of each, and one measurement in a process of its own."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from dataclasses import asdict, dataclass, field
from pathlib import Path

from . import MARK, double_gauss

TOP = Path(__file__).resolve().parents[2]
WORK = TOP / "output" / "bench"
LENS = TOP / "lenses" / "double-gauss-f2-available.lens"

PETZVAL, CYCLES, SCALAR, LLVM = "petzval", "cycles", "scalar_rgb", "llvm_ad_rgb"
NAMES = {PETZVAL: "Petzval", CYCLES: "Cycles", SCALAR: "Mitsuba scalar_rgb", LLVM: "Mitsuba llvm_ad_rgb"}
CAMERAS = {
    "pinhole": "pinhole",
    "thin": "thin lens",
    "lens-one": "exact lens, one wavelength",
    "lens": "exact lens, spectrum",
}
#: The cameras of each program.
CAN = {
    PETZVAL: ("pinhole", "thin", "lens-one", "lens"),
    CYCLES: ("pinhole", "thin", "lens-one"),
    SCALAR: ("pinhole", "thin"),
    LLVM: ("pinhole", "thin"),
}


class Failed(Exception):
    """A program could not run; the message says why."""


@dataclass
class Job:
    """One process: a scene, a camera, and the renders one after the other (samples a pixel, seed)."""

    program: str
    camera: str
    size: tuple[int, int] = (16, 9)
    renders: list[tuple[int, int]] = field(default_factory=list)
    scene: str = "small"
    threads: int = 2
    keep: bool = False


class Bench:
    """The places of the programs, their versions, and the programs that are missing."""

    def __init__(self) -> None:
        self.blender_python = _first(".venv-bpy52", ".venv-bpy45")
        self.missing: list[str] = []
        self.versions: dict[str, str] = {}
        self._environment = dict(os.environ)
        # Relative paths would end with the folder.
        paths = [str(TOP / "tools"), *map(os.path.abspath, filter(None, [os.environ.get("PYTHONPATH")]))]
        self._environment["PYTHONPATH"] = os.pathsep.join(paths)
        self.lens: dict = {}
        self.osl_lost = 0.0

    def set_up(
        self, scenes: tuple[str, ...], focus_m: float, focal_mm: float, f_number: float, *, with_llvm: bool
    ) -> None:
        """Writes the scenes for all programs, and the lens for Cycles; looks for an LLVM if wanted."""
        for name in scenes:
            self.versions["Blender"] = self._process("build", Job("build", "", scene=name))[0]["version"]
        command = [self.blender_python, "-m", "petzval", "lens", "info", str(LENS), "--json"]
        command += ["--focal-length", f"{focal_mm:g}", "--f-number", f"{f_number:g}"]
        command += ["--focus-distance", f"{1000.0 * focus_m:g}"]
        done = subprocess.run(command, capture_output=True, text=True, env=self._environment, check=False)
        if done.returncode:
            raise Failed(f"petzval cannot run: {_last_line(done.stderr)}: make build")
        self.lens = {"path": str(LENS), "focal_length_mm": focal_mm, "f_number": f_number}
        optics = double_gauss.read(LENS, json.loads(done.stdout))
        (WORK / "double-gauss.osl").write_text(double_gauss.script(optics, 36.0, 20.25))
        places = [(x + 0.5, y + 0.5) for x in range(-18, 18, 2) for y in range(-10, 10, 2)]
        self.osl_lost = sum(double_gauss.exposure(optics, x, y)[1] for x, y in places) / len(places)
        if with_llvm:
            self._find_llvm()

    def programs(self) -> list[str]:
        """The programs that can run here."""
        return [program for program in NAMES if program != LLVM or "DRJIT_LIBLLVM_PATH" in self._environment]

    def run(self, job: Job) -> list[dict]:
        """Runs the process; returns its results for each render."""
        return self._process(f"{NAMES.get(job.program, job.program)}, {job.camera}, {job.scene}", job)

    def _process(self, title: str, job: Job) -> list[dict]:
        of_mitsuba = job.program in (SCALAR, LLVM)
        python = sys.executable if of_mitsuba else self.blender_python
        about = asdict(job) | {
            "folder": str(WORK / "scenes" / job.scene),
            "picture": str(WORK / "pictures" / f"{job.program}-{job.camera}-{job.scene}"),
            "lens": self.lens,
            "script": str(WORK / "double-gauss.osl"),
        }
        module = "bench.mitsuba_job" if of_mitsuba else "bench.blender_job"
        command = [python, "-m", module, json.dumps(about)]
        done = subprocess.run(command, capture_output=True, text=True, errors="replace", env=self._environment, check=False)  # fmt: skip
        found = [json.loads(line.removeprefix(MARK)) for line in done.stdout.splitlines() if line.startswith(MARK)]
        expected = max(len(job.renders), 1)
        if done.returncode or len(found) != expected:
            raise Failed(f"{title}: {_last_line(done.stderr) or _last_line(done.stdout) or 'it said nothing'}")
        return found

    def _find_llvm(self) -> None:
        """The newest LLVM that can render: some versions know too little of a new processor."""
        given = os.environ.get("DRJIT_LIBLLVM_PATH")
        found = [Path(given)] if given else _llvm_libraries()
        for library in found:
            self._environment["DRJIT_LIBLLVM_PATH"] = str(library)
            try:
                self.run(Job(LLVM, "pinhole", renders=[(1, 1)]))
            except Failed:
                continue
            self.versions["LLVM"] = str(library)
            return
        self._environment.pop("DRJIT_LIBLLVM_PATH", None)
        tried = ", ".join(library.name for library in found) or "none found"
        self.missing.append(
            f"{NAMES[LLVM]}: no LLVM that it can use ({tried}): install libllvm19 or newer, or Rust by rustup"
        )


def _first(*folders: str) -> str:
    for folder in folders:
        python = TOP / folder / "bin" / "python"
        if python.exists():
            return str(python)
    raise Failed("no Python with bpy: make build")


def _llvm_libraries() -> list[Path]:
    """The system's, and that of the Rust compiler: newest first."""
    by_version: dict[int, Path] = {}
    asked = subprocess.run(["rustc", "--print", "sysroot"], capture_output=True, text=True, check=False, cwd=TOP)
    of_rust = [f"{asked.stdout.strip()}/lib"] if asked.returncode == 0 else []
    for folder in ("/usr/lib", "/usr/lib64", "/usr/local/lib", *of_rust):
        for pattern in ("libLLVM*.so*", "*/libLLVM*.so*", "llvm-*/lib/libLLVM*.so*"):
            for path in sorted(Path(folder).glob(pattern)):
                version = re.search(r"LLVM(?:-|\.so\.)(\d+)", path.name)
                # A linker script of that name is no library.
                if version and path.stat().st_size > 1_000_000:
                    by_version.setdefault(int(version[1]), path)
    return [by_version[version] for version in sorted(by_version, reverse=True)]


def _last_line(text: str) -> str:
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[-1] if lines else ""
