# SPDX-License-Identifier: GPL-3.0-or-later
"""What a lens lets through of each colour, by field, and what its coatings reflect."""

from __future__ import annotations

from typing import Any

from .page import degrees, field_colour


def size_in(found: dict[str, Any]) -> tuple[float, float]:
    """Of the report."""
    return 9.0, 4.2


def draw(found: dict[str, Any], figure: Any) -> None:
    """Into a figure: on the left what passes, on the right what one surface of each coating reflects."""
    through, back = figure.subplots(1, 2)
    spectrum = found["spectrum_nm"]
    for i, field in enumerate(field for field in found["fields"] if field["parts"]):
        parts = [100.0 * part for part in field["parts"]]
        through.plot(spectrum, parts, color=field_colour(i), linewidth=1.5, label=degrees(field["angle_deg"]))
    for i, coating in enumerate(found["coatings"]):
        name = f"{coating['name']}, first before {coating['before']}"
        back.plot(spectrum, [100.0 * r for r in coating["reflected"]], color=field_colour(i), linewidth=1.5, label=name)
    through.set_ylabel("light that passes, per cent")
    back.set_ylabel("reflected at right angles, per cent")
    for axes in (through, back):
        axes.set_xlim(spectrum[0], spectrum[-1])
        axes.set_xlabel("wavelength, nm")
        axes.legend(loc="best", fontsize=8)
    through.set_ylim(0.0, 100.0)
    most = max((100.0 * max(coating["reflected"]) for coating in found["coatings"]), default=1.0)
    back.set_ylim(0.0, 1.1 * most)
