# SPDX-License-Identifier: GPL-3.0-or-later
"""Depth, normals and flow from the passes of a render. Arrays have their first row at the top; the pose is a camera's, Blender's axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .poses import FLIP, Matrix

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

#: Blender's depth of pixels without a hit.
FAR = 1e10
#: Depths from here on are that.
_BEYOND = 1e9
#: Shorter ways count as none, pixels.
_STILL_PX = 1e-3


@dataclass(frozen=True)
class Passes:
    """The passes of one picture, first row at the top."""

    depth: Array  # (height, width), Blender units
    position: Array  # (height, width, 3), Blender units, world space
    normal: Array  # (height, width, 3), world space
    index: Array  # (height, width)
    vector: Array | None  # (height, width, 4), as Blender has it

    @property
    def hits(self) -> Mask:
        """The pixels with a hit."""
        return self.depth < _BEYOND

    @property
    def is_full(self) -> bool:
        """True if nothing is left to find: all pixels have a hit, and flow."""
        return bool(self.hits.all()) and (self.vector is None or bool(self.vector.any(axis=-1).all()))

    def fill(self, more: Passes) -> bool:
        """Takes pixels without a hit, and vectors of pixels without one, from another render of the same; whether there were any."""
        new = more.hits & ~self.hits
        for name in ("depth", "position", "normal", "index"):
            getattr(self, name)[new] = getattr(more, name)[new]
        if self.vector is None or more.vector is None:
            return bool(new.any())
        lost = more.vector.any(axis=-1) & ~self.vector.any(axis=-1) & more.hits
        self.vector[new | lost] = more.vector[new | lost]
        return bool((new | lost).any())


def in_camera(points: Array, pose: Matrix) -> Array:
    """World points in camera space as computer vision has it: x right, y down, z forward."""
    moved: Array = (points - pose[:3, 3]) @ (pose[:3, :3] @ FLIP[:3, :3])
    return moved


def depth_m(passes: Passes, pose: Matrix, along: str, metres_per_unit: float) -> Array:
    """Distances from the camera's place, metres: along its axis, or along the ray; 1e10 where there is nothing."""
    seen = in_camera(passes.position, pose)
    distance = seen[..., 2] if along == "axis" else np.linalg.norm(seen, axis=-1)
    return np.where(passes.hits, distance * metres_per_unit, FAR)


def depth_levels(depth: Array, scale: float) -> npt.NDArray[np.uint16]:
    """Depths in metres as 16-bit numbers, `scale` to a metre; 0 where there is nothing, and beyond the range of 16 bits."""
    levels = np.rint(depth * scale)
    return np.where((levels >= 1) & (levels <= 65535), levels, 0).astype(np.uint16)


def normals(passes: Passes, pose: Matrix, frame: str) -> Array:
    """Unit normals towards the camera, in world space or in camera space (x right, y down, z forward); 0 where there is nothing."""
    turned = passes.normal if frame == "world" else passes.normal @ (pose[:3, :3] @ FLIP[:3, :3])
    length = np.linalg.norm(turned, axis=-1, keepdims=True)
    return np.where(passes.hits[..., None] & (length > 1e-6), turned / np.maximum(length, 1e-6), 0.0)


def normal_levels(values: Array, hits: Mask) -> npt.NDArray[np.uint16]:
    """Normals as 16-bit numbers: 0.5 + 0.5 n of 65535; 0 where there is nothing."""
    return np.where(hits[..., None], np.rint((0.5 + 0.5 * values) * 65535.0), 0).astype(np.uint16)


def flow(vector: Array, direction: str) -> Array:
    """Pixels, right and down (height, width, 2), from a surface's place to its place in the picture before or after. Blender's pass counts
    up, and its Z and W lead from there to here."""
    x, y, z, w = np.moveaxis(vector, -1, 0)
    return np.stack([x, -y] if direction == "backward" else [-z, w], axis=-1)


def known_flow(values: Array, hits: Mask) -> Mask:
    """The pixels whose flow is known. A ray that a lens loses on its way from the neighbouring picture leaves exactly 0: so do surfaces
    that stands still, but that is seldom a pixel most of whose neighbours move."""
    moves = hits & (np.linalg.norm(values, axis=-1) > _STILL_PX)
    known: Mask = ~(hits & (values == 0.0).all(axis=-1) & (_neighbours(moves) > 0.7 * _neighbours(hits)))
    return known


def _neighbours(of: Mask) -> npt.NDArray[np.int_]:
    """The number of each pixel's eight neighbours that are in the mask."""
    padded, (height, width) = np.pad(of, 1).astype(int), of.shape
    around = sum(padded[y : y + height, x : x + width] for y in range(3) for x in range(3)) - of
    return np.asarray(around)


def kitti_flow(values: Array, known: Mask) -> tuple[npt.NDArray[np.uint16], bool]:
    """KITTI's encoding (stereo/flow devkit, readme): 64 f + 2^15, and 1 where it is known; also whether some flow did not fit."""
    levels = np.rint(values * 64.0 + 32768.0)
    fits = ((levels >= 0) & (levels <= 65535)).all(axis=-1)
    valid = known & fits
    encoded = np.where(valid[..., None], levels, 0.0)
    return np.concatenate([encoded, valid[..., None]], axis=-1).astype(np.uint16), bool((known & ~fits).any())
