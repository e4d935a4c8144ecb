# SPDX-License-Identifier: GPL-3.0-or-later
"""The rungs: which cameras take the picture, from the simplest to all that a lens does. No bpy."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from ..description import opened

#: The base camera: times are relative to its time.
PINHOLE = "pinhole"
#: The plan's own choice.
AUTO = "auto"
#: All effects, all wavelengths: the truth, by the pipeline that the engine takes by itself.
TOP = "hero"

#: One wavelength stands for all: the d line.
ONE_NM = 587.5618
#: No effect is too small to be simulated.
FINEST = 100.0

#: Lens effects that are no colours: with one wavelength, these alone can be asked for.
_COLOURS = ("lateral_colour", "axial_colour")

#: Stray light is found once a picture, whatever its samples, and laid over it: each kind is a rung by itself, and in no other.
#: The cameras are held against the truth without it, and each kind of it against the truth with all of it.
STRAYS = {"ghosts": "with ghosts", "glare": "with veiling glare", "diffraction": "with diffraction"}

#: Effects that cannot be simulated yet, but stand in the table so that nobody looks for them in vain.
NOT_YET = {
    "transmission": "with coatings",
    **STRAYS,
}


@dataclass(frozen=True)
class Rung:
    """One camera. `camera` and `settings` are values by dotted name that replace the scene's, `effects` goes to its plan."""

    key: str
    name: str
    #: camera | auto | effect (everything on but one) | stray (everything on and one more)
    group: str
    camera: dict[str, Any] = field(default_factory=dict)
    settings: dict[str, Any] = field(default_factory=dict)
    effects: dict[str, str] = field(default_factory=dict)
    quality: float = 1.0
    #: The reason why it cannot be rendered; None where it can.
    missing: str | None = None


def ladder(camera: Any, info: dict[str, Any], available: list[str], wishes: dict[str, Any]) -> list[Rung]:
    """The rungs for a camera with a lens.

    `info` is the engine's `camera_info_json` of it, `available` the effects that can be simulated, `wishes` the values that the user
    gives to the plan.
    """
    on = {effect: "off" if effect in STRAYS else "on" for effect in available}
    grey = {name: word for name, word in on.items() if name not in _COLOURS}
    one = {"wavelength_nm": ONE_NM}
    full = {"wavelength_nm": None, "spectrum": "VISIBLE"}

    def exact(key: str, name: str, changes: dict[str, Any], effects: dict[str, str], pipeline: str = "AUTO") -> Rung:
        return Rung(key, name, "camera", changes, {"pipeline": pipeline}, effects, FINEST)

    simple = _simple(camera, info)
    rungs = [
        *simple,
        Rung("thick", "thick lens", "camera", {"model": "THICK"}),
        Rung("paraxial", "paraxial lens", "camera", {"model": "PARAXIAL"}),
        exact("one-f32", "exact, one wavelength, f32", one | {"precision": "F32"}, grey),
        exact("one-f64", "exact, one wavelength, f64", one | {"precision": "F64"}, grey),
        exact("rgb", "exact, three indices", {"wavelength_nm": None, "spectrum": "THREE"}, on),
        exact("film", "exact, spectral, film-first", full, on, "FILM"),
        exact("scene", "exact, spectral, scene-first", full, on, "SCENE"),
        exact(TOP, "exact, spectral, hero", full, on, "HERO"),
        Rung(AUTO, "auto: the plan's choice", "auto", {}, {}, _straight(wishes["effects"]), wishes["quality"]),
    ]
    for effect in (one for one in STRAYS if one in available):
        rungs.append(Rung(f"with-{effect}", STRAYS[effect], "stray", full, {"pipeline": "HERO"}, on | {effect: "on"}))
    for effect in (one for one in available if one not in STRAYS):
        words = on | {effect: "off"}
        rungs.append(Rung(f"no-{effect}", _without(effect), "effect", full, {}, words, FINEST))
    for effect, name in NOT_YET.items():
        if effect not in available:
            group = "stray" if effect in STRAYS else "camera"
            rungs.append(Rung(f"with-{effect}", name, group, missing="cannot be simulated yet"))
    return rungs


def _straight(effects: dict[str, str]) -> dict[str, str]:
    return effects | dict.fromkeys(STRAYS, "off")


def effect_of(rung_key: str) -> str | None:
    """The effect that a rung leaves out, or that it alone has."""
    kind, dash, effect = rung_key.partition("-")
    return effect if dash and kind in ("no", "with") else None


def is_camera(row: dict[str, Any]) -> bool:
    """True if a row of costs.json is a camera to choose, and neither one with an effect taken out nor one with stray light added."""
    return row["group"] in ("camera", "auto")


def _without(effect: str) -> str:
    return "without " + ("transmission (coatings, glass)" if effect == "transmission" else effect.replace("_", " "))


def _simple(camera: Any, info: dict[str, Any]) -> list[Rung]:
    """Pinhole and thin lens that frame the same picture; the thin lens as wide open and focused alike."""
    names = {PINHOLE: "pinhole", "thin": "thin lens"}
    focal_mm, pupil_mm = info["viewport_focal_length_mm"], info["entrance_pupil_diameter_mm"]
    if not focal_mm or focal_mm <= 0.0:
        return [Rung(key, name, "camera", missing="sees no half space") for key, name in names.items()]
    frame = {
        "model": "PINHOLE",
        "perspective.focal_length_mm": focal_mm,
        "perspective.film_width_mm": info["picture_width_mm"],
        "perspective.shift": tuple(info["viewport_shift"]),
        # A pinhole has no brightness of its own.
        "exposure": None,
    }
    distance_mm = info["focus_distance_mm"]
    thin = {
        "model": "THIN",
        **(opened(focal_mm, pupil_mm) if pupil_mm else {}),
        "focus.distance": None if distance_mm is None else distance_mm / camera.scale_mm_per_unit[2],
        "focus.point_world": None,
        "focus.film_distance_mm": None,
    }
    return [
        Rung(PINHOLE, names[PINHOLE], "camera", frame),
        Rung("thin", names["thin"], "camera", frame | thin | {"exposure": camera.exposure}),
    ]
