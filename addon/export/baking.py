# SPDX-License-Identifier: GPL-3.0-or-later
"""The data that Blender lays out for a bake, as the engine takes them: an object, and the points of its surface that pixels show."""

from __future__ import annotations

from typing import Any, NamedTuple

import bpy
import numpy as np

from petzval.description import BakeDescription

#: Bits of Blender's pass filter, by the names of `BakeDescription`.
FILTER = {
    "emission": 1 << 1,
    "diffuse": 1 << 2,
    "glossy": 1 << 3,
    "transmission": 1 << 4,
    "direct": 1 << 6,
    "indirect": 1 << 7,
    "color": 1 << 8,
}


class Baked(NamedTuple):
    """The object whose surface is baked."""

    holder: bpy.types.Object
    #: The shadows on it are baked.
    catches_shadows: bool = False

    def is_at(self, place: bpy.types.DepsgraphObjectInstance) -> bool:
        """True if an instance of the dependency graph is the object itself, not a copy that another object shows."""
        own = self.holder.original
        if place.object.original != own:
            return False
        return not place.is_instance or (place.parent is not None and place.parent.original == own)


class Points(NamedTuple):
    """The points of one image, pixel by pixel, rows from below."""

    triangles: np.ndarray
    weights: np.ndarray
    differentials: np.ndarray
    seeds: np.ndarray | None


def describe(
    holder: bpy.types.Object, scene: bpy.types.Scene, kind: str, pass_filter: int, *, has_camera: bool
) -> BakeDescription:
    """The description of a bake as Blender asks for it."""
    lights = {name: bool(pass_filter & bit) for name, bit in FILTER.items()}
    from_camera = has_camera and scene.render.bake.view_from == "ACTIVE_CAMERA"
    return BakeDescription(holder.name, kind, from_camera, **lights)


def points(layer: bpy.types.RenderLayer, pixels: int) -> Points:
    """The points in a result that Blender has begun for a bake."""
    primitives = _read(layer, "BakePrimitive", pixels)
    if primitives.shape[1] == 4:
        # In older Blenders: the number for random numbers, the triangle, and two weights.
        triangles, weights = primitives.view(np.int32)[:, 1], primitives[:, 2:]
    else:
        triangles, weights = primitives.view(np.int32)[:, 2], primitives[:, :2]
    seeds = _read(layer, "BakeSeed", pixels).view(np.uint32)[:, 0] if "BakeSeed" in layer.passes else None
    is_there = triangles >= 0
    return Points(
        np.ascontiguousarray(triangles),
        np.ascontiguousarray(np.where(is_there[:, None], weights, 0.0), dtype=np.float32),
        _read(layer, "BakeDifferential", pixels),
        None if seeds is None else np.ascontiguousarray(seeds),
    )


def _read(layer: bpy.types.RenderLayer, name: str, pixels: int) -> np.ndarray:
    """A pass, a row for each pixel."""
    found: Any = layer.passes[name]
    numbers = np.empty(pixels * found.channels, np.float32)
    found.rect.foreach_get(numbers)
    return numbers.reshape(pixels, found.channels)
