# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval lens spots|fans|mtf|psf|distortion|illumination|transmission`: reads arguments, asks the engine, draws its answer. Computes nothing."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from .argument_types import natural, number
from .lens_loading import load, say
from .lens_setting import add_look, add_setting, look_of, setting_of

_SOME_FIELDS = "0, and 0.7 and all of the design's half field"
_ALL_FIELDS = "from 0 to the design's half field"


def add_parsers(actions: Any, kinds: str) -> None:
    """Adds the six actions to those of `petzval lens`."""

    def add(name: str, help_text: str, fields: str, run: Callable[..., int]) -> argparse.ArgumentParser:
        parser: argparse.ArgumentParser = actions.add_parser(name, help=help_text, allow_abbrev=False)
        parser.add_argument("lens", metavar="FILE", help=f"a lens file ({kinds}), or the name of a shipped lens")
        parser.add_argument(
            "-o", "--output", required=True, metavar="OUT", help="the picture: .svg, .png or .pdf; or .json"
        )
        add_look(parser, fields)
        add_setting(parser)
        parser.set_defaults(run=run)
        return parser

    spots = add("spots", "where the rays of a point meet the film", _SOME_FIELDS, _spots)
    spots.add_argument("--rays", type=natural, default=41, metavar="N", help="over the width of a beam; default: 41")
    spots.add_argument(
        "--defocus", nargs="+", type=number, default=[0.0], metavar="MM", help="a column for each place of the film"
    )

    fans = add("fans", "how far rays across the pupil land from the middle one", _SOME_FIELDS, _fans)
    fans.add_argument("--rays", type=natural, default=201, metavar="N", help="of a fan; default: 201")
    fans.add_argument("--path", action="store_true", help="how long they take instead, in wavelengths")

    mtf = add("mtf", "how much contrast is left of fine lines", _SOME_FIELDS, _mtf)
    mtf.add_argument(
        "--frequency", type=number, default=100.0, metavar="N", help="the highest, line pairs/mm; default: 100"
    )
    mtf.add_argument("--steps", type=natural, default=40, metavar="N", help="of the frequency; default: 40")
    mtf.add_argument("--heights", type=natural, default=13, metavar="N", help="in the picture; default: 13")
    mtf.add_argument(
        "--height-frequency", type=number, default=10.0, metavar="N",
        help="over the height are 1, 2, 3 and 4 times so many line pairs/mm; default: 10",
    )  # fmt: skip

    add("psf", "what diffraction and aberrations make of a point", _SOME_FIELDS, _psf)

    distortion = add("distortion", "distortion, field curvature, lateral colour", _ALL_FIELDS, _distortion)
    distortion.add_argument("--count", type=natural, default=41, metavar="N", help="of the fields; default: 41")

    illumination = add("illumination", "how bright the picture is off its middle", _ALL_FIELDS, _illumination)
    illumination.add_argument("--count", type=natural, default=31, metavar="N", help="of the fields; default: 31")
    illumination.add_argument(
        "--f-numbers", nargs="+", type=number, default=[], metavar="N", help="a curve for each, instead of --f-number"
    )

    transmission = add(
        "transmission", "what is left of each colour, and what coatings reflect", _SOME_FIELDS, _transmission
    )
    transmission.add_argument(
        "--spectrum", nargs=3, type=number, default=[380.0, 780.0, 5.0], metavar=("FROM", "TO", "STEP"),
        help="nanometres; default: 380 780 5",
    )  # fmt: skip


def _lens(arguments: argparse.Namespace) -> Any:
    from .lens_reports import page

    page.check(Path(arguments.output))
    return load(arguments.lens)


def _finish(arguments: argparse.Namespace, lens: Any, found: Any, title: str, report: Any, draw: Any = None) -> int:
    """Writes the picture, and says what there is to say."""
    from .lens_reports import page

    out = Path(arguments.output)
    page.write(found, out, report.size_in(found), title, draw or report.draw)
    first = found[0] if isinstance(found, list) else found
    fields = first.get("fields") or first["defocus"][0]["fields"]
    dark = [f"no light from {f['angle_deg']:g} degrees comes to the film" for f in fields if f.get("is_dark")]
    say([*lens.remarks, *lens.range_notes(first["wavelengths_nm"]), *dark])
    print(f"{out}: {first['name']}")
    return 0


def _spots(arguments: argparse.Namespace) -> int:
    from . import _native
    from .lens_reports import spots, titles

    lens = _lens(arguments)
    answer = _native.lens_spots_json(
        lens, setting_of(arguments), look_of(arguments), arguments.rays, list(arguments.defocus)
    )
    return _finish(arguments, lens, json.loads(answer), titles.SPOTS, spots)


def _fans(arguments: argparse.Namespace) -> int:
    from . import _native
    from .lens_reports import fans, titles

    lens = _lens(arguments)
    found = json.loads(_native.lens_fans_json(lens, setting_of(arguments), look_of(arguments), arguments.rays))
    if arguments.path:
        draw = partial(fans.draw, key="path_waves")
        return _finish(arguments, lens, found, titles.PATHS, fans, draw)
    return _finish(arguments, lens, found, titles.FANS, fans)


def _mtf(arguments: argparse.Namespace) -> int:
    from . import _native
    from .lens_reports import mtf, titles

    lens = _lens(arguments)
    frequencies, heights = (arguments.frequency, arguments.steps), (arguments.heights, arguments.height_frequency)
    answer = _native.lens_mtf_json(lens, setting_of(arguments), look_of(arguments), frequencies, heights)
    found = json.loads(answer)
    return _finish(arguments, lens, found, titles.mtf(found), mtf)


def _psf(arguments: argparse.Namespace) -> int:
    from . import _native
    from .lens_reports import psf, titles

    lens = _lens(arguments)
    found = json.loads(_native.lens_psf_json(lens, setting_of(arguments), look_of(arguments)))
    return _finish(arguments, lens, found, titles.psf(found), psf)


def _distortion(arguments: argparse.Namespace) -> int:
    from . import _native
    from .lens_reports import distortion, titles

    lens = _lens(arguments)
    found = json.loads(_native.lens_distortion_json(lens, setting_of(arguments), look_of(arguments), arguments.count))
    return _finish(arguments, lens, found, titles.DISTORTION, distortion)


def _illumination(arguments: argparse.Namespace) -> int:
    from . import _native
    from .lens_reports import illumination, titles

    if arguments.f_numbers and arguments.f_number is not None:
        arguments.usage_error("--f-numbers stands instead of --f-number: leave out the one or the other")
    if arguments.f_numbers and arguments.pupil_diameter is not None:
        arguments.usage_error("--f-numbers stands instead of --pupil-diameter: leave out the one or the other")
    lens, setting, look = _lens(arguments), setting_of(arguments), look_of(arguments)
    settings = [replace(setting, f_number=n) for n in arguments.f_numbers] or [setting]
    found = [json.loads(_native.lens_illumination_json(lens, one, look, arguments.count)) for one in settings]
    return _finish(arguments, lens, found, titles.ILLUMINATION, illumination)


def _transmission(arguments: argparse.Namespace) -> int:
    from . import _native
    from .lens_reports import titles, transmission

    first, last, step = arguments.spectrum
    steps = (last - first) / step if step > 0.0 else 0.0
    if not 1.0 <= steps <= 1999.0:
        arguments.usage_error("--spectrum FROM TO STEP: two wavelengths and a step between them, at most 2000 in all")
    spectrum = [first + step * i for i in range(int(steps + 1e-9) + 1)]
    lens = _lens(arguments)
    found = json.loads(_native.lens_transmission_json(lens, setting_of(arguments), look_of(arguments), spectrum))
    assumed = (
        [f"its file names no coating: {found['coatings'][0]['name']} is assumed"] if found["coating_is_assumed"] else []
    )
    if found["unknown_absorption"]:
        assumed.append(f"counted as clear, for their absorption is not known: {', '.join(found['unknown_absorption'])}")
    status = _finish(arguments, lens, found, titles.transmission(found), transmission)
    say(assumed)
    return status
