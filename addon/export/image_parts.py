# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts of an image that are pictures by themselves: the frames of a sequence or movie, and tiles (UDIM)."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import bpy

#: The number of a frame, or of a tile; None of an image that is one picture.
Part = int | None

#: The tile at the origin of UV space.
FIRST_TILE = 1001
#: True if Blender gives Python the frames of a movie: from 4.3 on.
READS_MOVIES = "frame" in bpy.types.Image.bl_rna.functions["scale"].parameters
_FOLLOW_THE_FRAME = {"SEQUENCE", "MOVIE"}
#: The last digits of a file's name before its ending.
_FRAME_IN_NAME = re.compile(r"(\d+)(?=\D*$)")


@dataclass(frozen=True)
class Timing:
    """The frame range of an image, relative to the scene's frame: the settings of a texture node's image user."""

    start: int
    offset: int
    duration: int
    is_cyclic: bool
    #: Views follow, too.
    is_refreshed: bool

    @classmethod
    def of(cls, node: bpy.types.Node) -> Timing | None:
        """The timing of a texture node; None where its image does not follow the frame."""
        if node.image is None or node.image.source not in _FOLLOW_THE_FRAME:
            return None
        user = node.image_user
        return cls(user.frame_start, user.frame_offset, user.frame_duration, user.use_cyclic, user.use_auto_refresh)

    def frame(self, scene_frame: int) -> int:
        """The image's frame, as Blender counts it: 0 before the first, and of a duration of 0."""
        if self.duration == 0:
            return 0
        frame = scene_frame - self.start + 1
        if self.is_cyclic:
            frame = (frame - 1) % self.duration + 1
        return min(max(frame, 0), self.duration) + self.offset


def path(image: bpy.types.Image, part: Part) -> str:
    """The file of a part; empty where there is none."""
    found = bpy.path.abspath(image.filepath, library=image.library)
    if not found:
        return ""
    if image.source == "SEQUENCE":
        folder, name = os.path.split(found)
        return os.path.join(folder, _of_frame(name, part or 0))
    if image.source == "TILED":
        number = FIRST_TILE if part is None else part
        column, row = (number - FIRST_TILE) % 10, (number - FIRST_TILE) // 10
        found = found.replace("<UDIM>", f"{number:04d}").replace("<UVTILE>", f"u{column + 1}_v{row + 1}")
    return os.path.normpath(found)


def packed(image: bpy.types.Image, part: Part) -> bytes | None:
    """The file of a part that lies in the .blend; None where it does not."""
    if image.source != "TILED":
        return None if image.packed_file is None else image.packed_file.data
    one = next((one for one in image.packed_files if one.tile_number == part and one.packed_file is not None), None)
    return None if one is None else one.packed_file.data


@contextmanager
def opened(image: bpy.types.Image, part: Part) -> Iterator[bpy.types.Image | None]:
    """An image whose own pixels are those of a part, as Blender reads them; None where they cannot be read."""
    if part is None or _is_painted(image, part):
        yield image
        return
    made = _of_movie(image, part) if image.source == "MOVIE" else _of_file(image, part)
    try:
        yield made
    finally:
        if made is not None:
            bpy.data.images.remove(made)


def _of_frame(name: str, frame: int) -> str:
    """The name of a sequence's file with another frame in it."""
    stem, ending = os.path.splitext(name)
    found = _FRAME_IN_NAME.search(stem)
    if found is None:
        return f"{stem}{frame or ''}{ending}"
    return f"{stem[: found.start()]}{max(frame, 0):0{len(found[1])}d}{stem[found.end() :]}{ending}"


def _is_painted(image: bpy.types.Image, part: Part) -> bool:
    """True if a tile is made in Blender and was never saved: Blender shows the pixels of such a tile where it is the first."""
    return image.source == "TILED" and image.tiles[0].number == part and image.tiles[0].is_generated_tile


def _of_movie(image: bpy.types.Image, frame: int) -> bpy.types.Image | None:
    """A copy of a movie at a frame. Nothing but `scale` takes a frame from Python: then it is the copy's last one, which its pixels are of
    when they are read again."""
    if not READS_MOVIES:
        return None
    made = image.copy()
    try:
        made.scale(1, 1, frame=frame)
        made.buffers_free()
    except RuntimeError:
        bpy.data.images.remove(made)
        return None
    return made


def _of_file(image: bpy.types.Image, part: Part) -> bpy.types.Image | None:
    """The file of a part as an image of its own, read as the image says."""
    data = packed(image, part)
    try:
        if data is None:
            # What is not there Blender would complain of.
            if not os.path.isfile(path(image, part)):
                return None
            made = bpy.data.images.load(path(image, part))
        else:
            made = bpy.data.images.new(image.name, 1, 1)
            made.pack(data=data, data_len=len(data))
            made.source = "FILE"
    except RuntimeError:
        return None
    made.colorspace_settings.name = image.colorspace_settings.name
    made.alpha_mode = image.alpha_mode
    return made
