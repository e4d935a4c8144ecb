# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval lens spots|fans|mtf|psf|distortion|illumination|transmission`: reads arguments, asks the engine, draws its answer. Computes nothing."""

from __future__ import annotations

import argparse
import json
from functools import partial
from pathlib import Path
from typing import Any

from .lens_loading import load, say
from .lens_reports.registry import REPORTS, find
from .lens_reports.report import LensReport
from .lens_setting import add_look, add_setting, look_of, settings_at


def add_parsers(actions: Any, kinds: str) -> None:
    """Adds an action for each report to `petzval lens`."""
    for report in REPORTS:
        parser: argparse.ArgumentParser = actions.add_parser(report.name, help=report.help, allow_abbrev=False)
        parser.add_argument("lens", metavar="FILE", help=f"a lens file ({kinds}), or the name of a shipped lens")
        parser.add_argument(
            "-o", "--output", metavar="OUT", help="a picture: .svg, .png or .pdf; or .json; default: a table is printed"
        )
        parser.add_argument(
            "--json", action="store_true", help="print one JSON object, as docs/command-line.md describes it"
        )
        add_look(parser, report.fields)
        add_setting(parser)
        report.add_options(parser)
        parser.set_defaults(run=partial(_run, report))


def _run(report: LensReport, arguments: argparse.Namespace) -> int:
    """Prints the table, or writes the picture, and prints the remarks."""
    from .lens_reports import page

    settings = settings_at(arguments, arguments.f_numbers if report.has_f_numbers else [])
    options, out = report.options_of(arguments), Path(arguments.output) if arguments.output else None
    if out is not None:
        page.check(out)
    lens, look = load(arguments.lens), look_of(arguments)
    every = [find(report, lens, one, look, options) for one in settings]
    first = every[0]
    found = every if report.has_f_numbers else first
    shown = report.drawn_as(arguments, report)
    if out is not None:
        page.write(found, out, shown.size_in(found), shown.title(found), shown.draw)
    fields = first.get("fields") or [field for place in first.get("defocus", [])[:1] for field in place["fields"]]
    dark = [f"no light from {f['angle_deg']:g} degrees comes to the film" for f in fields if f.get("is_dark")]
    say([*lens.remarks, *lens.range_notes(first["wavelengths_nm"]), *dark])
    if arguments.json:
        print(json.dumps(found))
    elif out is None:
        print(f"{first['name']}: {page.facts(first)}\n{shown.title(found)}\n")
        print("\n".join(shown.table(found).lines()))
    else:
        print(f"{out}: {first['name']}")
    say(report.remarks(first))
    return 0
