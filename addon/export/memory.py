# SPDX-License-Identifier: GPL-3.0-or-later
"""The check that a picture and its meshes fit into memory, before any of it is made. An engine that runs out of memory takes
Blender with it."""

from __future__ import annotations

from ..native import engine
from .errors import ExportError

#: Memory of a triangle at most, with normals and one UV map, Blender's evaluated copy included; docs/design/meshes.md.
BYTES_A_TRIANGLE = 250
#: Memory that each triangle that was handed over still takes when the trees over them are built.
BYTES_OF_TREES = 100
#: The number of triangles below which memory is not checked.
MANY_TRIANGLES = 100_000


#: A number of a pass is in the engine's answer, in Blender's own picture, and in the one that Blender takes it from.
BYTES_A_NUMBER = 3 * 4


#: Copies of a picture and its guides while it is denoised, a pixel.
BYTES_OF_DENOISING = 140


def check_picture(limit_gb: float, width: int, height: int, film_bytes_a_pixel: int, numbers_a_pixel: int) -> None:
    """Raises `ExportError` where a picture of so many numbers a pixel in all passes does not fit."""
    need = width * height * (film_bytes_a_pixel + numbers_a_pixel * BYTES_A_NUMBER)
    free = engine().free_memory_bytes()
    if limit_gb and need > limit_gb * 1e9:
        room, left = "the limit under Performance > Memory Limit is", limit_gb * 1e9
    elif free is not None and need > free:
        room, left = "free are", free
    else:
        return
    raise ExportError(
        f"A picture of {width} x {height} pixels needs about {need / 1e9:.2g} GB of memory, {room} {left / 1e9:.2g} GB: "
        "make it smaller, or ask for fewer passes"
    )


class Room:
    """Memory for the meshes of one scene; `limit_gb` is the user's, 0 for the machine's free memory."""

    def __init__(self, limit_gb: float) -> None:
        self._limit_bytes = limit_gb * 1e9
        self._triangles = 0

    def left_triangles(self) -> int:
        """The number of triangles that there is still room for."""
        taken, free = self._triangles * BYTES_A_TRIANGLE, engine().free_memory_bytes()
        left = min(
            self._limit_bytes - taken if self._limit_bytes else float("inf"),
            free - self._triangles * BYTES_OF_TREES if free is not None else float("inf"),
        )
        return min(max(int(left / BYTES_A_TRIANGLE), 0), 2**32 - 1) if left < float("inf") else 2**32 - 1

    def take(self, name: str, triangles: int) -> None:
        """Counts a mesh of an object. Raises `ExportError` where it does not fit."""
        before = self._triangles
        self._triangles += triangles
        if triangles < MANY_TRIANGLES:
            return
        whole = self._triangles * BYTES_A_TRIANGLE
        # What came before is there already, but for its trees.
        more = triangles * BYTES_A_TRIANGLE + before * BYTES_OF_TREES
        free = engine().free_memory_bytes()
        if self._limit_bytes and whole > self._limit_bytes:
            need, room, left = whole, "the limit under Performance > Memory Limit is", self._limit_bytes
        elif free is not None and more > free:
            need, room, left = more, "free are", free
        else:
            return
        raise ExportError(
            f"Object '{name}': with its {triangles:,} triangles the scene needs about {need / 1e9:.2g} GB of memory, {room} "
            f"{left / 1e9:.2g} GB: divide it less often, or make copies instances of one mesh"
        )
