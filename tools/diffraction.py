#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The effects of diffraction and glare: pictures and tables of docs/diffraction.md and docs/glare.md. Run by `make diffraction` in an
environment that has petzval, numpy, matplotlib and Pillow, with the folder of the engine's examples `starburst` and `glare`. `--quick` tries
it with one row of each table."""

from __future__ import annotations

import json
import math
import re
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pages
from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
LENSES = ROOT / "lenses"
IMAGES = ROOT / "docs/images"
SIZE = (1920, 1080)
FILM_MM = 36
NORMAL = "double-gauss-f2-tronnier"
#: Name, lens, f-number ("-": open), blades, place of the source, vanes of a spider.
BURSTS = (
    ("round, f/16", NORMAL, "16", 0, (0, 0), 0),
    ("5 blades, f/16", NORMAL, "16", 5, (0, 0), 0),
    ("6 blades, f/16", NORMAL, "16", 6, (0, 0), 0),
    ("7 blades, f/16", NORMAL, "16", 7, (0, 0), 0),
    ("9 blades, f/16", NORMAL, "16", 9, (0, 0), 0),
    ("9 blades, f/4", NORMAL, "4", 9, (0, 0), 0),
    ("wide open, f/2, off the axis", NORMAL, "-", 0, (0.3, 0.3), 0),
    ("Cassegrain, f/12", "cassegrain-f12", "-", 0, (0, 0), 0),
    ("the same, four vanes", "cassegrain-f12", "-", 0, (0, 0), 4),
)
#: Lens, f-numbers, defocus in mm.
HYBRID = (
    ("cooke-triplet-50mm", (5, 8, 16, 22), (0.0, 0.2)),
    (NORMAL, (2.8, 5.6, 11, 22), (0.0, 0.2)),
    ("plano-hyperbolic-50mm", (4, 8, 22), (0.0, 0.1, 0.5)),
)
#: Highest frequencies of pixels 1920 and 6000 to 36 mm, per mm.
PIXELS = (26.7, 83.3)
#: Roughness nm, level of dust.
SCATTERING = ((1, 0), (2, 0), (5, 0), (0, 100), (0, 300), (0, 500), (0, 750), (2, 300))
SPREAD = re.compile(r"(\d+) zones; made in (\S+) s, spread in (\S+) s; sum (\S+); least (\S+) of")
SCATTERED = re.compile(r"scattered (\S+) (\S+) (\S+); spread in (\S+) s")


def picture(file: Path) -> np.ndarray:
    """A .pfm, first row on top."""
    with file.open("rb") as f:
        assert f.readline() == b"PF\n"
        width, height = map(int, f.readline().split())
        f.readline()
        return np.frombuffer(f.read(), "<f4").reshape(height, width, 3)[::-1]


def shown(light: np.ndarray, low: float, high: float) -> np.ndarray:
    """Decades from `low` to `high` of values that are not negative, eight bits."""
    decades = np.log10(np.maximum(light, 10.0**low))
    return (np.clip((decades - low) / (high - low), 0.0, 1.0) * 255.0).astype(np.uint8)


def grid(tiles: list[np.ndarray], columns: int) -> Image.Image:
    black = np.zeros_like(tiles[0])
    tiles = tiles + [black] * (-len(tiles) % columns)
    rows = [np.concatenate(tiles[i : i + columns], 1) for i in range(0, len(tiles), columns)]
    return Image.fromarray(np.concatenate(rows, 0))


def run(*words: object) -> str:
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{words[0]}: {done.stderr.strip() or done.stdout.strip()}")
    return done.stdout


def processor() -> float:
    """Processor seconds of the programs that were run."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def bursts(examples: Path, folder: Path) -> list[str]:
    rows, tiles = [], []
    for name, lens, f_number, blades, (x, y), vanes in BURSTS:
        out, before = folder / "burst.pfm", processor()
        file = LENSES / f"{lens}.lens"
        said = run(examples / "starburst", file, f_number, blades, *SIZE, FILM_MM, out, f"{x},{y}", vanes)
        zones, _, _, _, least = SPREAD.search(said).groups()
        rows.append(f"| {name} | {zones} | {processor() - before:.1f} s | {least} |")
        # A third of the picture's width, about the source.
        light = picture(out)
        cx, cy = int((0.5 + x) * SIZE[0]), int((0.5 - y) * SIZE[1])
        left, top = min(max(cx - 480, 0), SIZE[0] - 960), min(max(cy - 270, 0), SIZE[1] - 540)
        tiles.append(shown(light[top : top + 540, left : left + 960], -3.0, 2.0)[::2, ::2])
    grid(tiles, 3).save(IMAGES / "diffraction-starbursts.png", optimize=True)
    return rows


def report(kind: str, lens: str, folder: Path, *more: object) -> dict:
    out = folder / "report.json"
    run(sys.executable, "-m", "petzval", "lens", kind, lens, *more, "-o", out)
    return json.loads(out.read_text())


def perfect(nu: float) -> float:
    return 0.0 if nu >= 1.0 else 2.0 / math.pi * (math.acos(nu) - nu * math.sqrt(1.0 - nu * nu))


def hybrid(folder: Path) -> list[str]:
    rows = []
    for lens, f_numbers, defocus in HYBRID:
        for n in f_numbers:
            for mm in defocus:
                cut = 1.0 / (550e-6 * n)
                asked = ("--f-number", n, "--wavelengths", 550, "--fields", 0, "--film-shift", mm)
                field = report("mtf", lens, folder, *asked, "--frequency", cut, "--steps", 40)["fields"][0]
                curve = field["sagittal"]
                product = [a * b for a, b in zip(curve["geometric"], curve["limit"], strict=True)]
                off = [p - c for p, c in zip(product, curve["contrast"], strict=True)]
                worst = max(off, key=abs)
                below = [max(abs(x) for i, x in enumerate(off) if i * cut / 40 <= rate) for rate in PIXELS]
                waves = mm / (8.0 * n * n * 550e-6)
                rows.append(f"| {lens} | {n} | {mm:g} | {waves:.2f} | {worst:+.3f} | {below[0]:.3f} | {below[1]:.3f} |")
    return rows


def limits(folder: Path) -> list[str]:
    rows = []
    for lens, n in (("newtonian-f5", 5), ("newtonian-f5", 22), ("plano-hyperbolic-50mm", 8), ("cassegrain-f12", 12)):
        asked = ("--f-number", n, "--wavelengths", 550, "--fields", 0)
        mtf = report("mtf", lens, folder, *asked, "--frequency", 1.0 / (550e-6 * n), "--steps", 20)
        field = mtf["fields"][0]
        off = max(abs(c - perfect(i / 20.0)) for i, c in enumerate(field["sagittal"]["contrast"]))
        psf = report("psf", lens, folder, *asked)
        spread = psf["fields"][0]
        airy = psf["airy_radius_mm"]
        ring = np.interp(airy, spread["radii_mm"], spread["encircled"])
        rows.append(f"| {lens} | {n} | {spread['strehl'][0]:.4f} | {100.0 * ring:.1f} % | {off:.4f} |")
    return rows


def glare(examples: Path, folder: Path) -> list[str]:
    rows, tiles = [], []
    for nm, level in SCATTERING:
        out, before = folder / "glare.pfm", processor()
        file = LENSES / f"{NORMAL}.lens"
        said = run(examples / "glare", file, 8, nm, level, 0, *SIZE, FILM_MM, out)
        red, green, blue, _ = map(float, SCATTERED.search(said).groups())
        seconds = processor() - before
        rows.append(
            f"| {nm} | {level} | {100 * red:.3f} % | {100 * green:.3f} % | {100 * blue:.3f} % | {seconds:.1f} s |"
        )
        if (nm, level) in ((2, 0), (0, 300), (2, 300)):
            tiles.append(shown(picture(out), -3.0, 1.5)[::3, ::3])
    out = folder / "glare.pfm"
    run(examples / "glare", LENSES / f"{NORMAL}.lens", 8, 2, 300, 0.01, *SIZE, FILM_MM, out)
    tiles.append(shown(picture(out), -3.0, 1.5)[::3, ::3])
    grid(tiles, 2).save(IMAGES / "glare.png", optimize=True)
    return rows


def filled(file: Path, name: str, rows: list[str]) -> None:
    """Puts rows between the marks of that name, below the head of the table there."""
    text = file.read_text()
    table_head = text.partition(f"<!-- {name} -->\n")[2].splitlines()[:2]
    file.write_text(pages.filled(text, name, [*table_head, *rows]))


def main() -> None:
    global BURSTS, HYBRID, SCATTERING
    if "--quick" in sys.argv[2:]:
        BURSTS, HYBRID, SCATTERING = BURSTS[:1], (("plano-hyperbolic-50mm", (8,), (0.0,)),), SCATTERING[:1]
    examples, began = Path(sys.argv[1]), time.monotonic()
    origins = {page: pages.made(page) for page in ("docs/diffraction.md", "docs/glare.md")}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for lens, out, more in (
            ("questar-3.5", "psf-questar.png", ()),
            ("cooke-triplet-50mm", "psf-blades.png", ("--f-number", "16", "--blades", "6", "--wavelengths", "550")),
        ):
            run(sys.executable, "-m", "petzval", "lens", "psf", lens, *more, "-o", IMAGES / out)
        diffraction = ROOT / "docs/diffraction.md"
        filled(diffraction, "limits", limits(folder))
        filled(diffraction, "hybrid", hybrid(folder))
        filled(diffraction, "bursts", bursts(examples, folder))
        filled(ROOT / "docs/glare.md", "scattered", glare(examples, folder))
    for page, origin in origins.items():
        pages.stamp(page, origin.took(time.monotonic() - began))


if __name__ == "__main__":
    main()
