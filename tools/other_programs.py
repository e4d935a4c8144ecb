#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lenses by rayoptics and optiland beside the same by Petzval: the tables of docs/other-programs.md. Run by `make other-programs` in an
environment that has petzval. The results of the other programs are in tests/reference/foreign, written by tools/foreign-figures.py."""

from __future__ import annotations

import json
import math
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pages

ROOT = Path(__file__).resolve().parent.parent
PAGE, FOREIGN = ROOT / "docs/other-programs.md", ROOT / "tests/reference/foreign"
LENSES = ROOT / "tests/reference/lenses"
D_NM = 587.5618
#: Files in inches; all others are in millimetres.
MM_PER_UNIT = {"questar35.seq": 25.4}
#: The files that are not compared, and why.
LEFT_OUT = {
    ("landscape_lens.seq", "optiland"): "optiland takes CODE V's curvatures for radii where RDM does not say",
}


def petzval(*arguments: object, stdin: str | None = None) -> dict[str, Any]:
    command = [sys.executable, "-m", "petzval", *map(str, arguments), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, input=stdin)
    if done.returncode:
        raise SystemExit(done.stderr)
    return json.loads(done.stdout)


def _read(name: str) -> dict[str, Any]:
    found = json.loads((FOREIGN / name).read_text())
    return {key: value for key, value in found.items() if not key.startswith("_")}


def _apart(found: float, wanted: float) -> str:
    return f"{abs(abs(found) / abs(wanted) - 1.0):.0e}"


def _rays(file: Path, figure: dict[str, Any], unit_mm: float) -> tuple[int, float]:
    """Number of rays that are compared, and the largest difference of the directions in which they leave."""
    asked = [
        {
            "origin": [unit_mm * x for x in ray["origin"]],
            "direction": [x / math.hypot(*ray["direction"]) for x in ray["direction"]],
            "wavelength_nm": figure["wavelength_nm"],
        }
        for ray in figure["rays"]
    ]
    found = petzval("lens", "trace", file, "--rays", "-", stdin=json.dumps({"rays": asked}))["rays"]
    # Rays that slant start elsewhere where a file has planes that mean nothing before its lens.
    pairs = [
        math.dist(ours["direction"], theirs["out"])
        for ours, theirs in zip(found, figure["rays"], strict=True)
        if ours["status"] == "ok" and (len(ours["hits"]) == len(theirs["hits"]) or theirs["direction"][1] == 0.0)
    ]
    return len(pairs), max(pairs, default=0.0)


def files() -> list[str]:
    rows = [
        "| file | program | focal length | Petzval's | apart | entrance pupil, apart | rays | directions, apart |",
        "|---|---|---:|---:|---:|---:|---:|---:|",
    ]
    for name, of_file in _read("figures.json").items():
        unit_mm = MM_PER_UNIT.get(name, 1.0)
        for program, figure in of_file.items():
            if (name, program) in LEFT_OUT:
                continue
            info = petzval("lens", "info", FOREIGN / name, "--wavelength", figure["wavelength_nm"])
            efl_mm, radius_mm = abs(figure["efl"]) * unit_mm, figure["entrance_pupil_radius"] * unit_mm
            ours_mm = 0.5 * info["entrance_pupil"]["diameter_mm"]
            count, apart = _rays(FOREIGN / name, figure, unit_mm) if "rays" in figure else (0, 0.0)
            rays = f"{count} | {apart:.0e}" if count else "|"
            rows.append(
                f"| {name} | {program} | {efl_mm:.5f} | {abs(info['efl_mm']):.5f} | {_apart(info['efl_mm'], efl_mm)} | "
                f"{_apart(ours_mm, radius_mm)} | {rays} |"
            )
    return rows


def fields() -> list[str]:
    rows = [
        "| lens | field | distortion | Petzval's | tangential focus, mm | Petzval's | sagittal focus, mm | Petzval's |",
        "|---|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for name, table in _read("reports.json").items():
        lens = LENSES / f"{name}.lens"
        back_mm = petzval("lens", "info", lens, "--wavelength", D_NM)["bfd_mm"]
        angles = table["fields_deg"][1:]
        found = petzval(
            "lens", "distortion", lens, "--fields", *angles, "--wavelengths", D_NM,
            f"--film-shift={table['film_from_last_vertex_mm'] - back_mm}",
        )  # fmt: skip
        last = found["fields"][-1]
        distortion = 100.0 * (last["height_mm"] / last["straight_height_mm"] - 1.0)
        wanted = [table[key][-1] for key in ("distortion_percent", "tangential_focus_mm", "sagittal_focus_mm")]
        rows.append(
            f"| {name} | {angles[-1]:g}° | {wanted[0]:.6f} % | {distortion:.6f} % | {wanted[1]:.6f} | {last['tangential_focus_mm']:.6f} | "
            f"{wanted[2]:.6f} | {last['sagittal_focus_mm']:.6f} |"
        )
    return rows


def tolerances() -> list[str]:
    rows = [
        "| lens | deviation | surfaces | spot by optiland, µm | Petzval's | distortion by optiland, % | Petzval's |",
        "|---|---|---|---:|---:|---:|---:|",
    ]
    for name, table in _read("tolerances.json").items():
        lens = LENSES / f"{name}.lens"
        back_mm = petzval("lens", "info", lens, "--wavelength", D_NM)["bfd_mm"]
        found = petzval(
            "lens", "tolerance", lens, "--fields", "0", table["field_deg"], "--wavelengths", D_NM,
            f"--film-shift={table['film_from_last_vertex_mm'] - back_mm}", "--pupil-diameter", table["pupil_diameter_mm"],
            "--compensator", "none", "--trials", "2", "--rays", "41",
        )  # fmt: skip
        ours = {(one["kind"], one["first"], one["last"]): one["plus"] for one in found["sensitivities"]}

        def row(name: str, what: str, where: str, theirs: dict[str, float], own: dict[str, float]) -> str:
            return (
                f"| {name} | {what} | {where} | {1e3 * theirs['rms_mm']:.3f} | {1e3 * own['rms_mm']:.3f} | "
                f"{theirs['distortion_percent']:.6f} | {own['distortion_percent']:.6f} |"
            )

        rows.append(row(name, "none", "", table["nominal"], found["nominal"]))
        for one in sorted(table["deviations"], key=lambda one: -one["rms_mm"])[:8]:
            first, last = one["first"], one["last"]
            where = f"{first}" if first == last else f"{first} to {last}"
            rows.append(row("", one["kind"].replace("_", " "), where, one, ours[one["kind"], first, last]))
    return rows


def main() -> None:
    began, origin = time.monotonic(), pages.made("docs/other-programs.md")
    text = PAGE.read_text()
    for mark, table in (("files", files), ("fields", fields), ("tolerances", tolerances)):
        text = pages.filled(text, mark, table())
    PAGE.write_text(text)
    pages.stamp("docs/other-programs.md", origin.took(time.monotonic() - began))


if __name__ == "__main__":
    main()
