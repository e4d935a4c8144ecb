# SPDX-License-Identifier: GPL-3.0-or-later
"""The page docs/settings.md."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from .walk import Row


def shown(found: Iterable[Row]) -> list[Row]:
    """The settings that change a picture."""
    return [row for row in found if row.verdict not in ("not set", "nothing")]


def summary(found: list[Row]) -> str:
    seen = shown(found)
    alike = sum(row.verdict == "alike" for row in seen)
    quiet = [row for row in found if row.verdict in ("not set", "nothing")]
    unanswered = sum(not row.is_answered for row in found)
    return (
        f"{len(found)} settings: {len(seen)} show in a picture, {alike} of them alike, {len(seen) - alike} not; {len(quiet)} show in none. "
        f"{unanswered} have no answer."
    )


def cells_of(page: str) -> dict[tuple[str, str], list[str]]:
    """The cells of the page's rows by owner and name, of all settings that show."""
    found, owner = {}, ""
    for line in page.splitlines():
        if line.startswith("## "):
            owner = line.removeprefix("## ")
        elif line.startswith("| ") and not line.startswith(("| setting", "| ---")):
            cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
            found[owner, cells[0]] = cells
    return found


def value_in_words(value: Any) -> str:
    if isinstance(value, list):
        return " ".join(value_in_words(one) for one in value) if len(value) <= 4 else "others"
    return f"{value:.4g}" if isinstance(value, float) else str(value).removeprefix("@")


def _percent(size: float) -> str:
    return f"{100.0 * size:.1f} %"


def _line(row: Row) -> str:
    worst = row.worst
    values = ", ".join(dict.fromkeys(value_in_words(one["value"]) for one in row.found))
    if "failed" in worst:
        return f"| {row.name} | {values} | | | {worst['failed']} |"
    told = worst["verdict"]
    if told == "alike":
        largest = max(
            (one for one in row.found if one.get("verdict") == "alike"), key=lambda one: one["cycles"]["size"]
        )
        return f"| {row.name} | {values} | {_percent(largest['cycles']['size'])} | {_percent(largest['apart']['size'])} | alike |"
    sizes = f" ({worst['sizes']})" if worst["sizes"] else ""
    why = f": {row.cause.why}" if row.cause else ""
    at = f" at {value_in_words(worst['value'])}" if len(row.found) > 1 else ""
    return f"| {row.name} | {values} | {_percent(worst['cycles']['size'])} | {_percent(worst['apart']['size'])} | {told}{at}{sizes}{why} |"


def text(found: list[Row]) -> str:
    lines = [
        "# Every setting",
        "",
        "All properties that Blender and Cycles have of scenes, view layers, cameras, objects, lights, materials and worlds, by Blender's own",
        "account (RNA), each given other values in a stage that has something for it to act on, in Petzval and in Cycles.",
        "",
        summary(found),
        "",
        "- **Change**: what Cycles' picture changes by, root mean square over 12 x 8 blocks and the channels, of the picture's mean; of two seeds, each",
        "  before and after the change, free of noise in the mean. What is below 0.3 %, or below three standard errors, does not show.",
        "- **Apart**: how far Petzval's change is from it. *Alike*: by no more than a tenth of it, or 0.3 %, or three standard errors.",
        "",
        "Of several values the row has the largest change, or what is furthest apart. Objects, lights and materials stand for their kinds.",
        "",
    ]
    for owner in dict.fromkeys(row.owner for row in shown(found)):
        lines += [f"## {owner}", "", "| setting | values | change | apart | |", "| --- | --- | ---: | ---: | --- |"]
        lines += [*(_line(row) for row in shown(found) if row.owner == owner), ""]
    lines += [
        "## What changes no picture",
        "",
        "All of an owner that have one reason were set at once, and neither picture changed.",
        "",
    ]
    reasons = dict.fromkeys(row.reason.why for row in found if row.reason and row.verdict in ("nothing", "not set"))
    for why in reasons:
        lines.append(f"- {why[:1].upper()}{why[1:]}:")
        owners: dict[tuple[str, ...], list[str]] = {}
        for owner in dict.fromkeys(row.owner for row in found):
            names = tuple(
                row.name
                for row in found
                if row.owner == owner and row.reason and row.reason.why == why and row.verdict in ("nothing", "not set")
            )
            if names:
                owners.setdefault(names, []).append(owner)
        for names, of in owners.items():
            lines.append(f"  *{', '.join(of)}*: {', '.join(f'`{name}`' for name in names)}.")
    return "\n".join(lines) + "\n"
