# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval lens spots|fans|mtf|psf|distortion|illumination|transmission`: reads arguments, asks the engine, draws its answer. Computes nothing."""

from __future__ import annotations

import argparse
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from .lens_loading import load, say
from .lens_reports.registry import REPORTS, find
from .lens_reports.report import LensReport
from .lens_setting import add_look, add_setting, look_of, setting_of


def add_parsers(actions: Any, kinds: str) -> None:
    """Adds an action for each report to those of `petzval lens`."""
    for report in REPORTS:
        parser: argparse.ArgumentParser = actions.add_parser(report.name, help=report.help, allow_abbrev=False)
        parser.add_argument("lens", metavar="FILE", help=f"a lens file ({kinds}), or the name of a shipped lens")
        parser.add_argument(
            "-o", "--output", required=True, metavar="OUT", help="the picture: .svg, .png or .pdf; or .json"
        )
        add_look(parser, report.fields)
        add_setting(parser)
        report.add_options(parser)
        parser.set_defaults(run=partial(_run, report))


def _run(report: LensReport, arguments: argparse.Namespace) -> int:
    """Writes the picture, and says what there is to say."""
    from .lens_reports import page

    f_numbers = arguments.f_numbers if report.has_f_numbers else []
    for option, value in (("--f-number", arguments.f_number), ("--pupil-diameter", arguments.pupil_diameter)):
        if f_numbers and value is not None:
            arguments.usage_error(f"--f-numbers stands instead of {option}: leave out the one or the other")
    options, out = report.options_of(arguments), Path(arguments.output)
    page.check(out)
    lens, settings, look = load(arguments.lens), setting_of(arguments), look_of(arguments)
    each = [replace(settings, f_number=n) for n in f_numbers] or [settings]
    every = [find(report, lens, one, look, options) for one in each]
    first = every[0]
    found = every if report.has_f_numbers else first
    shown = report.drawn_as(arguments, report)
    page.write(found, out, shown.size_in(found), shown.title(found), shown.draw)
    fields = first.get("fields") or first["defocus"][0]["fields"]
    dark = [f"no light from {f['angle_deg']:g} degrees comes to the film" for f in fields if f.get("is_dark")]
    say([*lens.remarks, *lens.range_notes(first["wavelengths_nm"]), *dark])
    print(f"{out}: {first['name']}")
    say(report.remarks(first))
    return 0
