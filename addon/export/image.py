# SPDX-License-Identifier: GPL-3.0-or-later
"""Images: pixels sent once each, missing ones in Blender's magenta."""

from __future__ import annotations

import bpy
import numpy as np

from ..description import Report

_LINEAR = {"Non-Color", "Raw", "Linear", "Linear Rec.709", "Generic Data"}
_MISSING = np.array([[[1.0, 0.0, 1.0, 1.0]]], np.float32)


class Images:
    """The images that a scene's materials use."""

    def __init__(self, builder, report: Report) -> None:
        self._builder = builder
        self._report = report
        self._sent: dict[str, int] = {}

    def index(self, image: bpy.types.Image | None, user: str) -> int:
        """The engine's number for an image; `user` names who asked, for messages."""
        key = image.name_full if image else ""
        if key not in self._sent:
            self._sent[key] = self._send(image, user)
        return self._sent[key]

    def _send(self, image: bpy.types.Image | None, user: str) -> int:
        if image is None:
            self._report.warn(f"{user}: an image texture has no image; shown in magenta")
            return self._builder.add_image("(none)", _MISSING, srgb=False)
        if image.source == "TILED":
            self._report.warn(f"image '{image.name}': of its UDIM tiles only the first is used yet")
        width, height = image.size
        if width == 0 or height == 0:
            where = bpy.path.abspath(image.filepath, library=image.library) or "not saved"
            self._report.warn(f"image '{image.name}' of {user} is missing ({where}); shown in magenta")
            return self._builder.add_image(image.name, _MISSING, srgb=False)
        pixels = np.empty(width * height * 4, np.float32)
        image.pixels.foreach_get(pixels)
        pixels = pixels.reshape(height, width, 4)
        space = image.colorspace_settings.name
        if not image.is_float:
            if space != "sRGB" and space not in _LINEAR:
                self._report.warn(f"image '{image.name}': its colour space '{space}' is taken as sRGB")
            whole = np.rint(pixels * 255.0).astype(np.uint8)
            return self._builder.add_image(image.name, whole, srgb=space not in _LINEAR)
        # Blender has brought float images to scene-linear already.
        return self._builder.add_image(image.name, pixels, srgb=False)
