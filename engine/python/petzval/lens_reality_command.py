# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval lens reality`: a lens beside photographers' measurements of its product. Reads arguments, asks the engine, draws its answer."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from .argument_types import natural, number
from .lens_loading import load, say
from .lens_reports.page import DARK, PALE, field_colour
from .lens_setting import add_focus, add_setting, setting_of
from .sensor_options import SENSORS


def add_parser(actions: argparse._SubParsersAction[argparse.ArgumentParser], kinds: str) -> None:
    """Adds `reality`."""
    reality = actions.add_parser(
        "reality", help="distortion, vignetting, lateral colour beside a lensfun calibration", allow_abbrev=False
    )
    reality.add_argument("lens", metavar="FILE", help=f"a lens file ({kinds}), or the name of a shipped lens")
    reality.add_argument(
        "--lensfun", metavar="PATH",
        help="a lensfun database: an .xml file, or the folder that holds them; default: the installed one",
    )  # fmt: skip
    reality.add_argument(
        "--product", metavar="NAME", help="of the lens in the database; default: that of the lens file"
    )
    reality.add_argument(
        "--marked", type=number, metavar="MM",
        help="focal length that the product is marked with; default: the measured one nearest to the focal length",
    )  # fmt: skip
    reality.add_argument("--crop-factor", type=number, metavar="C", help="of the camera; default: by the lens's film")
    reality.add_argument(
        "--f-numbers", nargs="+", type=number, default=[], metavar="N", help="of vignetting; default: wide open and 8"
    )
    reality.add_argument(
        "--sensor",
        choices=SENSORS,
        default=SENSORS[0],
        help=f"whose channels see lateral colour; default: {SENSORS[0]}",
    )
    reality.add_argument(
        "--colour-f-number", type=number, default=8.0, metavar="N", help="of lateral colour; default: 8"
    )
    reality.add_argument("--count", type=natural, default=21, metavar="N", help="of the fields; default: 21")
    reality.add_argument(
        "-o", "--output", metavar="OUT", help="a picture: .svg, .png or .pdf; or .json; default: a table is printed"
    )
    add_setting(reality)
    add_focus(reality)
    reality.add_argument("--json", action="store_true", help="print one JSON object")
    reality.set_defaults(run=_reality)


def found_for(lens: Any, settings: Any, **options: Any) -> dict[str, Any]:
    """The engine's comparison of a lens with measurements."""
    from . import _native

    found: dict[str, Any] = json.loads(_native.lens_reality_json(lens, settings, **options))
    return found


def _reality(arguments: argparse.Namespace) -> int:
    from .lens_reports import page

    out = Path(arguments.output) if arguments.output else None
    if out is not None:
        page.check(out)
    lens = load(arguments.lens)
    found = found_for(
        lens,
        setting_of(arguments),
        lensfun=arguments.lensfun,
        product=arguments.product,
        marked_mm=arguments.marked,
        crop_factor=arguments.crop_factor,
        f_numbers=arguments.f_numbers,
        focus_distance_mm=arguments.focus_distance,
        sensor=arguments.sensor,
        colour_f_number=arguments.colour_f_number,
        count=arguments.count,
    )
    if out is not None:
        page.write(found, out, (12.0, 4.2), title(found), draw)
    say(lens.remarks)
    if arguments.json:
        print(json.dumps(found))
    elif out is None:
        print("\n".join(table(found)))
    else:
        print(f"{out}: {found['name']}")
    return 0


def title(found: dict[str, Any]) -> str:
    """The words above the picture."""
    return f"beside {found['product']} at {found['marked_mm']:g} mm, as lensfun has it"


def table(found: dict[str, Any]) -> list[str]:
    """The comparison as a table for a terminal."""
    place, line = found["place"]
    lines = [f"{found['name']}, f = {found['efl_mm']:.4g} mm", f"{title(found)} ({place}:{line})"]
    if (distortion := found["distortion"]) is not None:
        last = distortion["rows"][-1]
        lines += [
            "",
            f"distortion: {1e3 * distortion['rms_mm']:.0f} um apart in the mean, {1e3 * distortion['worst_mm']:.0f} um at worst, "
            f"of {1e3 * distortion['own_mm']:.0f} um; one scale is free, {distortion['scale_mm']:.5g} mm",
            f"at {last['height_mm']:.4g} mm: {100 * last['rays_part']:.2f} % by rays, {100 * last['measured_part']:.2f} % measured",
        ]
    for one in found["vignetting"]:
        known = [row for row in one["rows"] if row["measured_stops"] is not None]
        if not known:
            continue
        worst = max(known, key=lambda row: abs(row["rays_stops"] - row["measured_stops"]))
        last = known[-1]
        lines.append(
            f"light at F/{one['f_number']:.3g}, {last['height_mm']:.4g} mm: {last['rays_stops']:.2f} stops by rays, "
            f"{last['measured_stops']:.2f} measured; farthest apart at {worst['height_mm']:.3g} mm, "
            f"{worst['rays_stops'] - worst['measured_stops']:+.2f}"
        )
    if found["colour"]:
        last = found["colour"][-1]
        lines.append(
            f"lateral colour at {last['height_mm']:.4g} mm, F/{found['colour_f_number']:g}, {found['sensor']}: "
            f"red {1e3 * last['red_mm']:+.1f} um by rays, {1e3 * last['measured_red_mm']:+.1f} measured; "
            f"blue {1e3 * last['blue_mm']:+.1f} um, {1e3 * last['measured_blue_mm']:+.1f} measured"
        )
    return lines


def _named(what: str, found: Any) -> str:
    return what if found else f"{what}: not measured"


def draw(found: dict[str, Any], figure: Any) -> None:
    """Draws into a figure: full lines by rays, dashes as measured."""
    distortion, light, colour = figure.subplots(1, 3)
    for axes in (distortion, colour):
        axes.axhline(0.0, color=PALE, linewidth=0.6)
    if found["distortion"] is not None:
        # On the axis a part of the height is none.
        rows = [row for row in found["distortion"]["rows"] if row["height_mm"] > 0.0]
        heights = [row["height_mm"] for row in rows]
        distortion.plot(
            heights, [100.0 * row["rays_part"] for row in rows], color="#c0392b", linewidth=1.5, label="by rays"
        )
        distortion.plot(
            heights, [100.0 * row["measured_part"] for row in rows], color=DARK, linewidth=1.2, dashes=(4, 2),
            label="measured",
        )  # fmt: skip
        distortion.legend(loc="best", fontsize=8)
    distortion.set_title(_named("distortion", found["distortion"]), color=DARK)
    distortion.set_ylabel("per cent, one scale free")
    for i, one in enumerate(found["vignetting"]):
        rows = [row for row in one["rows"] if row["measured_stops"] is not None]
        heights = [row["height_mm"] for row in rows]
        tint = field_colour(i)
        light.plot(
            heights, [row["rays_stops"] for row in rows], color=tint, linewidth=1.5, label=f"F/{one['f_number']:.3g}"
        )
        light.plot(heights, [row["measured_stops"] for row in rows], color=tint, linewidth=1.2, dashes=(4, 2))
    if found["vignetting"]:
        light.legend(loc="best", fontsize=8)
    light.set_title(_named("vignetting", found["vignetting"]), color=DARK)
    light.set_ylabel("stops from the middle")
    for key, tint in (("red", "#c0392b"), ("blue", "#1f5fae")):
        heights = [row["height_mm"] for row in found["colour"]]
        by_rays = [1e3 * row[f"{key}_mm"] for row in found["colour"]]
        measured = [1e3 * row[f"measured_{key}_mm"] for row in found["colour"]]
        colour.plot(heights, by_rays, color=tint, linewidth=1.5, label=f"{key} from green")
        colour.plot(heights, measured, color=tint, linewidth=1.2, dashes=(4, 2))
    if found["colour"]:
        colour.legend(loc="best", fontsize=8)
    colour.set_title(_named("lateral colour", found["colour"]), color=DARK)
    colour.set_ylabel("um, outwards")
    for axes in (distortion, light, colour):
        axes.set_xlabel("height in the picture, mm")
