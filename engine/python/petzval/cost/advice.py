# SPDX-License-Identifier: GPL-3.0-or-later
"""The advice that follows from the numbers for a user who has to choose: a few sentences, computed. Plain Python."""

from __future__ import annotations

import math
from typing import Any

from .ladder import is_camera

#: The relative difference below which times are called the same.
ALIKE = 0.05
#: The part of an error that may be bias without being seen beside the noise.
UNSEEN = 0.1
#: Standard errors.
SURELY = 2.0


def percent(rel_mse: float) -> str:
    """An error in readable form: that of a pixel relative to its brightness."""
    part = 100.0 * math.sqrt(max(rel_mse, 0.0))
    return f"{part:.2g} %" if part < 9.95 else f"{part:.0f} %"


def seconds(value: float) -> str:
    if value < 9.95:
        return f"{value:.2g} s"
    return f"{value:.0f} s" if value < 99.5 else f"{value / 60.0:.3g} min"


def seconds_to(row: dict[str, Any], error: float, found: dict[str, Any]) -> float | None:
    """The time until a rung's error is down to `error`, s; None where it never is."""
    left = error - row["bias"]
    if left <= 0.0:
        return None
    pixels = found["size"][0] * found["size"][1]
    seconds: float = row["setup_s"] + 1e-6 * row["us_a_sample"] * pixels * max(row["noise_of_one_sample"] / left, 1.0)
    return seconds


def advice(found: dict[str, Any]) -> list[str]:
    """Sentences; the first names the camera to use."""
    rows = {row["key"]: row for row in found["rungs"] if row["is_measured"]}
    auto, top = rows["auto"], rows["hero"]
    goal = auto["rel_mse"]
    cameras = [row for row in rows.values() if is_camera(row)]
    times = {row["key"]: seconds_to(row, goal, found) for row in cameras}
    reach = {key: time_s for key, time_s in times.items() if time_s is not None}
    able = [row for row in cameras if row["key"] in reach and _is_true(row, goal)]
    best = min(able, key=lambda row: reach[row["key"]], default=auto)
    margin = ALIKE + _unsure(auto) + _unsure(best)
    choose = auto if "auto" in reach and reach["auto"] <= (1.0 + margin) * reach[best["key"]] else best
    what = f"{found['samples']} samples a pixel take {seconds(auto['seconds'])}"
    said = [
        f"Use {choose['name'].split(':')[0]}. "
        + (
            f"{what.capitalize()}, {auto['ratio']:.2f} times the {rows[found['base']]['name']}'s time, and leave pixels "
            f"{percent(goal)} off, {_kind(auto)}."
            if choose is auto
            else f"It leaves pixels {percent(goal)} off after {seconds(reach[choose['key']])}; by auto, {what}."
        )
    ]
    if choose is auto and top["us_a_sample"] > 0.0:
        said.append(_beside(auto, top, reach))
    never = [row for row in cameras if row["bias"] > goal]
    if never:
        never.sort(key=lambda row: row["bias"])
        parts = [f"{row['name']} {percent(row['bias'])}" for row in never]
        said.append(f"However long they run, some stay off by more: {', '.join(parts)}.")
    effects = [row for row in rows.values() if row["group"] == "effect" and row["bias"] > 0.0]
    if effects:
        worst = max(effects, key=lambda row: row["bias"])
        said.append(
            f"Of the lens's effects {worst['effect'].replace('_', ' ')} changes this picture most: without it, pixels are "
            f"{percent(worst['bias'])} off."
        )
    return said


def _unsure(row: dict[str, Any]) -> float:
    """The relative half width of a time's interval; a quarter without an interval."""
    interval = row.get("ratio_interval")
    return 0.25 if interval is None else (interval[1] - interval[0]) / (2.0 * row["ratio"])


def _is_true(row: dict[str, Any], goal: float) -> bool:
    """Surely nothing but noise is left at that error: whoever asks for a lens asks for its picture, and a simpler camera's is
    another, however little noise it has. The ways to all wavelengths are the truth by themselves."""
    is_full = row["key"] in ("film", "scene", "hero")
    return is_full or row["bias_estimate"] + SURELY * row["bias_uncertainty"] <= UNSEEN * goal


def _kind(row: dict[str, Any]) -> str:
    part = row["bias"] / row["rel_mse"]
    if row["bias"] == 0.0:
        return "all of it noise"
    return f"noise but for {percent(row['bias'])}" if part < 0.5 else f"most of it for good ({percent(row['bias'])})"


def _beside(auto: dict[str, Any], top: dict[str, Any], reach: dict[str, float]) -> str:
    """Auto against everything on."""
    mine, full = reach.get("auto"), reach.get("hero")
    if full is None or mine is None:
        return ""
    times = full / mine
    if abs(times - 1.0) <= ALIKE:
        return "Everything on, all wavelengths, takes as long for the same error."
    if times >= 2.0:
        return f"Everything on, all wavelengths, takes {times:.1f} times as long for the same error."
    word = "longer" if times > 1.0 else "less time"
    return f"Everything on, all wavelengths, takes {abs(times - 1.0):.0%} {word} for the same error."
