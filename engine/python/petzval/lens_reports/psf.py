# SPDX-License-Identifier: GPL-3.0-or-later
"""Point spread: the image of a point by diffraction, by field, at linear and logarithmic brightness, and its encircled energy."""

from __future__ import annotations

from typing import Any

from .page import DARK, degrees, field_colour, lengths
from .report import LensReport, together
from .table import Table

#: Decades that the dark picture shows.
_DECADES = 4.0
#: The reach of the bright picture, as a factor of the radius that holds this part of the light.
_ZOOM, _MOST = 1.5, 0.9


def size_in(found: dict[str, Any]) -> tuple[float, float]:
    """The size of the report."""
    return 2.0 + 2.6 * max(len(found["fields"]), 1), 7.6


def draw(found: dict[str, Any], figure: Any) -> None:
    """Draws the report into a figure."""
    fields = found["fields"]
    grid = figure.add_gridspec(3, max(len(fields), 1))
    lit = [field for field in fields if "values" in field]
    reach = max((field["step_mm"] * (field["side"] // 2) for field in lit), default=0.0)
    factor, unit = lengths(reach)
    for i, field in enumerate(fields):
        both = [figure.add_subplot(grid[row, i]) for row in (0, 1)]
        if "values" in field:
            _pictures(found, field, i, both, (factor, unit))
        else:
            _nothing(field, both)
    below = figure.add_subplot(grid[2, :])
    for i, field in enumerate(fields):
        if "values" in field:
            radii = [radius * factor for radius in field["radii_mm"]]
            name = degrees(field["angle_deg"])
            below.plot(radii, field["encircled"], color=field_colour(i), linewidth=1.4, label=name)
    below.set_xlabel(f"radius about the middle of the light, {unit}")
    below.set_ylabel("light within")
    below.set_ylim(0.0, 1.0)
    below.set_xlim(0.0)
    if lit:
        below.legend(loc="lower right", fontsize=8)


def _nothing(field: dict[str, Any], both: list[Any]) -> None:
    why = "dark"
    if not field["is_dark"]:
        factor, unit = lengths(field["spread_mm"])
        times = field["spread_times"]
        why = f"{degrees(field['angle_deg'])}: spread over\n{factor * field['spread_mm']:.3g} {unit}, {times:.0f} λN:\nits rays say all"
    for axes in both:
        axes.text(0.5, 0.5, why, color=DARK, ha="center", va="center", transform=axes.transAxes)
        axes.set_axis_off()


def _pictures(
    found: dict[str, Any], field: dict[str, Any], number: int, both: list[Any], by: tuple[float, str]
) -> None:
    import numpy as np

    factor, unit = by
    side = field["side"]
    values = np.array(field["values"]).reshape(side, side)
    half = 0.5 * side * field["step_mm"] * factor
    extent = (-half, half, -half, half)
    bright, dark = both
    for axes in both:
        axes.set_aspect("equal")
        axes.grid(False)
    bright.imshow(values, extent=extent, origin="lower", cmap="inferno", vmin=0.0, interpolation="nearest")
    # Near the middle, where most of the light is.
    most = (r for r, part in zip(field["radii_mm"], field["encircled"], strict=True) if part > _MOST)
    near = min(half, _ZOOM * factor * next(most, half / factor))
    bright.set_xlim(-near, near)
    bright.set_ylim(-near, near)
    shown = np.log10(np.maximum(values / max(values.max(), 1e-300), 10.0**-_DECADES))
    dark.imshow(shown, extent=extent, origin="lower", cmap="inferno", vmin=-_DECADES, vmax=0.0, interpolation="nearest")
    main = field["strehl"][found["main_wavelength"]]
    bright.set_title(f"{degrees(field['angle_deg'])}: Strehl {main:.3f}", color=field_colour(number))
    dark.set_title(f"{_DECADES:.0f} decades", color=DARK)
    if number == 0:
        bright.set_ylabel(f"tangential, {unit}")
        dark.set_ylabel(f"tangential, {unit}")
    dark.set_xlabel(f"sagittal, {unit}")


#: Parts of the light whose radius the table has.
_WITHIN = (0.5, 0.8, 0.9)


def _table(found: dict[str, Any]) -> Table:
    headings = ["field °", "height mm", "Strehl", *(f"{100 * part:.0f} % within mm" for part in _WITHIN)]
    rows = []
    for field in found["fields"]:
        if field["is_dark"]:
            rows.append([field["angle_deg"], "dark", *[None] * (len(headings) - 2)])
        elif "values" not in field:
            said = f"over {field['spread_times']:.0f} λN: too far for waves, petzval lens spots says all"
            rows.append([field["angle_deg"], field.get("height_mm"), said, *[None] * len(_WITHIN)])
        else:
            curve = list(zip(field["radii_mm"], field["encircled"], strict=True))
            within = [next((radius for radius, light in curve if light >= part), None) for part in _WITHIN]
            rows.append([field["angle_deg"], field["height_mm"], field["strehl"][found["main_wavelength"]], *within])
    return Table(headings, rows)


REPORT = LensReport(
    name="psf",
    label="Point Spread",
    help="what diffraction and aberrations make of a point",
    description="The image of a point with diffraction and aberrations",
    place=40,
    size_in=size_in,
    draw=draw,
    table=_table,
    title=lambda found: f"point spread with diffraction, {together(found)}",
)
