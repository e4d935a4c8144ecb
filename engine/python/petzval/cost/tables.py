# SPDX-License-Identifier: GPL-3.0-or-later
"""costs.json as tables for people. Plain Python."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .advice import advice, percent, seconds
from .ladder import is_camera

_NEVER = "never"


def markdown(found: dict[str, Any], level: int = 1, picture: str | None = "costs.png") -> str:
    """A page, or a chapter of one, on one picture."""
    width, height = found["size"]
    title = f"{'#' * level} What accuracy costs: {found['lens']}, {found['scene']}"
    truth = found["truth"]
    counts = [row["samples_measured"] for row in found["rungs"] if row["is_measured"]]
    least, most = min(counts), max(counts)
    parts = [title, *advice(found)]
    if picture:
        parts.append(f"![Error over time, a dot a camera]({picture})")
    parts.append(
        f"{width} x {height} pixels, {found['samples']} samples a pixel, {_count(found['threads'], 'thread')}. "
        f"{found['rounds']} rounds, rungs interleaved, {least} to {most} samples of each"
        f"{'' if found['settled'] else '; the time was over before every interval was narrower than 3 %'}. "
        f"The truth: everything on but stray light, which has a table of its own, {truth['samples']} samples, "
        f"{percent(truth['rel_mse'])} off by noise."
    )
    parts += [_cameras(found), _effects(found), _strays(found), _notes(found)]
    return "\n\n".join(part for part in parts if part) + "\n"


def _count(number: int, what: str) -> str:
    return f"{number} {what}" + ("" if number == 1 else "s")


def _table(head: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    lines = ["| " + " | ".join(head) + " |", "|---" + "|---:" * (len(head) - 1) + "|"]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def _cameras(found: dict[str, Any]) -> str:
    base = next(row["name"] for row in found["rungs"] if row["key"] == found["base"])
    head = ("camera", "µs a sample", f"over the {base}", "set-up", "for the picture", "error", "of it for good", "FLIP",
            *(f"to {percent(target)}" for target in found["targets"]))  # fmt: skip
    rows = []
    for row in found["rungs"]:
        if not is_camera(row):
            continue
        name = f"**{row['name']}**" if row["key"] == "auto" else row["name"]
        if not row["is_measured"]:
            rows.append((name, *["–"] * (len(head) - 2), row["why_not"]))
            continue
        rows.append(
            (name, f"{row['us_a_sample']:.2f}", _ratio(row), f"{1e3 * row['setup_s']:.0f} ms", seconds(row["seconds"]),
             percent(row["rel_mse"]), _bias(row), f"{row['flip']:.3f}",
             *(_NEVER if one is None else seconds(one) for one in row["seconds_to"]))
        )  # fmt: skip
    return _table(head, rows)


def _effects(found: dict[str, Any]) -> str:
    top = next(row for row in found["rungs"] if row["key"] == "hero")
    head = ("everything on, but", "time a sample", "to equal noise", "off for good", "FLIP", "by the plan")
    planned = {row["effect"]: row for row in found["auto"]["effects"]}
    rows = []
    for row in found["rungs"]:
        if row["group"] != "effect":
            continue
        if not row["is_measured"]:
            rows.append((row["name"], "–", "–", "–", "–", row["why_not"]))
            continue
        change = row["us_a_sample"] / top["us_a_sample"] - 1.0
        noise = row["noise_of_one_sample"] / top["noise_of_one_sample"]
        said = planned[row["effect"]]
        rows.append(
            (row["name"], f"{100.0 * change:+.0f} %", f"{100.0 * ((1.0 + change) * noise - 1.0):+.0f} %", _bias(row), f"{row['flip']:.3f}",
             f"{said['decision']}: {_size(said)}")
        )  # fmt: skip
    return "Each effect of the lens taken out alone:\n\n" + _table(head, rows) if rows else ""


def _strays(found: dict[str, Any]) -> str:
    """The light that is laid over the finished picture: so many seconds, whatever its samples."""
    top = next(row for row in found["rungs"] if row["key"] == "hero")
    head = ("stray light", "on: more for the picture", "of its time", "off: for good", "FLIP", "by the plan")
    planned = {row["effect"]: row for row in found["auto"]["effects"]}
    rows = []
    for row in found["rungs"]:
        if row["group"] != "stray":
            continue
        name = row["name"].removeprefix("with ")
        if not row["is_measured"]:
            rows.append((name, "–", "–", "–", "–", row["why_not"]))
            continue
        said = planned[row["effect"]]
        rows.append(
            (name, *_stray_cells(row, top), _bias(row), f"{row['flip']:.3f}", f"{said['decision']}: {_size(said)}")
        )
    if not rows:
        return ""
    if found.get("strays") and len(rows) > 1:
        every = found["strays"]
        rows.append(("all of it", *_stray_cells(every, top), percent(every["bias"]), f"{every['flip']:.3f}", ""))
    return (
        "Stray light, laid over the finished picture, each kind alone. Off, pixels miss it: against the truth with everything on, "
        "stray light with it.\n\n" + _table(head, rows)
    )


def _stray_cells(row: dict[str, Any], top: dict[str, Any]) -> tuple[str, str]:
    more = row["stray_s"]
    return seconds(more), f"{100.0 * more / top['seconds']:+.0f} %"


def _size(row: dict[str, Any]) -> str:
    if row["is_unbounded"]:
        return "unbounded"
    return "not measured" if row["measure"] is None else f"{row['measure']:.2g} {row['unit']}"


def _ratio(row: dict[str, Any]) -> str:
    if row["ratio_interval"] is None:
        return f"{row['ratio']:.2f}"
    low, high = row["ratio_interval"]
    return f"{row['ratio']:.2f} ({low:.2f}–{high:.2f})"


def _bias(row: dict[str, Any]) -> str:
    if row["bias_estimate"] == row["bias_uncertainty"] == 0.0:
        return "nothing"
    return percent(row["bias"]) if row["bias"] > 0.0 else f"none above {percent(3.0 * row['bias_uncertainty'])}"


def _notes(found: dict[str, Any]) -> str:
    auto = found["auto"]
    camera = auto["camera"]
    light = _count(camera["wavelengths"], "wavelength")
    strays = [name.replace("_", " ") for name in (found.get("strays") or {}).get("planned", ())]
    laid_over = f", and {', '.join(strays)} laid over the picture: the times here are without" if strays else ""
    return (
        f"The plan chose: {camera['model']} camera, {light}{laid_over}. It foretold {seconds(auto['predicted_s'])} by the clock; it took "
        f"{seconds(auto['measured_s'])} (within a round, {100.0 * (auto['predicted_over_measured'] - 1.0):+.0f} %). "
        "Time is processor time over threads. An error is how far a pixel is off, of its brightness: the root of "
        "the mean relative squared error, the worst pixel of a thousand left out. "
        f"Intervals hold the median with {found['confidence']:.0%}. FLIP is of all rounds together; that of the full lens is its noise."
    )
