# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval surface trace`: rays at single surfaces. Reads arguments, asks the engine, prints its answer."""

from __future__ import annotations

import argparse
import json
from typing import Any

from .questions import read_list, vector_text

_FORMAT = """\
The file is {"cases": [CASE, ...]}. Numbers may be written as strings of decimal digits. A case has

  id           what the answer calls it; default: its number, from 0
  surface      radius (mm; 0 is a plane), k (conic constant), semi_diameter (mm; null: no rim), mirror (true or false);
               and, if wanted, obstruction (semi-diameter, mm), terms ([[power, coefficient], ...], mm), radius_x (mm)
  side         sign of N.D at the crossing that is meant, N towards +z at the vertex: 1 or -1
  n1, n2       index before and after
  origin, direction   the ray, in mm, the vertex at the origin and the axis along z; the direction of any length

Other keys are refused, but for category, note, expect and ulp_sensitivity, which are passed over.

The answer is {"cases": [{"id", "status", "t", "point", "normal", "direction"}]}, with null for what there is not.
"""


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `surface` with its one action."""
    surface = subparsers.add_parser("surface", help="trace rays at single surfaces", allow_abbrev=False)
    actions = surface.add_subparsers(dest="action", metavar="ACTION", required=True)
    trace = actions.add_parser(
        "trace",
        help="trace rays at single surfaces",
        description="Traces each ray to its surface and through it.",
        epilog=_FORMAT,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    trace.add_argument("cases", metavar="CASES.json|-", help="rays and surfaces; - reads them from stdin")
    trace.add_argument(
        "--precision",
        choices=("f64", "f32", "printed"),
        default="f64",
        help="numbers of 64 or 32 bits, or the equations that Wu et al. 2011 print, in 64; default: f64",
    )
    trace.add_argument("--json", action="store_true", help="print one JSON object")
    trace.set_defaults(run=_trace)


def run(arguments: argparse.Namespace) -> int:
    """Runs the action; returns the exit status."""
    status: int = arguments.run(arguments)
    return status


def _trace(arguments: argparse.Namespace) -> int:
    from . import _native

    text, _ = read_list(arguments.cases, "cases", '{"surface": ..., ...}')
    answer = _native.trace_surfaces_json(text, precision=arguments.precision)
    print(answer if arguments.json else "\n".join(map(_line, json.loads(answer)["cases"])))
    return 0


def _line(case: dict[str, Any]) -> str:
    """The result of a ray in a line: status, point, normal and direction."""
    parts = [case["status"]]
    if case["point"] is not None:
        parts.append(f"at ({vector_text(case['point'])}) mm, t = {case['t']:.9g} mm")
        parts.append(f"normal ({vector_text(case['normal'])})")
    if case["direction"] is not None:
        parts.append(f"goes on along ({vector_text(case['direction'])})")
    return f"{case['id']}: {', '.join(parts)}"
