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
import pages

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/reality.md"
PICTURES = ROOT / "docs/images/reality"
#: Marked focal lengths of zooms; the lens goes to the nearest that its patent has.
ZOOMS = {"nikkor-z-24-70-f4": (24, 28, 35, 50, 70), "canon-11-24-f4": (11, 14, 24)}
#: Real focal lengths over marked ones that are tried where a zoom stands between the positions of its patent.
REAL = (0.94, 0.96, 0.98, 1.0, 1.02)
#: The limits of agreement: micrometres, parts of the lens's own distortion, stops at F/8.
LEAST_UM, PART, STOPS = 10.0, 0.01, 0.15


def petzval(*arguments: object) -> Any:
    command = [sys.executable, "-m", "petzval", "lens", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(done.stderr)
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


def distortion_row(found: Any) -> tuple[str, bool]:
    one = found["distortion"]
    if one is None:
        return "not measured | | |", False
    rms, worst, own = (1e3 * one[key] for key in ("rms_mm", "worst_mm", "own_mm"))
    last = one["rows"][-1]
    agrees = worst <= max(LEAST_UM, PART * own)
    return (
        f"{100 * last['rays_part']:.2f} | {100 * last['measured_part']:.2f} | {rms:.0f} / {worst:.0f} | {own:.0f}",
        agrees,
    )


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
class Case:
    """A lens at a setting: the arguments of the engine."""

    name: str
    text: str
    real_mm: float | None
    marked_mm: float | None
    is_between: bool

    def ask(self, lensfun: str) -> tuple[Any, Any, Any]:
        """The comparison, the same through another sensor, and that at the real focal length which is nearest, if one is looked for."""
        found = at(self.name, lensfun, self.real_mm, self.marked_mm, "--json", "--count", 15)
        other = at(self.name, lensfun, self.real_mm, self.marked_mm, "--json", "--sensor", "nikon-d700", "--count", 3)
        if not (self.is_between and self.marked_mm and found["distortion"]):
            return found, other, None
        ends = positions(self.text)
        tried = [k * self.marked_mm for k in REAL if ends[0] <= k * self.marked_mm <= ends[-1]]
        every = [at(self.name, lensfun, mm, self.marked_mm, "--json", "--count", 7) for mm in tried]
        return found, other, min(every, key=lambda one: one["distortion"]["rms_mm"])


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
        for label, one in ((f"`{case.name}`", found), ("its best", best)):
            if one is not None:
                cells, agrees = distortion_row(one)
                rows["distortion"].append(
                    f"| {label} | {marked} | {one['efl_mm']:.2f} | {cells} | {'agrees' if agrees else ''} |"
                )
        light = light_cells(found)
        rows["vignetting"].append(f"| `{case.name}` | {marked} | {light[0]} | {light[-1] if len(light) > 1 else ''} |")
        rows["colour"].append(f"| `{case.name}` | {marked} | {colour_cells(found)} | {colour_cells(other)} |")
        picture = f"![{case.name} beside {found['product']}](images/reality/{case.name}.svg)"
        rows["curves"] += [picture, ""] if picture not in rows["curves"] else []
    heads = {
        "distortion": ["| lens | marked, mm | rays, mm | % by rays | % measured | apart, um | own, um | |", "|---|---:|---:|---:|---:|---:|---:|---|"],
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
    found = tables(given.lensfun, given.only, draw=not given.only)
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
