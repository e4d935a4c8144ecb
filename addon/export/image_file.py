# SPDX-License-Identifier: GPL-3.0-or-later
"""Pixels of images straight from their files.

Blender gives the pixels of an image as floats, in several times the time that reading its file takes; and once it has read the file itself.
Blender's own reader of files (the module imbuf) gives bytes: the same numbers, for what is neither painted nor treated on the way.
"""

from __future__ import annotations

import os

import bpy
import imbuf
import numpy as np

#: What a file begins with, and where a PNG says how many bits a channel has.
_JPEG, _PNG, _PNG_BITS_AT = b"\xff\xd8\xff", b"\x89PNG\r\n\x1a\n", 24
#: Treatments of alpha that leave the bytes of a file as they are.
_AS_IN_FILE = {"STRAIGHT", "CHANNEL_PACKED"}


def is_there(image: bpy.types.Image) -> bool:
    """Whether the image has a file, itself or beside the .blend, that `pixels` may read: Blender has then not to read it."""
    return bool(_head(image))


def pixels(image: bpy.types.Image) -> np.ndarray | None:
    """Bytes, (height, width, 4) from below, alpha apart from colours. None where they may be others than those of the image: of files with
    more than eight bits, painted images, movies, alpha that Blender treats; and in Blenders before 5.1."""
    head = _head(image)
    is_jpeg, is_png = head.startswith(_JPEG), head.startswith(_PNG) and head[_PNG_BITS_AT] <= 8
    if not (is_jpeg or is_png):
        return None
    try:
        packed = image.packed_file
        loaded = imbuf.load_from_buffer(packed.data) if packed is not None else imbuf.load(_path(image))
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


def _head(image: bpy.types.Image) -> bytes:
    """The first bytes of an image's file; empty where the image is no single file."""
    is_readable = hasattr(imbuf.types.ImBuf, "with_buffer")
    is_treated = image.is_dirty or image.is_multiview or image.use_deinterlace
    if not is_readable or image.source != "FILE" or is_treated or len(image.packed_files) > 1:
        return b""
    count = _PNG_BITS_AT + 1
    if image.packed_file is not None:
        return image.packed_file.data[:count].ljust(count, b"\xff")
    try:
        with open(_path(image), "rb") as file:
            return file.read(count).ljust(count, b"\xff")
    except OSError:
        return b""


def _path(image: bpy.types.Image) -> str:
    return os.path.normpath(bpy.path.abspath(image.filepath, library=image.library))
