# SPDX-License-Identifier: GPL-3.0-or-later
"""The words about distortion maps, for the command line and Blender."""

from __future__ import annotations

#: The wavelengths of maps for each colour, by the names of their layers: those of most of a film's red, green and blue, nm.
COLOURS_NM = (("red", 611.4), ("green", 549.1), ("blue", 464.2))


def note(lens_name: str, direction: str, wavelength_nm: float) -> str:
    """The text of a map's header; the direction is "undistort" or "distort"."""
    what = {"undistort": "the lens's picture to a pinhole's", "distort": "a pinhole's picture to the lens's"}[direction]
    return (
        f"{lens_name}: {what}. R and G: where to take a pixel from, 0 to 1 from the lower left. B and A: 1 where that is in the "
        f"picture. Mean rays of the clear pupil at {wavelength_nm:g} nm."
    )
