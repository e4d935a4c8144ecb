# SPDX-License-Identifier: GPL-3.0-or-later
"""costs.json as a page in Blender: each camera's error over its time, and their table. Drawn by `petzval.plotting`."""

from __future__ import annotations

import math
from typing import Any

from ..plotting.figure import Figure, Lettering
from .advice import advice, percent, seconds
from .ladder import is_camera

_SIZE_IN = (12.0, 6.2)
_SIMPLE, _LENS, _FULL, _AUTO, _DARK = "#c77700", "#1f6fb4", "#2a8a4a", "#c1272d", "#444444"
_COLOURS = {"pinhole": _SIMPLE, "thin": _SIMPLE, "thick": _SIMPLE, "paraxial": _SIMPLE, "film": _FULL, "scene": _FULL,
            "hero": _FULL, "auto": _AUTO}  # fmt: skip
#: Parts of the page: where the table's columns stand, its first row and a row's height.
_COLUMNS, _TOP, _ROW = (0.61, 0.83, 0.905, 0.98), 0.8, 0.042
_LETTERS_OF_A_LINE = 118


def cameras(found: dict[str, Any]) -> list[dict[str, Any]]:
    """The rungs that are cameras and were measured, the fastest first."""
    rows = [row for row in found["rungs"] if row["is_measured"] and is_camera(row)]
    return sorted(rows, key=lambda row: row["seconds"])


def picture(found: dict[str, Any], lettering: Lettering) -> Any:
    """(height, width, 4), first row at the bottom, sRGB."""
    figure = Figure(_SIZE_IN, lettering)
    axes = figure.add_axes((0.07, 0.22, 0.48, 0.62))
    rows = cameras(found)
    front = [row for row in rows if row["is_on_front"]]
    # From camera to camera nothing is nearer until the next one's time.
    corners = [(row["seconds"], _error(row)) for row in front]
    steps = [corners[0]] if corners else []
    for before, after in zip(corners, corners[1:], strict=False):
        steps += [(after[0], before[1]), after]
    if steps:
        times, errors = zip(*steps, strict=True)
        axes.plot(times, errors, color="#222222", linewidth=2.0, alpha=0.25)
    for row in rows:
        size = 10.0 if row["key"] == "auto" else 7.0
        axes.plot([row["seconds"]], [_error(row)], "o", color=_colour(row), markersize=size)
    axes.set_xscale("log")
    axes.set_yscale("log")
    if rows:
        axes.set_xlim(min(r["seconds"] for r in rows) / 1.5, max(r["seconds"] for r in rows) * 1.5)
        axes.set_ylim(min(_error(r) for r in rows) / 1.6, max(_error(r) for r in rows) * 1.6)
    axes.set_xlabel("time for the picture, seconds")
    axes.set_ylabel("how far a pixel is off, % of its brightness")
    _numbers(figure, axes, rows)
    width, height = found["size"]
    figure.text(0.03, 0.97, f"What accuracy costs: {found['lens']}, {found['scene']}", fontsize=12, weight="bold", va="top")  # fmt: skip
    said = f"{width} x {height} pixels, {found['samples']} samples a pixel"
    said += "" if found["settled"] else "; the times had not settled when the time given was over"
    figure.text(0.03, 0.915, said, color=_DARK, va="top")
    _table(figure, rows)
    _advice(figure, found)
    return figure.drawn()


def _numbers(figure: Figure, axes: Any, rows: list[dict[str, Any]]) -> None:
    """Each camera's beside its dot; where dots lie close, one after the other."""
    placed: list[tuple[float, float]] = []
    for i, row in enumerate(rows):
        x, y = axes.to_pixels(row["seconds"], _error(row))
        x, y = x / figure.width + 0.008, y / figure.height + 0.012
        while any(abs(x - a) < 0.016 and abs(y - b) < 0.025 for a, b in placed):
            x += 0.016
        placed.append((x, y))
        figure.text(x, y, str(i + 1), color=_colour(row), fontsize=9.0)


def _table(figure: Figure, rows: list[dict[str, Any]]) -> None:
    for x, head, side in zip(_COLUMNS, ("camera", "time", "error", "of it for good"), ("left", *["right"] * 3), strict=True):  # fmt: skip
        figure.text(x, _TOP + 0.045, head, color=_DARK, fontsize=8.5, ha=side)
    for i, row in enumerate(rows):
        y = _TOP - _ROW * i
        weight = "bold" if row["key"] == "auto" else "normal"
        good = percent(row["bias"]) if row["bias"] > 0.0 else "none seen"
        cells = (f"{i + 1}  {row['name']}", seconds(row["seconds"]), percent(row["rel_mse"]), good)
        for x, text, side in zip(_COLUMNS, cells, ("left", *["right"] * 3), strict=True):
            figure.text(x, y, text, color=_colour(row), fontsize=8.5, ha=side, weight=weight)


def _advice(figure: Figure, found: dict[str, Any]) -> None:
    lines: list[str] = []
    for word in " ".join(advice(found)[:3]).split():
        if not lines or len(lines[-1]) + len(word) >= _LETTERS_OF_A_LINE:
            lines.append(word)
        else:
            lines[-1] += f" {word}"
    figure.text(0.03, 0.115, "\n".join(lines[:4]), color="#222222", fontsize=9.0, va="top")


def _error(row: dict[str, Any]) -> float:
    return max(100.0 * math.sqrt(row["rel_mse"]), 1e-4)


def _colour(row: dict[str, Any]) -> str:
    return _COLOURS.get(row["key"], _LENS)
