# SPDX-License-Identifier: GPL-3.0-or-later
"""A glass: its index and its transmittance over the wavelength, and its place among others."""

from __future__ import annotations

from typing import Any

from .page import DARK, PALE

SIZE_IN = (10.0, 4.2)
_INDEX, _LIGHT = "#1f5fae", "#c77700"
#: Abbe numbers and indices of the diagram, as makers print it.
_ABBE, _ND = (100.0, 15.0), (1.4, 2.15)


def draw(found: dict[str, Any], figure: Any) -> None:
    """Draws into a figure: the dispersion on the left, Abbe's diagram on the right."""
    left, right = figure.subplots(1, 2, width_ratios=(1.25, 1.0))
    places = [row["wavelength_nm"] for row in found["indices"]]
    left.plot(places, [row["index"] for row in found["indices"]], color=_INDEX, linewidth=1.6)
    left.set_xlim(places[0], places[-1])
    left.set_xlabel("nm in vacuum")
    left.set_ylabel("index", color=_INDEX)
    if found["transmittance_is_known"]:
        light = left.twinx()
        light.plot(places, [row["transmittance"] for row in found["indices"]], color=_LIGHT, linewidth=1.3)
        light.set_ylim(0.0, 1.02)
        light.set_ylabel(f"let through by {found['thickness_mm']:g} mm inside", color=_LIGHT)
        light.grid(False)
    others = [(g["abbe"], g["nd"]) for g in found["others"] if g["abbe"] is not None]
    right.plot(*zip(*others, strict=True), "o", markersize=2.2, color=PALE, markeredgewidth=0.0, rasterized=True)
    if found["abbe"] is not None:
        right.plot([found["abbe"]], [found["nd"]], "o", markersize=8, markerfacecolor="none", color="#c0392b")
        near = {"xytext": (8, 6), "textcoords": "offset points", "color": "#c0392b"}
        right.annotate(found["name"], (found["abbe"], found["nd"]), **near)
    right.set_xlim(*_ABBE)
    right.set_ylim(*_ND)
    right.set_xlabel("Abbe number")
    right.set_ylabel("index at d")
    right.set_title("among the glasses of the catalogues", color=DARK)
