# SPDX-License-Identifier: GPL-3.0-or-later
"""Images: each sent once, with Blender's magenta where its file is missing."""

from __future__ import annotations

import bpy
import numpy as np

from . import image_file
from .kept import Kept, uid
from .report import Report

MAGENTA = np.array([[[1.0, 0.0, 1.0, 1.0]]], np.float32)
#: From this version on a missing image is magenta beyond its edges too, whatever its extension.
_MISSING_IS_EVERYWHERE = (5, 2, 0)
LINEAR_SPACES = {"Linear", "Linear Rec.709", "scene_linear"}


class Images:
    """The images of one scene, by the engine's index."""

    def __init__(self, kept: Kept, report: Report) -> None:
        self._kept = kept
        self._builder = kept.builder
        self._report = report
        self._known = kept.images
        # Pixels of files that are to be sent, by datablock, and the datablocks whose file was read.
        self._of_files: dict[int, np.ndarray] = {}
        self._read_before: set[int] = set()

    def index(self, image: bpy.types.Image | None, user: str, *, associated: bool) -> int:
        """The engine's index of an image; `user` is who asks, for the warning where there is none.

        `associated`: colours multiplied by alpha, as a node gives them whose alpha is not used.
        """
        key = (uid(image), associated)
        if image is None or self._is_missing(image.original):
            self._warn_of_missing(image, user)
        if key not in self._known:
            name, pixels, srgb = self._read(image and image.original, associated)
            opaque = bool((pixels[..., 3] == pixels.dtype.type(255 if pixels.dtype == np.uint8 else 1)).all())
            self._known[key] = self._builder.add_image(name, pixels, srgb=srgb)
            self._kept.changes += 1
            if opaque:
                self._known[key[0], not associated] = self._known[key]
        return self._known[key]

    def of_node(self, node: bpy.types.Node, owner: str) -> int | None:
        """The engine's index of the image that a texture node shows, its colours multiplied by alpha or not as the node
        gives them; None where the image is missing, which is named: a missing image is magenta wherever it is read."""
        if node.image is None or (self._is_missing(node.image.original) and not _ends_at_its_edge(node)):
            self._warn_of_missing(node.image, owner)
            return None
        associated = node.type == "TEX_ENVIRONMENT" or not node.outputs["Alpha"].is_linked
        return self.index(node.image, owner, associated=associated)

    def _is_missing(self, image: bpy.types.Image) -> bool:
        """Whether there are no pixels of it. Those that its file gives are kept until they are sent: Blender then has not to read it, too."""
        key = uid(image)
        if key in self._read_before or key in self._of_files:
            return False
        if not {(key, False), (key, True)}.isdisjoint(self._known) and image_file.is_there(image):
            return False
        read = image_file.pixels(image)
        if read is None:
            return _has_no_pixels(image)
        self._of_files[key] = read
        return False

    def _read(self, image: bpy.types.Image | None, associated: bool) -> tuple[str, np.ndarray, bool]:
        """Name, pixels (height, width, 4) from below, and whether they are sRGB-encoded; those of a missing image are magenta."""
        if image is None or self._is_missing(image):
            return "(missing)", MAGENTA, False
        self._warn_of_kind(image)
        read = self._of_files.pop(uid(image), None)
        if read is None:
            # Sent before, with colours and alpha together or apart, and now the other way.
            read = image_file.pixels(image)
        if read is not None:
            self._read_before.add(uid(image))
            _associate_bytes(image, read, associated)
            return image.name, read, self._is_srgb(image)
        width, height = image.size
        values = np.empty(width * height * image.channels, np.float32)
        image.pixels.foreach_get(values)
        pixels = _four_channels(values.reshape(height, width, image.channels))
        _associate(image, pixels, associated)
        # Blender turns the pixels of float images into scene-linear ones when it loads them.
        if image.is_float:
            return image.name, pixels, False
        return image.name, _bytes(pixels), self._is_srgb(image)

    def _warn_of_missing(self, image: bpy.types.Image | None, user: str) -> None:
        if image is None:
            self._report.warn(f"{user}: no image is chosen, magenta is shown")
            return
        path = bpy.path.abspath(image.original.filepath, library=image.original.library) or "no file"
        self._report.warn(f"Image '{image.name}' cannot be read ({path}), magenta is shown: restore the file")

    def _warn_of_kind(self, image: bpy.types.Image) -> None:
        if image.source == "TILED" and len(image.tiles) > 1:
            self._report.warn(f"Image '{image.name}': tiles (UDIM) are not supported yet, its first tile is used")
        elif image.source in {"SEQUENCE", "MOVIE"}:
            self._report.warn(f"Image '{image.name}': image sequences are not supported yet, one frame is used")

    def _is_srgb(self, image: bpy.types.Image) -> bool:
        settings = image.colorspace_settings
        if settings.is_data or settings.name in LINEAR_SPACES:
            return False
        if settings.name != "sRGB":
            self._report.warn(
                f"Image '{image.name}': the colour space {settings.name} is not supported yet, it is taken as sRGB"
            )
        return True


def _ends_at_its_edge(node: bpy.types.Node) -> bool:
    """Whether a missing image is a pixel beyond which nothing is: so in the Cycles of older versions."""
    return bpy.app.version < _MISSING_IS_EVERYWHERE and node.type == "TEX_IMAGE" and node.extension == "CLIP"


def _has_no_pixels(image: bpy.types.Image) -> bool:
    """Whether Blender has no pixels of it."""
    width, height = image.size
    return width == 0 or height == 0 or image.channels == 0


def _associate(image: bpy.types.Image, pixels: np.ndarray, wanted: bool) -> None:
    """Brings colours and alpha together, or apart, where the image's alpha means transparency."""
    if image.channels in (1, 3) or image.alpha_mode in {"CHANNEL_PACKED", "NONE"}:
        return
    if image.colorspace_settings.is_data:
        return
    # Bytes are kept apart from alpha; floats together with it, but from 5.0 on as the image says.
    held = image.is_float and (image.alpha_mode == "PREMUL" or bpy.app.version < (5, 0, 0))
    alpha = pixels[..., 3]
    if wanted == held or (alpha == 1.0).all():
        return
    factor = alpha if wanted else np.reciprocal(alpha, where=alpha > 0.0, out=np.ones_like(alpha))
    # One channel at a time: twice as fast as all three at once.
    for channel in range(3):
        pixels[..., channel] *= factor


def _associate_bytes(image: bpy.types.Image, pixels: np.ndarray, wanted: bool) -> None:
    """Brings colours and alpha of bytes together, as `_associate`; rounded, as `_bytes` does."""
    if not wanted or image.alpha_mode == "CHANNEL_PACKED" or image.colorspace_settings.is_data:
        return
    alpha = pixels[..., 3].astype(np.uint16)
    if (alpha == 255).all():
        return
    for channel in range(3):
        pixels[..., channel] = (pixels[..., channel] * alpha + np.uint16(127)) // np.uint16(255)


def _bytes(pixels: np.ndarray) -> np.ndarray:
    """Eight bits a channel again, as the file had them: from 0 to 1. Uses the array up: large images are large."""
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
