# SPDX-License-Identifier: GPL-3.0-or-later
"""What stands above each report."""

from __future__ import annotations

from typing import Any

SPOTS = "spot diagrams, about the middle of their light"
FANS = "ray fans: where rays land, from the middle one"
PATHS = "optical path beyond the middle ray's"
DISTORTION = "rays through the middle of the stop"
ILLUMINATION = "light on the film, of a scene as bright everywhere"


def psf(found: dict[str, Any]) -> str:
    """Of point spread, with its wavelengths."""
    lines = " ".join(f"{nm:.4g}" for nm in found["wavelengths_nm"])
    return f"point spread with diffraction, {lines} nm together"


def mtf(found: dict[str, Any]) -> str:
    """Of modulation transfer, with its wavelengths."""
    lines = " ".join(f"{nm:.4g}" for nm in found["wavelengths_nm"])
    return f"modulation transfer with diffraction, {lines} nm together"


def transmission(found: dict[str, Any]) -> str:
    """Of what passes, with what is left of white light."""
    number = found["t_number"]
    return "light that passes" + ("" if number is None else f", T/{number:.3g} for white")
