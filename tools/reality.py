#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shipped lenses beside photographers' measurements of their products: docs/reality.md. Run by `make reality LENSFUN=FOLDER` in an
environment that has petzval and matplotlib. Lenses that are compared name their product in the header: `# lensfun: NAME`."""

from __future__ import annotations

import argparse
import json
import math
import os
import re
import statistics
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
from collections import defaultdict
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any

import lens_index
import numpy as np
import pages

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/reality.md"
PICTURES = ROOT / "docs/images/reality"
#: Marked focal lengths of zooms; the lens goes to the nearest that its patent has.
ZOOMS = {"nikkor-z-24-70-f4": (24, 28, 35, 50, 70), "canon-11-24-f4": (11, 14, 24)}
#: Real focal lengths over marked ones that are tried where a zoom stands between the positions of its patent.
REAL = (0.94, 0.96, 0.98, 1.0, 1.02)
#: Distances of the photographed lines that are tried, mm; a calibration does not say its own.
DISTANCES_MM = (10000, 5000, 3000, 2000, 1500, 1200, 1000, 800, 600, 500)
#: Powers of the height in the distortion of a lens of revolution, as far as the rays of these lenses need them.
EVEN_POWERS = (2, 4, 6)
#: Fields of a comparison.
COUNT = 15
#: The limits of agreement: micrometres, parts of the lens's own distortion, stops at F/8.
LEAST_UM, PART, STOPS = 10.0, 0.01, 0.15


class Refused(Exception):
    """The program's line about arguments that it does not take."""


def petzval(*arguments: object) -> Any:
    command = [sys.executable, "-m", "petzval", "lens", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise Refused(done.stderr)
    return json.loads(done.stdout) if "--json" in arguments else None


def lenses() -> dict[str, str]:
    """Files' names, and their texts, of lenses that name a product."""
    texts = {file.stem: file.read_text() for file in sorted((ROOT / "lenses").glob("*.lens"))}
    return {name: text for name, text in texts.items() if "\n# lensfun:" in text}


def positions(text: str) -> list[float]:
    """Focal lengths of a zoom's table, mm."""
    return [float(mm) for mm in re.findall(r"^# position: zoom=([\d.]+) focus=inf", text, re.MULTILINE)]


def at(name: str, lensfun: str, real_mm: float | None, marked_mm: float | None, *more: object) -> Any:
    given: list[object] = ["--lensfun", lensfun, *more]
    given += ["--focal-length", real_mm] if real_mm else []
    given += ["--marked", marked_mm] if marked_mm else []
    return petzval("reality", name, *given)


def settings(name: str, text: str) -> list[tuple[float | None, float | None, bool]]:
    """Real and marked focal lengths, and whether the real one stands between the positions of the patent."""
    known = positions(text)
    if not known:
        return [(None, None, False)]
    found = []
    for marked in ZOOMS[name]:
        real = min(max(float(marked), known[0]), known[-1])
        found.append((real, float(marked), real not in known))
    return found


def agrees(found: Any) -> bool:
    """True where the measurement and the rays are as near as they are asked to be."""
    one = found["distortion"]
    return one is not None and 1e3 * one["worst_mm"] <= max(LEAST_UM, 1e3 * PART * one["own_mm"])


def distortion_row(found: Any) -> str:
    one = found["distortion"]
    if one is None:
        return "not measured | | | |"
    rms, worst, own = (1e3 * one[key] for key in ("rms_mm", "worst_mm", "own_mm"))
    last = one["rows"][-1]
    return (
        f"{100 * last['rays_part']:.2f} | {100 * last['measured_part']:.2f} | {rms:.0f} / {worst:.0f} | {own:.0f} | "
        f"{odd_um(one['rows']):.0f}"
    )


def odd_um(rows: list[Any]) -> float:
    """Largest distance, micrometres, of the measured curve from the nearest curve of a lens of revolution, whose distortion has even
    powers of the height alone. The least squares are over the area of the picture."""
    heights = np.array([row["height_mm"] for row in rows[1:]])
    scales = 1.0 + np.array([row["measured_part"] for row in rows[1:]])
    parts = heights / heights[-1]
    curves = np.stack([parts**power for power in (0, *EVEN_POWERS)], axis=1)
    weights = parts**1.5
    terms = np.linalg.lstsq(curves * weights[:, None], scales * weights, rcond=None)[0]
    return float(1e3 * np.abs(heights * (curves @ terms - scales)).max())


def light_cells(found: Any) -> list[str]:
    cells = []
    for one in found["vignetting"]:
        rows = [row for row in one["rows"] if row["measured_stops"] is not None]
        if rows:
            worst = max((row["rays_stops"] - row["measured_stops"] for row in rows), key=abs)
            last = rows[-1]
            cells.append(f"{last['rays_stops']:.2f} / {last['measured_stops']:.2f} ({worst:+.2f})")
    return cells or ["not measured"]


def colour_cells(found: Any) -> str:
    if not found["colour"]:
        return "not measured | "
    last = found["colour"][-1]
    pair = [f"{1e3 * last[f'{key}_mm']:+.1f} / {1e3 * last[f'measured_{key}_mm']:+.1f}" for key in ("red", "blue")]
    return " | ".join(pair)


def formula(row: ElementTree.Element, crop: float) -> Callable[[float], float] | None:
    """The distorted radius by the straight one, mm, with the scale of the axis; `None` for rare models."""

    def term(key: str) -> float:
        return float(row.get(key, 0.0))

    if row.get("model") == "ptlens":
        a, b, c = term("a"), term("b"), term("c")
    elif row.get("model") == "poly3":
        a, b, c = 0.0, term("k1"), 0.0
    else:
        return None
    unit = math.hypot(36.0, 24.0) / crop / 2.0 / math.hypot(1.5, 1.0)
    d = 1.0 - a - b - c
    return lambda r: r * (1.0 + c / d**2 * r / unit + b / d**3 * (r / unit) ** 2 + a / d**4 * (r / unit) ** 3)


def apart_um(one: Callable[[float], float], other: Callable[[float], float], corner_mm: float) -> tuple[float, float]:
    """Root mean square over the area and largest distance of two distortions with one free scale, micrometres."""
    radii = [corner_mm * (i + 1) / 40.0 for i in range(40)]

    def square(scale: float) -> float:
        return sum(r * (one(scale * r) - other(r)) ** 2 for r in radii)

    low, high = 0.95, 1.05
    for _ in range(60):
        a, b = low + (high - low) / 3.0, high - (high - low) / 3.0
        low, high = (low, b) if square(a) < square(b) else (a, high)
    left = [one(low * r) - other(r) for r in radii]
    rms = math.sqrt(sum(r * x * x for r, x in zip(radii, left, strict=True)) / sum(radii))
    return 1e3 * rms, 1e3 * max(map(abs, left))


def spread(lensfun: str) -> list[str]:
    """A row of the page: the distance of two measurements of one product, made with two sensors; over all products of the database."""
    place = Path(lensfun)
    files = sorted(place.glob("*.xml")) if place.is_dir() else [place]
    known: dict[tuple[str, float], dict[float, Callable[[float], float]]] = defaultdict(dict)
    for lens in (lens for file in files for lens in ElementTree.parse(file).getroot().findall("lens")):
        crop = float(lens.findtext("cropfactor") or 1.0)
        if lens.find("aspect-ratio") is None and lens.find("type") is None:
            for row in lens.iterfind("calibration/distortion"):
                if (found := formula(row, crop)) is not None:
                    known[lens.findtext("model") or "", float(row.get("focal", 0.0))][crop] = found
    pairs = [
        (product, apart_um(by_crop[a], by_crop[b], 0.5 * math.hypot(36.0, 24.0) / b))
        for (product, _), by_crop in known.items()
        for a, b in combinations(sorted(by_crop), 2)
    ]
    if len(pairs) < 4:
        return []
    worst = statistics.quantiles([largest for _, (_, largest) in pairs], n=4)
    rms = statistics.median(rms for _, (rms, _) in pairs)
    products = len({product for product, _ in pairs})
    return ["", f"| {len(pairs)} | {products} | {rms:.0f} | {worst[0]:.0f} | {worst[1]:.0f} | {worst[2]:.0f} |", ""]


@dataclass(frozen=True)
class Nearest:
    """A comparison at a real focal length and at a distance of the photographed lines; `None`: those of the lens file, infinity."""

    found: Any
    real_mm: float | None
    distance_mm: float | None

    def apart_mm(self) -> float:
        return float(self.found["distortion"]["rms_mm"])


@dataclass(frozen=True)
class Case:
    """A lens at a setting: the arguments of the engine."""

    name: str
    text: str
    real_mm: float | None
    marked_mm: float | None
    is_between: bool

    def ask(self, lensfun: str) -> tuple[Any, Any, Nearest | None]:
        """The comparison, the same through another sensor, and the nearest one, if it does not agree as it is."""
        found = at(self.name, lensfun, self.real_mm, self.marked_mm, "--json", "--count", COUNT)
        other = at(self.name, lensfun, self.real_mm, self.marked_mm, "--json", "--sensor", "nikon-d700", "--count", 3)
        return found, other, self.nearest(lensfun, found) if found["distortion"] and not agrees(found) else None

    def nearest(self, lensfun: str, found: Any) -> Nearest | None:
        """The nearest comparison over the real focal lengths, for a zoom between the positions of its patent, and then over distances;
        `None`: that is the one at infinity."""
        best = Nearest(found, self.real_mm, None)
        tried: list[tuple[float | None, float | None]] = []
        if self.is_between and self.marked_mm:
            ends = positions(self.text)
            tried = [(k * self.marked_mm, None) for k in REAL if ends[0] <= k * self.marked_mm <= ends[-1]]
            best = min([best, *self.compared(lensfun, tried)], key=Nearest.apart_mm)
        best = min(
            [best, *self.compared(lensfun, [(best.real_mm, float(mm)) for mm in DISTANCES_MM])], key=Nearest.apart_mm
        )
        return None if best.found is found else best

    def compared(self, lensfun: str, tried: list[tuple[float | None, float | None]]) -> list[Nearest]:
        """Comparisons at real focal lengths and distances, without those that are too close for the lens."""
        every = []
        for real_mm, distance_mm in tried:
            more: list[object] = ["--focus-distance", distance_mm] if distance_mm else []
            try:
                found = at(self.name, lensfun, real_mm, self.marked_mm, "--json", "--count", COUNT, *more)
            except Refused as why:
                if "too close for this lens" not in str(why):
                    raise
            else:
                every.append(Nearest(found, real_mm, distance_mm))
        return every


def drawn(name: str, lensfun: str, real_mm: float | None, marked_mm: float | None) -> None:
    """The picture of a lens, at its first setting."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    picture = PICTURES / f"{name}.svg"
    at(name, lensfun, real_mm, marked_mm, "-o", picture)
    picture.write_text(lens_index.compact(picture.read_text(encoding="utf-8")), encoding="utf-8")


def tables(lensfun: str, only: list[str], draw: bool) -> dict[str, list[str]]:
    """Rows of the page by their marks."""
    asked = {name: text for name, text in lenses().items() if not only or name in only}
    cases = [Case(name, text, *one) for name, text in asked.items() for one in settings(name, text)]
    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        answers = list(pool.map(lambda case: case.ask(lensfun), cases))
        if draw:
            firsts = {case.name: case for case in reversed(cases)}.values()
            list(pool.map(lambda case: drawn(case.name, lensfun, case.real_mm, case.marked_mm), firsts))
    rows: dict[str, list[str]] = {"distortion": [], "vignetting": [], "colour": [], "curves": []}
    for case, (found, other, best) in zip(cases, answers, strict=True):
        marked = f"{found['marked_mm']:g}"
        shown = [(f"`{case.name}`", Nearest(found, case.real_mm, None))] + ([("its best", best)] if best else [])
        for label, one in shown:
            metres = f"{one.distance_mm / 1000.0:g}" if one.distance_mm else "∞"
            rows["distortion"].append(
                f"| {label} | {marked} | {one.found['efl_mm']:.2f} | {metres} | {distortion_row(one.found)} | "
                f"{'agrees' if agrees(one.found) else ''} |"
            )
        light = light_cells(found)
        rows["vignetting"].append(f"| `{case.name}` | {marked} | {light[0]} | {light[-1] if len(light) > 1 else ''} |")
        rows["colour"].append(f"| `{case.name}` | {marked} | {colour_cells(found)} | {colour_cells(other)} |")
        picture = f"![{case.name} beside {found['product']}](images/reality/{case.name}.svg)"
        rows["curves"] += [picture, ""] if picture not in rows["curves"] else []
    heads = {
        "distortion": ["| lens | marked, mm | rays, mm | distance, m | % by rays | % measured | apart, um | own, um | odd, um | |", "|---|---:|---:|---:|---:|---:|---:|---:|---:|---|"],
        "vignetting": ["| lens | marked, mm | wide open | F/8 |", "|---|---:|---|---|"],
        "colour": ["| lens | marked, mm | red, um | blue, um | Nikon D700: red | blue |", "|---|---:|---|---|---|---|"],
        "curves": [],
    }  # fmt: skip
    written = {mark: ["", *heads[mark], *found_rows, ""] for mark, found_rows in rows.items()}
    if pairs := spread(lensfun):
        head = "| pairs | products | mean square, um | largest: a quarter below, um | half | three quarters |"
        written["spread"] = ["", head, "|---:|---:|---:|---:|---:|---:|", *pairs[1:]]
    return written


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("lensfun", help="a lensfun database: an .xml file, or the folder that holds them")
    parser.add_argument("--only", nargs="+", default=[], metavar="LENS", help="these lenses; prints, writes nothing")
    given = parser.parse_args()
    began, origin = time.monotonic(), pages.made("docs/reality.md")
    try:
        found = tables(given.lensfun, given.only, draw=not given.only)
    except Refused as why:
        raise SystemExit(str(why)) from None
    if given.only:
        print("\n".join(row for rows in found.values() for row in rows))
        return
    text = PAGE.read_text(encoding="utf-8")
    for mark, rows in found.items():
        text = pages.filled(text, mark, rows)
    PAGE.write_text(text, encoding="utf-8")
    pages.stamp("docs/reality.md", origin.took(time.monotonic() - began))


if __name__ == "__main__":
    main()
