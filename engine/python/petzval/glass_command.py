# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval glass`: the data of a glass. Reads arguments, asks the engine, prints or draws its answer. Computes nothing."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from .argument_types import number
from .errors import CommandError
from .lens_loading import say

#: F, d and C, and e, F' and C' of mercury and cadmium, nm.
_LINES = (("F", 486.1327), ("d", 587.5618), ("C", 656.2725), ("F'", 479.9914), ("e", 546.0740), ("C'", 643.8469))
#: The range that is drawn, nm, if the glass's own goes so far, and the number of wavelengths.
_SHORTEST_NM, _LONGEST_NM, _PLACES = 320.0, 1000.0, 341


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `glass`."""
    glass = subparsers.add_parser(
        "glass",
        help="what is known of a glass",
        description="Says what is known of a glass: a name of the shipped catalogues (N-BK7, hoya:FCD1), index/Abbe (1.62/60.3), "
        "an index, air, vacuum, water; or a name in a catalogue of your own.",
        allow_abbrev=False,
    )  # fmt: skip
    glass.add_argument("name", nargs="?", metavar="NAME", help="the glass")
    glass.add_argument("--catalogue", metavar="FILE", help="a maker's .agf, or a .yml of refractiveindex.info")
    glass.add_argument("--list", action="store_true", help="the glasses there are, with index and Abbe number")
    glass.add_argument(
        "--wavelength", nargs="+", type=number, default=[], metavar="NM", help="nanometres; default: F, d, C, F', e, C'"
    )
    glass.add_argument(
        "--thickness", type=number, default=10.0, metavar="MM", help="for the light let through inside; default: 10"
    )
    glass.add_argument("-o", "--output", metavar="OUT", help="draw it: .svg, .png or .pdf; or .json")
    glass.add_argument("--json", action="store_true", help="print one JSON object")
    glass.set_defaults(usage_error=glass.error)


def run(arguments: argparse.Namespace) -> int:
    """Runs the command; returns the exit status."""
    if arguments.list == (arguments.name is not None):
        arguments.usage_error("give the name of a glass, or --list")
    return _list(arguments) if arguments.list else _glass(arguments)


def _list(arguments: argparse.Namespace) -> int:
    from . import _native

    answer = _native.glasses_json(arguments.catalogue)
    if arguments.json:
        print(answer)
        return 0
    found = json.loads(answer)
    width = max((len(glass["token"]) for glass in found["glasses"]), default=0)
    for glass in found["glasses"]:
        print(f"{glass['token']:<{width}}  {glass['nd']:.6f}  {_abbe(glass['abbe'])}")
    say(found["remarks"])
    return 0


def _glass(arguments: argparse.Namespace) -> int:
    from . import _native

    asked = arguments.wavelength or [nm for _, nm in _LINES]
    answer = _native.glass_json(arguments.name, arguments.catalogue, asked, arguments.thickness)
    found = json.loads(answer)
    if arguments.output:
        _draw(arguments, found)
    if arguments.json:
        print(answer)
        return 0
    print("\n".join(_rows(found, with_names=not arguments.wavelength)))
    say(_notes(found))
    return 0


def _rows(found: dict[str, Any], with_names: bool) -> list[str]:
    shortest, longest = found["range_nm"]
    rows = [
        ("glass", found["name"]),
        ("source", found["source"]),
        ("index at d", f"{found['nd']:.6f}"),
        ("Abbe number", _abbe(found["abbe"])),
        ("known from", "everywhere" if longest is None else f"{shortest:.1f} to {longest:.1f} nm"),
        ("formula", found["formula"] or "one over another's"),
        ("coefficients", " ".join(f"{value:.10g}" for value in found["coefficients"] or [])),
    ]
    lines = [f"{words:<14}{text}".rstrip() for words, text in rows]
    through = f"  let through by {found['thickness_mm']:g} mm" if found["transmittance_is_known"] else ""
    lines += ["", f"  wavelength     index{through}"]
    names = [name for name, _ in _LINES] if with_names else [""] * len(found["indices"])
    for name, row in zip(names, found["indices"], strict=True):
        light = "" if row["transmittance"] is None else f"  {row['transmittance']:.5f}"
        lines.append(
            f"{name:<3}{row['wavelength_nm']:9.4f}  {row['index']:.7f}{light}{'' if row['is_known'] else '  (beyond)'}"
        )
    return lines


def _abbe(value: float | None) -> str:
    return "none" if value is None else f"{value:.3f}"


def _notes(found: dict[str, Any]) -> list[str]:
    notes = list(found["remarks"])
    if found["range_note"]:
        notes.append(found["range_note"])
    if len(found["makers"]) > 1:
        notes.append(
            f"glasses of this name are made by {', '.join(found['makers'])}: name one as {found['makers'][0]}:NAME"
        )
    return notes


def _draw(arguments: argparse.Namespace, found: dict[str, Any]) -> None:
    from . import _native
    from .lens_reports import glass, page

    out = Path(arguments.output)
    page.check(out)
    start = max(_SHORTEST_NM, found["range_nm"][0])
    end = min(_LONGEST_NM, found["range_nm"][1] or _LONGEST_NM)
    if start >= end:
        raise CommandError(
            f"cannot draw glass {found['name']}: nothing is known of it between 320 and 1000 nm: leave out -o"
        )
    places = [start + (end - start) * i / (_PLACES - 1) for i in range(_PLACES)]
    drawn = json.loads(_native.glass_json(arguments.name, arguments.catalogue, places, arguments.thickness))
    drawn["others"] = json.loads(_native.glasses_json(arguments.catalogue))["glasses"]
    page.write(drawn, out, glass.SIZE_IN, drawn["source"], glass.draw)
