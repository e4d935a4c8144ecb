# SPDX-License-Identifier: GPL-3.0-or-later
"""Pixels of images as the engine takes them: RGBA, bytes or floats, colours and alpha together or apart."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np


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

    def sent(self, *, associated: bool) -> np.ndarray:
        """RGBA for the engine: bytes, or floats where Blender holds floats. Uses the values up: large images are large."""
        if self.values.dtype == np.uint8:
            self._associate_bytes(associated)
            return self.values
        channels = self.values.shape[2]
        pixels = _four_channels(self.values)
        if channels not in (1, 3):
            self._associate(pixels, associated)
        return pixels if self.is_float else _bytes(pixels)

    def _associate(self, pixels: np.ndarray, wanted: bool) -> None:
        """Brings colours and alpha together, or apart, where the image's alpha means transparency."""
        if self.is_data or self.alpha_mode in {"CHANNEL_PACKED", "NONE"}:
            return
        # Bytes are kept apart from alpha; floats together with it, but from 5.0 on as the image says.
        held = self.is_float and (self.alpha_mode == "PREMUL" or bpy.app.version < (5, 0, 0))
        alpha = pixels[..., 3]
        if wanted == held or (alpha == 1.0).all():
            return
        factor = alpha if wanted else np.reciprocal(alpha, where=alpha > 0.0, out=np.ones_like(alpha))
        # One channel at a time: twice as fast as all three at once.
        for channel in range(3):
            pixels[..., channel] *= factor

    def _associate_bytes(self, wanted: bool) -> None:
        """Brings colours and alpha of a file's bytes together, as `_associate`; rounded, as `_bytes` does."""
        if not wanted or self.is_data or self.alpha_mode == "CHANNEL_PACKED":
            return
        alpha = self.values[..., 3].astype(np.uint16)
        if (alpha == 255).all():
            return
        for channel in range(3):
            self.values[..., channel] = (self.values[..., channel] * alpha + np.uint16(127)) // np.uint16(255)


def is_opaque(pixels: np.ndarray) -> bool:
    """True if alpha is 1 everywhere."""
    return bool((pixels[..., 3] == pixels.dtype.type(255 if pixels.dtype == np.uint8 else 1)).all())


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
