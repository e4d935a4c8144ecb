# SPDX-License-Identifier: GPL-3.0-or-later
"""Images: each frame and tile sent once, with Blender's magenta where its file is missing."""

from __future__ import annotations

import bpy
import numpy as np

from . import image_file, image_parts
from .image_limit import ImageLimit
from .image_parts import FIRST_TILE, Part, Timing
from .image_pixels import Pixels
from .kept import ImageKey, Kept, uid
from .report import Report

#: Interpolated towards nothing as the bytes of a file are.
MAGENTA = np.array([[[255, 0, 255, 255]]], np.uint8)
#: From this version on a missing image is magenta beyond its edges too, whatever its extension.
_MISSING_IS_EVERYWHERE = (5, 2, 0)
#: From this version on a box has tiles, of which it shows the first alone; before, it shows that as an image without tiles.
_BOXES_HAVE_TILES = (5, 2, 0)
LINEAR_SPACES = {"Linear", "Linear Rec.709", "scene_linear"}


class Images:
    """The images of one scene at a frame of it, by the engine's index."""

    def __init__(self, kept: Kept, report: Report, scene_frame: int, limit: ImageLimit | None = None) -> None:
        self._kept = kept
        self._builder = kept.builder
        self._report = report
        self._frame = scene_frame
        self._limit = limit or ImageLimit()
        self._known = kept.images
        # Pixels that are to be sent, and what was read before; by datablock and part.
        self._read: dict[tuple[int, Part], Pixels] = {}
        self._read_before: set[tuple[int, Part]] = set()

    def of_node(self, node: bpy.types.Node, holder: bpy.types.ID) -> int | None:
        """The engine's index of the image that a texture node of a material, world or light shows; None where the image is missing, which is
        named: a missing image is magenta wherever it is read."""
        image, user = node.image, f"{holder.id_type.title()} '{holder.name}'"
        if image is None:
            self._report.warn(f"{user}: no image is chosen, magenta is shown")
            return None
        if image.source == "TILED":
            return self._of_tiled(node)
        timing = Timing.of(node)
        part = None if timing is None else timing.frame(self._frame)
        if timing is not None:
            self._kept.timed.setdefault(uid(holder), {})[ImageKey(uid(image), part)] = timing
        if self._is_missing(image.original, part) and not _ends_at_its_edge(node):
            self._warn_of_missing(image, part)
            return None
        return self.index(image, part)

    def index(self, image: bpy.types.Image, part: Part = None) -> int:
        """The engine's index of an image, or of a part of one."""
        key, original = ImageKey(uid(image), part), image.original
        if self._is_missing(original, part):
            self._warn_of_missing(image, part)
        if key not in self._known:
            pixels, is_linear = self._pixels(original, part)
            name = image.name if part is None else f"{image.name} {part}"
            self._add(key, self._builder.add_image(name, pixels, srgb=not is_linear and self._is_srgb(original)))
        return self._known[key]

    def _of_tiled(self, node: bpy.types.Node) -> int | None:
        """The engine's index of an image of tiles (UDIM), which shows magenta where there is no tile; each tile that is missing is named."""
        image = node.image.original
        if node.type == "TEX_ENVIRONMENT":
            return self._without_tiles(image)
        is_box = node.projection == "BOX"
        if is_box and bpy.app.version < _BOXES_HAVE_TILES:
            return self.index(image, FIRST_TILE)
        numbers = (FIRST_TILE,) if is_box else tuple(sorted(tile.number for tile in image.tiles))
        key = ImageKey(uid(image), numbers)
        tiles = []
        for number in numbers:
            if self._is_missing(image, number):
                self._warn_of_missing(image, number)
                if bpy.app.version >= _MISSING_IS_EVERYWHERE:
                    continue
            tiles.append((number, self.index(image, number)))
        if key not in self._known:
            self._add(key, self._builder.add_tiles(image.name, tiles))
        return self._known[key]

    def _without_tiles(self, image: bpy.types.Image) -> int | None:
        """An environment knows no tiles: it shows the first one that is packed, else nothing, as in Cycles."""
        first = image.tiles[0].number
        told = f"Image '{image.name}': an Environment Texture node has no tiles (UDIM)"
        if image_parts.packed(image, first) is None:
            self._report.warn(f"{told}, magenta is shown as in Cycles: use an image of one file")
            return None
        self._report.warn(f"{told}, tile {first} is shown as in Cycles: use an image of one file")
        return self.index(image, first)

    def _add(self, key: ImageKey, index: int) -> None:
        self._known[key] = index
        self._kept.changes += 1

    def _is_missing(self, image: bpy.types.Image, part: Part) -> bool:
        """True if the image has no pixels. Pixels that its file gives are kept until they are sent: Blender need not read it, too."""
        place = uid(image), part
        if place in self._read_before or place in self._read:
            return False
        if ImageKey(*place) in self._known and image_file.is_there(image, part):
            return False
        read = self._of_file(image, part)
        if read is None and part is None:
            return _has_no_pixels(image)
        read = read or self._of_blender(image, part)
        if read is None:
            return True
        self._read[place] = read
        return False

    def _pixels(self, image: bpy.types.Image, part: Part) -> tuple[np.ndarray, bool]:
        """Pixels (height, width, 4) from below, and whether they are linear; those of a missing image are magenta."""
        if self._is_missing(image, part):
            return MAGENTA.copy(), False
        place = uid(image), part
        read = self._read.pop(place, None) or self._of_file(image, part)
        if read is not None:
            self._read_before.add(place)
        else:
            read = self._of_blender(image, part)
        if read is None:
            return MAGENTA.copy(), False
        return self._limit.smaller(read.sent()), read.is_float

    @staticmethod
    def _of_file(image: bpy.types.Image, part: Part) -> Pixels | None:
        found = image_file.pixels(image, part)
        return None if found is None else Pixels.of_bytes(image, found)

    @staticmethod
    def _of_blender(image: bpy.types.Image, part: Part) -> Pixels | None:
        with image_parts.opened(image, part) as found:
            return None if found is None else Pixels.of_blender(found)

    def _warn_of_missing(self, image: bpy.types.Image, part: Part) -> None:
        where = image_parts.path(image.original, part) or "no file"
        which = ""
        if part is not None:
            which = f", tile {part}," if image.source == "TILED" else f", frame {part},"
        help_ = "save or restore the file" if image.source == "TILED" else "restore the file"
        if image.source == "MOVIE" and not image_parts.READS_MOVIES:
            help_ = "movies need Blender 4.3 or later; an image sequence does not"
        self._report.warn(f"Image '{image.name}'{which} cannot be read ({where}), magenta is shown: {help_}")

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
    """True if a missing image is a pixel with nothing beyond it, as in the Cycles of older versions."""
    return bpy.app.version < _MISSING_IS_EVERYWHERE and node.type == "TEX_IMAGE" and node.extension == "CLIP"


def _has_no_pixels(image: bpy.types.Image) -> bool:
    """True if Blender has no pixels of the image."""
    width, height = image.size
    return width == 0 or height == 0 or image.channels == 0
