# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws a picture into a region of the screen."""

from __future__ import annotations

import bpy
import gpu
import numpy as np
from gpu_extras.presets import draw_texture_2d

from .session import Picture

# The largest that half a float holds.
_BRIGHTEST = 65504.0


class Screen:
    """The picture as the graphics card has it."""

    def __init__(self) -> None:
        self._shown: Picture | None = None
        self._texture: gpu.types.GPUTexture | None = None

    def draw(
        self,
        host: bpy.types.RenderEngine,
        scene: bpy.types.Scene,
        picture: Picture,
        frame: tuple[float, float, float, float],
    ) -> None:
        """`frame`: where the whole picture lies in the region: left, bottom, width, height, pixels."""
        if picture is not self._shown:
            self._texture, self._shown = _texture(picture.pixels), picture
        left, bottom, width, height = frame
        x, y, w, h = picture.place
        gpu.state.blend_set("ALPHA_PREMULT")
        host.bind_display_space_shader(scene)
        draw_texture_2d(self._texture, (left + x * width, bottom + y * height), w * width, h * height)
        host.unbind_display_space_shader()
        gpu.state.blend_set("NONE")


def _texture(pixels: np.ndarray) -> gpu.types.GPUTexture:
    height, width = pixels.shape[:2]
    flat = np.minimum(pixels, _BRIGHTEST, dtype=np.float32).reshape(-1)
    return gpu.types.GPUTexture((width, height), format="RGBA16F", data=gpu.types.Buffer("FLOAT", len(flat), flat))
