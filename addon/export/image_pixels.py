# SPDX-License-Identifier: GPL-3.0-or-later
"""Pixels of images as the engine takes them: RGBA, bytes or floats, colours multiplied by alpha where that is transparency."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np

#: Ways of an image's alpha in which it is transparency.
TRANSPARENT_MODES = frozenset({"STRAIGHT", "PREMUL"})


@dataclass
class Pixels:
    """The pixels of an image, or of a part of one."""

    #: (height, width, channels) from below: floats as Blender gives them, or the bytes of a file, which have four channels.
    values: np.ndarray
    #: Blender holds floats, which are scene-linear from when it loads them.
    is_float: bool
    alpha_mode: str
    is_data: bool

    @classmethod
    def of_blender(cls, image: bpy.types.Image) -> Pixels | None:
        """The pixels of an image in Blender; None where it has none."""
        width, height = image.size
        if width == 0 or height == 0 or image.channels == 0:
            return None
        values = np.empty(width * height * image.channels, np.float32)
        image.pixels.foreach_get(values)
        return cls._of(image, values.reshape(height, width, image.channels), is_float=image.is_float)

    @classmethod
    def of_bytes(cls, image: bpy.types.Image, values: np.ndarray) -> Pixels:
        """The pixels of an image's file."""
        return cls._of(image, values, is_float=False)

    @classmethod
    def _of(cls, image: bpy.types.Image, values: np.ndarray, *, is_float: bool) -> Pixels:
        return cls(values, is_float, image.alpha_mode, image.colorspace_settings.is_data)

    def sent(self) -> np.ndarray:
        """RGBA for the engine: bytes, or floats where Blender holds floats. Uses the values up: large images are large."""
        is_transparent = (
            self.values.shape[2] not in (1, 3) and not self.is_data and self.alpha_mode in TRANSPARENT_MODES
        )
        if self.values.dtype != np.uint8:
            pixels = _four_channels(self.values)
            self.values = pixels if self.is_float else _bytes(pixels)
        if is_transparent and not self._is_associated():
            _associate(self.values)
        return self.values

    def _is_associated(self) -> bool:
        """True if Blender holds the colours multiplied by alpha: never bytes, floats always, but from 5.0 on as the image says."""
        return self.is_float and (self.alpha_mode == "PREMUL" or bpy.app.version < (5, 0, 0))


def _associate(pixels: np.ndarray) -> None:
    """Multiplies colours by alpha; bytes are rounded down, as in Cycles (`util_image_multiply_native`)."""
    is_bytes = pixels.dtype == np.uint8
    alpha = pixels[..., 3].astype(np.uint16) if is_bytes else pixels[..., 3]
    if (alpha == (255 if is_bytes else 1.0)).all():
        return
    # One channel at a time: twice as fast as all three at once.
    for channel in range(3):
        product = pixels[..., channel] * alpha
        pixels[..., channel] = product // np.uint16(255) if is_bytes else product


def is_transparency(image: bpy.types.Image) -> bool:
    """True if the image's alpha is transparency, by which its colours are multiplied."""
    return not image.colorspace_settings.is_data and image.alpha_mode in TRANSPARENT_MODES


def _bytes(pixels: np.ndarray) -> np.ndarray:
    """Eight bits a channel again, as the file had them: from 0 to 1. Uses the array up."""
    pixels *= 255.0
    pixels += 0.5
    return pixels.astype(np.uint8)


def _four_channels(pixels: np.ndarray) -> np.ndarray:
    """RGBA, whatever the file had."""
    channels = pixels.shape[2]
    if channels == 4:
        return pixels
    out = np.ones((*pixels.shape[:2], 4), np.float32)
    if channels == 3:
        out[..., :3] = pixels
    else:
        out[..., :3] = pixels[..., :1]
        if channels == 2:
            out[..., 3] = pixels[..., 1]
    return out
