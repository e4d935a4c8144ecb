# SPDX-License-Identifier: GPL-3.0-or-later
"""The lens of a camera for which none was chosen: one that is made for the view of Blender's camera. No bpy."""

from __future__ import annotations

import math

# Shipped lenses for film of 36 x 24 mm with the focal lengths on their barrels, mm; the longest first.
_LENSES = (
    (300.0, "nikkor-300-f2.8.lens"),
    (105.0, "nikkor-105-f1.4.lens"),
    (50.0, "nikkor-z-50-f1.8.lens"),
    (28.0, "nikkor-28-f1.4.lens"),
    (21.0, "biogon-21-f4.5.lens"),
    (15.0, "hologon-15-f8.lens"),
)
_DIAGONAL_MM = math.hypot(36.0, 24.0)
# The part of the field for which a lens is made that may be missing at a picture's corners: a picture of 4:3 has longer diagonals on a
# sensor of the same width.
_SPARE = 0.9


def file_name(focal_length_mm: float, picture_width_mm: float, picture_height_mm: float) -> str:
    """The shipped lens for a pinhole's focal length and picture: the longest whose field takes in all of it."""
    diagonal_mm = math.hypot(picture_width_mm, picture_height_mm)
    focal_mm = focal_length_mm * _DIAGONAL_MM / max(diagonal_mm, 1e-9)
    return next((name for marked_mm, name in _LENSES if focal_mm >= _SPARE * marked_mm), _LENSES[-1][1])
