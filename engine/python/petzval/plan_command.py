# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval plan`: which effects of the lens a picture calls for, how large each is, and the decisions."""

from __future__ import annotations

import argparse
import json
from typing import Any, TextIO

from . import scene_options


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `plan`."""
    p = subparsers.add_parser("plan", help="say what a render would simulate, and why", allow_abbrev=False)
    scene_options.add(p)
    p.add_argument("--json", action="store_true", help="one JSON object on stdout, and nothing else")


def run(arguments: argparse.Namespace) -> int:
    """Plans; the exit status."""
    options = scene_options.checked(arguments) | {"study": {"what": "plan"}}

    def tell(plan: dict[str, Any], out: TextIO, _voice: TextIO) -> None:
        print(json.dumps(plan, indent=2) if arguments.json else "\n".join(lines(plan)), file=out)

    return scene_options.study(arguments.blender, options, tell)


def lines(plan: dict[str, Any]) -> list[str]:
    """A plan in words: a row an effect, then the camera that follows from it."""
    rows = [("effect", "", "measure", "tolerance", "cost", "why")]
    rows += [
        (row["effect"], row["decision"], size(row), f"{row['tolerance']:.3g}", cost(row), row["why"])
        for row in plan["effects"]
    ]
    widths = [max(len(row[column]) for row in rows) for column in range(5)]
    table = [
        "  ".join(cell.ljust(width) for cell, width in zip(row, [*widths, 0], strict=True)).rstrip() for row in rows
    ]
    camera = plan["camera"]
    ways = f"{camera['wavelengths']} wavelengths" if camera["wavelengths"] > 1 else "one wavelength"
    end = [f"camera: {camera['model']}, {ways}, pipeline {camera['pipeline']}; planned in {plan['seconds']:.2f} s"]
    predicted = plan.get("predicted")
    if predicted:
        end.append(
            f"predicted: {predicted['seconds']:.1f} s for {predicted['samples']} samples a pixel on "
            f"{predicted['threads']} threads"
        )
    return table + end


def size(row: dict[str, Any]) -> str:
    """The measure in a row of the plan, with its unit."""
    if row["is_unbounded"]:
        return "unbounded"
    return "-" if row["measure"] is None else f"{row['measure']:.3g} {row['unit']}"


def cost(row: dict[str, Any]) -> str:
    """The predicted cost in a row of the plan: a share of the time, or seconds once a picture for stray light."""
    share, seconds = row.get("predicted_cost"), row.get("picture_seconds")
    if seconds:
        return f"+{seconds:.2g} s"
    return "-" if share is None else f"{100.0 * share:+.1f} %"
