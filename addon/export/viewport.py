# SPDX-License-Identifier: GPL-3.0-or-later
"""The window of Blender's own camera: shader nodes know camera and window by it, whatever lens takes the photograph."""

from __future__ import annotations

from typing import Any

from petzval.description import CameraDescription


def send(builder: Any, camera: CameraDescription, width: int, height: int, *, dices: bool = False) -> None:
    """Tells the engine's builder; width and height in pixels. `dices`: of another camera, by whose pixels meshes are diced."""
    is_orthographic = camera.model == "ORTHOGRAPHIC"
    perspective = camera.perspective
    across = (
        1.0 / camera.orthographic_width if is_orthographic else perspective.focal_length_mm / perspective.film_width_mm
    )
    # In widths of a pixel.
    up = height * camera.pixel_aspect
    larger = max(width, up)
    x, y = perspective.shift
    builder.set_viewport(
        camera.object_name,
        camera.matrix_world,
        ((across, across * width / up), (0.5 - x * larger / width, 0.5 - y * larger / up)),
        (width, height),
        camera.panorama,
        is_orthographic,
        dices,
    )
