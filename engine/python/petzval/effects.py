# SPDX-License-Identifier: GPL-3.0-or-later
"""The closed list of effects of a lens, by name, label and tooltip, and the values of a setting. The engine's list is the same
(`engine/render/src/plan/effects/`)."""

from __future__ import annotations

from typing import NamedTuple


class Effect(NamedTuple):
    """`name` is the engine's; those that are not available can be measured, but not simulated yet, or the camera has them by a setting of its own."""

    name: str
    label: str
    tooltip: str
    is_available: bool = True


#: The effects in the order of panels and reports.
EFFECTS = (
    Effect("defocus", "Defocus", "Blur of what is not at the distance of focus"),
    Effect("aberration", "Aberrations", "Spherical aberration, coma, astigmatism and field curvature"),
    Effect("distortion", "Distortion", "Straight lines bent towards the picture's edge"),
    Effect("lateral_colour", "Lateral Colour", "Colours of different size: fringes that grow towards the corners"),
    Effect("axial_colour", "Axial Colour", "Colours of different focus: tinted blur before and behind what is sharp"),
    Effect(
        "vignetting",
        "Vignetting",
        "Less light towards the corners. Off: as bright as in the middle; blur keeps its shapes",
    ),
    Effect("diaphragm", "Diaphragm Shape", "Blades or a mask in blur discs. Off: a round opening as large"),
    Effect(
        "motion_blur",
        "Motion Blur",
        "What moves, the camera among it, and a lens that changes, while the shutter is open",
    ),
    Effect("transmission", "Transmission", "What glass and coatings take of each colour"),
    Effect("ghosts", "Ghosts", "Light reflected between the surfaces of the lens"),
    Effect("glare", "Veiling Glare", "Light scattered by surfaces, dust, barrel and film"),
    Effect(
        "diffraction", "Diffraction", "Softness at small openings, and the spikes of bright points: light is a wave"
    ),
    Effect("sensor", "Sensor Noise", "Noise of the camera's sensor in its raw file, where the camera has one", False),
    Effect("spectral_materials", "Spectral Materials", "Materials that are more than three colours", False),
)
#: The values of an effect's setting.
WORDS = ("auto", "on", "off")
