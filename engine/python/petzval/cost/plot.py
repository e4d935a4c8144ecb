# SPDX-License-Identifier: GPL-3.0-or-later
"""costs.json as a picture: error over time, a curve a camera, a dot where the picture's samples end; and the cost of each effect
changes. Needs matplotlib."""

from __future__ import annotations

import io
import math
import textwrap
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from .advice import advice, percent
from .ladder import is_camera

#: The curves go from so much of the fastest camera's time to so many times the slowest's.
_BEFORE, _AFTER = 0.3, 40.0
_SIMPLE, _ONE, _FULL, _AUTO = "#c77700", "#1f6fb4", "#2a8a4a", "#c1272d"
_COLOURS = {
    "pinhole": _SIMPLE, "thin": _SIMPLE, "thick": _SIMPLE, "paraxial": _SIMPLE, "one-f32": _ONE, "one-f64": _ONE,
    "rgb": _ONE, "film": _FULL, "scene": _FULL, "hero": _FULL, "auto": _AUTO,
}  # fmt: skip
#: Sizes of letters, points.
_LABEL, _TEXT = 8.5, 9.5


def draw(found: dict[str, Any], paths: Iterable[Path]) -> None:
    """Writes the picture in the format of each name."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    from .. import atomic_files

    look = {"font.size": 9, "svg.hashsalt": "petzval", "axes.spines.top": False, "axes.spines.right": False}
    with pyplot.rc_context(look):
        figure = pyplot.figure(figsize=(12.5, 7.0))
        grid = figure.add_gridspec(1, 2, width_ratios=(2.35, 1.0), left=0.06, right=0.975, top=0.87, bottom=0.27, wspace=0.95)  # fmt: skip
        width, height = found["size"]
        title = f"What accuracy costs: {found['lens']}, {found['scene']}"
        figure.text(0.06, 0.975, title, fontsize=13, weight="bold", va="top")
        below = f"{width} x {height} pixels; a dot is {found['samples']} samples a pixel"
        figure.text(0.06, 0.935, below, color="#555555", va="top")
        _cameras(figure.add_subplot(grid[0]), found)
        _effects(figure.add_subplot(grid[1]), found)
        _caption(figure, found)
        for path in paths:
            metadata = {"Date": None} if path.suffix == ".svg" else {"Software": None}
            drawn = io.BytesIO()
            figure.savefig(drawn, format=path.suffix[1:], dpi=120, metadata=metadata)
            atomic_files.write_bytes(path, drawn.getvalue())
        pyplot.close(figure)


def _cameras(axes: Any, found: dict[str, Any]) -> None:
    import numpy as np

    rows = [row for row in found["rungs"] if row["is_measured"] and is_camera(row)]
    ends = []
    span = np.geomspace(
        _BEFORE * min(row["seconds"] for row in rows), _AFTER * max(row["seconds"] for row in rows), 200
    )
    for row in rows:
        time, colour = row["seconds"], _COLOURS[row["key"]]
        noise = row["noise_of_one_sample"] / found["samples"]
        # Set-up comes first.
        drawing = span[span > row["setup_s"] + 0.02 * time] - row["setup_s"]
        errors = 100.0 * np.sqrt(row["bias"] + noise * (time - row["setup_s"]) / drawing)
        is_auto = row["key"] == "auto"
        axes.plot(
            drawing + row["setup_s"],
            errors,
            color=colour,
            linewidth=1.8 if is_auto else 0.9,
            alpha=0.9 if is_auto else 0.55,
        )
        ends.append((row, span[-1], errors[-1]))
    front = sorted((row for row in rows if row["is_on_front"]), key=lambda row: row["seconds"])
    times, errors = [row["seconds"] for row in front], [100.0 * math.sqrt(row["rel_mse"]) for row in front]
    axes.step(times, errors, where="post", color="#222222", linewidth=2.2, alpha=0.25, zorder=1, solid_capstyle="round")
    for row in rows:
        is_auto = row["key"] == "auto"
        axes.plot(
            row["seconds"], 100.0 * math.sqrt(row["rel_mse"]), "*" if is_auto else "o", markersize=16 if is_auto else 6.5,
            color=_COLOURS[row["key"]], markeredgecolor="black" if row["is_on_front"] else "white",
            markeredgewidth=1.0, zorder=6 if is_auto else 5,
        )  # fmt: skip
    axes.set(xscale="log", yscale="log", xlabel="time for the picture, seconds", ylabel="how far a pixel is off, % of its brightness")  # fmt: skip
    axes.set_title("Cameras: to the left is faster, down is nearer to the truth", loc="left", fontsize=10)
    _plain_numbers(axes.xaxis)
    _plain_numbers(axes.yaxis)
    axes.grid(True, which="major", color="#e4e4e4", linewidth=0.7)
    axes.set_axisbelow(True)
    axes.set_xlim(right=span[-1] * 1.02)
    _name(axes, ends)
    handles = [
        axes.plot([], [], "o", color="white", markeredgecolor="black", markersize=6.5)[0],
        axes.plot([], [], color="#222222", linewidth=2.2, alpha=0.25)[0],
    ]
    texts = ["ringed: nothing else is both faster and nearer", "the front that these make"]
    axes.legend(handles, texts, frameon=False, fontsize=_LABEL, loc="lower left")


def _name(axes: Any, ends: list[tuple[dict[str, Any], float, float]]) -> None:
    """The curves' names beside their ends, one below the other where the ends lie close."""
    figure = axes.figure
    figure.canvas.draw()
    line = 1.45 * _LABEL * figure.dpi / 72.0
    right = axes.transAxes.transform((1.0, 0.0))[0]
    placed: list[tuple[dict[str, Any], float, float, float]] = []
    for row, x, y in sorted(ends, key=lambda end: -end[2]):
        at = axes.transData.transform((x, y))
        height = min(at[1], placed[-1][1] - line) if placed else at[1]
        placed.append((row, height, x, y))
    # All of them up again where they have come to lie below the axes.
    lowest = axes.transAxes.transform((0.0, 0.0))[1]
    lift = max(lowest - placed[-1][1], 0.0)
    heights = [height + lift for _, height, _, _ in placed]
    for i in range(len(heights) - 2, -1, -1):
        heights[i] = max(placed[i][1], heights[i + 1] + line) if lift else heights[i]
    inverse = axes.transData.inverted()
    for (row, _, x, y), height in zip(placed, heights, strict=True):
        x_text, y_text = inverse.transform((right + 22.0, height))
        floor = f"  never below {percent(row['bias'])}" if row["bias"] > 0.0 else ""
        is_auto = row["key"] == "auto"
        axes.annotate(
            row["name"] + floor, (x, y), (x_text, y_text), fontsize=_LABEL, va="center", annotation_clip=False,
            color=_COLOURS[row["key"]], weight="bold" if is_auto else "normal",
            arrowprops={"arrowstyle": "-", "color": _COLOURS[row["key"]], "linewidth": 0.6, "alpha": 0.6, "shrinkA": 0, "shrinkB": 0, "relpos": (0.0, 0.5)},
        )  # fmt: skip


def _effects(axes: Any, found: dict[str, Any]) -> None:
    planned = {row["effect"]: row["decision"] for row in found["auto"]["effects"]}
    rows = [row for row in found["rungs"] if row["is_measured"] and not is_camera(row)]
    # A logarithm has no place for nothing at all.
    rows = [row for row in rows if row["bias"] > 0.0 or row["bias_uncertainty"] > 0.0]
    axes.set_title("Everything on, but without ...", loc="left", fontsize=10)
    if not rows:
        axes.set_axis_off()
        return
    # What is not told from noise is drawn as the most that it can be.
    sizes = [math.sqrt(row["bias"] or 3.0 * row["bias_uncertainty"]) * 100.0 for row in rows]
    order = sorted(range(len(rows)), key=lambda i: sizes[i])
    for place, i in enumerate(order):
        row, size, is_seen = rows[i], sizes[i], rows[i]["bias"] > 0.0
        colour = _AUTO if planned[row["effect"]] == "on" else "#888888"
        axes.plot([1e-9, size], [place, place], color=colour, linewidth=1.0, alpha=0.5 if is_seen else 0.0)
        axes.plot(
            size, place, "o" if is_seen else "<", color=colour, markersize=6.5, fillstyle="full" if is_seen else "none"
        )
        text = percent(row["bias"]) if is_seen else f"under {percent(3.0 * row['bias_uncertainty'])}"
        axes.annotate(
            text, (size, place), (7, 0), textcoords="offset points", fontsize=_LABEL, va="center", color=colour
        )
    axes.set_yticks(range(len(rows)), [rows[i]["effect"].replace("_", " ") for i in order])
    axes.set(xscale="log", xlabel="changes pixels for good by, %", ylim=(-0.7, len(rows) - 0.3))
    axes.set_xlim(min(sizes) / 2.5, max(sizes) * 5.0)
    axes.tick_params(axis="y", length=0)
    _plain_numbers(axes.xaxis)
    axes.grid(True, axis="x", which="major", color="#e4e4e4", linewidth=0.7)
    axes.set_axisbelow(True)
    handles = [axes.plot([], [], "o", color=one)[0] for one in (_AUTO, "#888888")]
    handles.append(axes.plot([], [], "<", color="#555555", fillstyle="none")[0])
    texts = ["auto simulates it", "auto leaves it out", "too small to be told from noise"]
    axes.legend(handles, texts, frameon=False, fontsize=_LABEL, loc="upper left", bbox_to_anchor=(-0.25, -0.13))


def _plain_numbers(axis: Any) -> None:
    """0.1, 1, 10 rather than powers of ten; between them 2 and 5 where there is room for no more than a decade or two."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    low, high = axis.get_view_interval()
    decades = math.log10(high / low) if 0.0 < low < high else 9.0
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if decades < 2.5 else (1.0,)))
    axis.set_major_formatter(FuncFormatter(lambda value, _place: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def _caption(figure: Any, found: dict[str, Any]) -> None:
    first, *rest = found.get("advice") or advice(found)
    lines = textwrap.wrap(first, 92)
    figure.text(
        0.06, 0.175, "\n".join(lines), fontsize=_TEXT + 1.0, weight="bold", va="top", linespacing=1.4, color="#222222"
    )
    rest = textwrap.wrap(" ".join(rest), 122)[:4]
    figure.text(
        0.06,
        0.145 - 0.03 * (len(lines) - 1),
        "\n".join(rest),
        fontsize=_TEXT,
        va="top",
        linespacing=1.4,
        color="#222222",
    )
