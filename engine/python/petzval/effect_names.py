# SPDX-License-Identifier: GPL-3.0-or-later
"""The closed list of what can be simulated of a lens, as it is written on the command line; the engine has the same."""

#: In the order of reports.
EFFECTS = (
    "defocus",
    "aberration",
    "distortion",
    "lateral_colour",
    "axial_colour",
    "vignetting",
    "diaphragm",
    "motion_blur",
    "transmission",
    "ghosts",
    "glare",
    "diffraction",
    "spectral_materials",
)
#: What may be said of one.
WORDS = ("auto", "on", "off")
