# SPDX-License-Identifier: GPL-3.0-or-later
"""The effects of a lens in Blender: the user's word on each, and a plan in short. No bpy."""

from __future__ import annotations

from typing import Any

from petzval.effects import EFFECTS

#: The effects that are laid over the finished picture.
STRAYS = ("ghosts", "glare", "diffraction")
#: The values of an effect's setting: identifier, name, tooltip, icon, number in saved files.
WORDS = (
    ("AUTO", "Auto", "Simulated where this picture would show it", "", 0),
    ("ON", "On", "Simulated in any case", "", 1),
    ("OFF", "Off", "Left out in any case", "", 2),
)
#: Reflections that a ghost's path has at most: identifier, name, tooltip, icon, number in saved files.
REFLECTIONS = (
    ("2", "Two", "Paths with two reflections: nearly all that is seen", "", 0),
    ("4", "Four", "Paths with four reflections, too: a hundred times as many, and each far weaker", "", 1),
)
LABELS = {effect.name: effect.label for effect in EFFECTS}


def wishes(settings: Any) -> dict[str, Any]:
    """The scene's wishes for each effect, for the engine."""
    words = {effect.name: getattr(settings.effects, effect.name).lower() for effect in EFFECTS}
    return {"effects": words, "quality": settings.quality, "ghost_reflections": int(settings.ghost_reflections)}


def size(row: dict[str, Any]) -> str:
    """The measured size in a row of the engine's plan, short."""
    if row["is_unbounded"]:
        return "unbounded"
    value, unit = row["measure"], row["unit"]
    if value is None:
        return "–"
    if unit == "of exposure":
        value, unit = 100.0 * value, "%"
    return f"{value:.2g} {unit}" if value < 10.0 else f"{value:.0f} {unit}"


def cost(row: dict[str, Any]) -> str:
    """The cost of simulating an effect: in per cent of the time without it, or in seconds once the picture is done."""
    part, seconds = row.get("predicted_cost"), row.get("picture_seconds")
    if seconds:
        return f"+{seconds:.2g} s"
    if part is None or row["decision"] == "off":
        return ""
    return f"+{100.0 * part:.0f} %" if part >= 0.005 else "free"


def camera(plan: dict[str, Any]) -> str:
    """The camera of a plan, in words: "exact camera, 8 wavelengths"."""
    count = plan["camera"]["wavelengths"]
    light = f"{count} wavelengths" if count > 1 else "one wavelength"
    return f"{plan['camera']['model']} camera, {light}"


def summary(plan: dict[str, Any]) -> str:
    """A plan in a line, for the status of a render."""
    off = [
        LABELS[row["effect"]].lower()
        for row in plan["effects"]
        if row["decision"] == "off" and row["is_available"] and row["measure"]
    ]
    left_out = f", without {', '.join(off)}" if off else ""
    return camera(plan) + left_out
