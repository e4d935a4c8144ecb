# SPDX-License-Identifier: GPL-3.0-or-later
"""The closing lines of `make demo`: demo_report.py IMAGE STATS.json"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "engine/python"))

from petzval.plan_command import cost, size  # noqa: E402

#: The names of the phases, by the keys of the statistics' `seconds`.
PHASES = {
    "sync": "reading the scene",
    "bvh": "building BVHs",
    "plan": "planning effects",
    "render": "rendering",
    "denoise": "denoising",
    "pupil_map": "mapping the pupil",
}


def phases(seconds: dict[str, Any]) -> list[tuple[str, float]]:
    """Every phase with its time in seconds; a phase of several parts, such as stray light, has a row for each part."""
    rows = []
    for key, value in seconds.items():
        if isinstance(value, dict):
            rows += phases(value)
        elif value is not None:
            rows.append((PHASES.get(key, key), float(value)))
    return rows


def effect_line(row: dict[str, Any]) -> str:
    """One effect of the plan: the decision, its measure beside the tolerance, and the cost of simulating it."""
    name, price = row["effect"].replace("_", " "), cost(row)
    priced = "" if price == "-" else f", {price}"
    return f"{name:<18}  {row['decision']:<3}  {size(row)}, tolerance {row['tolerance']:.3g}{priced}"


def lines(image: str, stats: dict[str, Any]) -> list[str]:
    """The report on a render from its statistics (`petzval render --stats`)."""
    rows = phases(stats["seconds"])
    lost = stats["camera_rays_lost"] / max(stats["camera_rays"], 1)
    return [
        f"image       {image}",
        f"resolution  {stats['width']} x {stats['height']}",
        f"samples     {stats['samples']}",
        f"seconds     {sum(value for _, value in rows):.1f}: "
        + ", ".join(f"{name} {value:.1f}" for name, value in rows),
        f"processor   {stats['processor']}, {stats['threads']} threads",
        f"lens        {stats['lens']}",
        f"lost        {100.0 * lost:.2f} % of the camera rays",
        "effects",
        *(f"  {effect_line(row)}" for row in stats["plan"]),
    ]


if __name__ == "__main__":
    picture, statistics = sys.argv[1:]
    print("\n".join(lines(picture, json.loads(Path(statistics).read_text()))))
