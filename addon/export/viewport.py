# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender's own camera frames: shader nodes know camera and window by it, whatever lens takes the photograph."""

from __future__ import annotations

from typing import Any

from ..description import CameraDescription


def send(builder: Any, camera: CameraDescription, width: int, height: int) -> None:
    """Tells the engine's builder; width and height in pixels."""
    across = camera.pinhole_focal_length_mm / camera.pinhole_film_width_mm
    # In widths of a pixel.
    up = height * camera.pixel_aspect
    larger = max(width, up)
    x, y = camera.pinhole_shift
    builder.set_viewport(
        camera.object_name,
        camera.matrix_world,
        (across, across * width / up),
        (0.5 - x * larger / width, 0.5 - y * larger / up),
        (width, height),
    )
