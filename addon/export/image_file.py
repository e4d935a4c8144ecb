# SPDX-License-Identifier: GPL-3.0-or-later
"""Pixels of images straight from their files.

Blender gives the pixels of an image as floats, in several times the time that reading its file takes; and once it has read the file itself.
Blender's own reader of files (the module imbuf) gives bytes: the same numbers, for images that are neither painted nor converted on the
way.
"""

from __future__ import annotations

import os

import bpy
import imbuf
import numpy as np

from . import image_parts
from .image_parts import Part

#: The first bytes of files, and the place where a PNG says how many bits a channel has.
_JPEG, _PNG, _PNG_BITS_AT = b"\xff\xd8\xff", b"\x89PNG\r\n\x1a\n", 24
#: Treatments of alpha that leave the bytes of a file as they are.
_AS_IN_FILE = {"STRAIGHT", "CHANNEL_PACKED"}
#: Images, or parts of them, that are files each.
_OF_FILES = {"FILE", "SEQUENCE", "TILED"}


def is_there(image: bpy.types.Image, part: Part = None) -> bool:
    """True if the image, or a part of it, has a file, packed or beside the .blend: Blender has then not to be asked whether it has pixels.
    Of an image that is one picture it is one that `pixels` may read."""
    if part is None:
        return bool(_head(image, part))
    return image_parts.packed(image, part) is not None or os.path.isfile(image_parts.path(image, part))


def pixels(image: bpy.types.Image, part: Part = None) -> np.ndarray | None:
    """Bytes, (height, width, 4) from below, alpha apart from colours. None where they may be others than those of the image: of files with
    more than eight bits, painted images, movies, alpha that Blender treats; and in Blenders before 5.1."""
    head = _head(image, part)
    is_jpeg, is_png = head.startswith(_JPEG), head.startswith(_PNG) and head[_PNG_BITS_AT] <= 8
    if not (is_jpeg or is_png):
        return None
    try:
        data = image_parts.packed(image, part)
        loaded = imbuf.load_from_buffer(data) if data is not None else imbuf.load(image_parts.path(image, part))
    except (OSError, ValueError):
        return None
    try:
        if loaded.buffer_type != "BYTE":
            return None
        with loaded.with_buffer() as buffer:
            found = np.array(buffer, np.uint8)
    finally:
        loaded.free()
    if found.ndim != 3 or found.shape[2] != 4:
        return None
    return found if image.alpha_mode in _AS_IN_FILE or (found[..., 3] == 255).all() else None


def _head(image: bpy.types.Image, part: Part) -> bytes:
    """The first bytes of the file of an image or a part; empty where it is no single file."""
    is_readable = hasattr(imbuf.types.ImBuf, "with_buffer")
    if not is_readable or image.source not in _OF_FILES or image.is_multiview or image.use_deinterlace:
        return b""
    # What is painted on tiles is in Cycles' pictures from when it is saved.
    if image.source == "FILE" and (image.is_dirty or len(image.packed_files) > 1):
        return b""
    count, data = _PNG_BITS_AT + 1, image_parts.packed(image, part)
    if data is not None:
        return data[:count].ljust(count, b"\xff")
    try:
        with open(image_parts.path(image, part), "rb") as file:
            return file.read(count).ljust(count, b"\xff")
    except OSError:
        return b""
