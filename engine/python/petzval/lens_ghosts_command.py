# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval lens ghosts`: reads arguments, asks the engine, prints its answer. Computes nothing."""

from __future__ import annotations

import argparse
import json
from typing import Any

from .argument_types import film, natural, number
from .lens_loading import load, say
from .lens_setting import add_focus, add_setting, setting_of

#: Rows of the table, unless others are asked for.
_ROWS = 20


def add_parser(actions: argparse._SubParsersAction[argparse.ArgumentParser], kinds: str) -> None:
    """Adds `ghosts`."""
    ghosts = actions.add_parser(
        "ghosts", help="light reflected between the surfaces, the brightest first", allow_abbrev=False
    )
    ghosts.add_argument("lens", metavar="FILE", help=f"a lens file ({kinds}), or the name of a shipped lens")
    ghosts.add_argument(
        "--angle", type=number, default=0.0, metavar="DEG", help="of a far source to the axis; default: 0"
    )
    ghosts.add_argument(
        "--azimuth", type=number, default=90.0, metavar="DEG", help="of it, from right to up; default: 90"
    )
    ghosts.add_argument("--wavelength", type=number, default=550.0, metavar="NM", help="nanometres; default: 550")
    ghosts.add_argument(
        "--film", type=film, metavar="WxH|NAME", help="of the picture, mm; default: the lens file's, or 36x24"
    )
    ghosts.add_argument("--reflections", type=int, choices=(2, 4), default=2, help="of a path; default: 2")
    ghosts.add_argument(
        "--count", type=natural, default=_ROWS, metavar="N", help=f"rows of the table; default: {_ROWS}"
    )
    ghosts.add_argument(
        "--brute-force", type=natural, default=0, metavar="RAYS",
        help="and find the light on the film by rays that part at every surface, for comparison",
    )  # fmt: skip
    ghosts.add_argument("--seed", type=natural, default=0, metavar="N", help="of these rays; default: 0")
    add_setting(ghosts)
    add_focus(ghosts)
    ghosts.add_argument("--json", action="store_true", help="print one JSON object")
    ghosts.set_defaults(run=_ghosts)


def _ghosts(arguments: argparse.Namespace) -> int:
    from . import _native

    lens = load(arguments.lens)
    answer = _native.lens_ghosts_json(
        lens,
        setting_of(arguments),
        angle_deg=arguments.angle,
        azimuth_deg=arguments.azimuth,
        wavelength_nm=arguments.wavelength,
        focus_distance_mm=arguments.focus_distance,
        film_mm=arguments.film,
        reflections=arguments.reflections,
        brute_force_rays=arguments.brute_force,
        seed=arguments.seed,
    )
    found = json.loads(answer)
    notes = [*lens.remarks, *lens.range_notes([arguments.wavelength])]
    if arguments.json:
        print(json.dumps({**found, "notes": notes}) if notes else answer)
    else:
        print(_table(found, arguments.count))
        say(notes)
    return 0


def _table(found: dict[str, Any], count: int) -> str:
    """The ghosts as a table for a terminal."""
    lines = [
        f"{found['name']}, f/{found['f_number']:.3g}, a far source at {found['angle_deg']:g} degrees, {found['wavelength_nm']:g} nm",
        "irradiance and light are for one of irradiance before the lens; places in the picture from its middle",
        "",
        f"{'surfaces':>14} {'irradiance':>12} {'radius mm':>10} {'right mm':>9} {'up mm':>9} {'light mm²':>11} {'on film':>11}",
    ]
    for ghost in found["ghosts"][:count]:
        surfaces = "-".join(str(i) for i in ghost["surfaces"])
        right, up = ghost["centre_mm"]
        lines.append(
            f"{surfaces:>14} {ghost['irradiance']:12.3e} {ghost['radius_mm']:10.3f} {right:9.3f} {up:9.3f} "
            f"{ghost['light_mm2']:11.3e} {ghost['on_film_mm2']:11.3e}"
        )
    left = len(found["ghosts"]) - count
    if left > 0:
        lines.append(f"and {left} weaker ones; --count {len(found['ghosts'])} shows all")
    lines += ["", f"on the film together: {found['on_film_mm2']:.4e} mm²"]
    if brute := found["brute_force"]:
        turned = found["reflections"]
        sums = brute["on_film_mm2"]
        lines.append(
            f"by brute force, {brute['rays']} rays: {sums[turned]:.4e} ± {brute['error_mm2'][turned]:.1e} mm² of {turned} reflections, "
            f"{sums[0]:.4e} mm² not reflected"
        )
    return "\n".join(lines)
