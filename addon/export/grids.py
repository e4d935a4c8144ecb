# SPDX-License-Identifier: GPL-3.0-or-later
"""Values at the voxels of volume objects and smoke: Blender's OpenVDB grids and arrays."""

from __future__ import annotations

import importlib.util
import sys
import tempfile
from dataclasses import dataclass, field
from functools import cache
from importlib.machinery import PathFinder
from pathlib import Path
from types import ModuleType
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix, Vector

from .camera import rows
from .report import Report

#: A grid's name; its values by z, y, x and channel; and the matrix from its voxels to the object's space.
Grid = tuple[str, np.ndarray, tuple[tuple[float, ...], ...]]

#: Voxels of a box that are handed over: two gigabytes.
_MOST_VOXELS = 2**29
#: The middle of the voxel at the origin, in voxels, in Cycles: before 5.0 half of one farther.
_MIDDLE = 0.5 if bpy.app.version < (5, 0, 0) else 0.0
#: The grids of a smoke domain, by the names that shaders ask for, with the number of channels of each.
_OF_SMOKE = {"density": 1, "color": 4, "flame": 1, "heat": 1, "temperature": 1}


@dataclass
class Box:
    """A volume object's box and grids."""

    #: Corners of the box in the object's space.
    corners: list[Vector]
    keeps_opacity: bool
    grids: list[Grid] = field(default_factory=list)

    def shape(self) -> tuple[np.ndarray, np.ndarray]:
        """The box as a mesh whose front is outside."""
        positions = np.array([corner[:] for corner in self.corners], np.float32)
        quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
        triangles = np.array([part for a, b, c, d in quads for part in ([a, b, c], [a, c, d])], np.int32)
        sides = positions[[1, 2, 4]] - positions[0]
        if np.linalg.det(sides) < 0.0:
            triangles = triangles[:, ::-1].copy()
        return positions, triangles


@cache
def _openvdb() -> ModuleType | None:
    """Blender's own module; the one in bpy lies beside the paths that are searched."""
    try:
        import openvdb
    except ImportError:
        version = f"python{sys.version_info.major}.{sys.version_info.minor}"
        folder = Path(bpy.utils.resource_path("LOCAL")) / "python" / "lib" / version / "site-packages"
        spec = PathFinder.find_spec("openvdb", [str(folder)])
        if spec is None or spec.loader is None:
            return None
        openvdb = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(openvdb)
    return openvdb


def of_volume(holder: bpy.types.Object, report: Report) -> Box | None:
    """The grids of a volume object; None where there is nothing to see, which is said."""
    owner = f"Object '{holder.name}'"
    volume = holder.data
    if not volume.grids.load():
        why = volume.grids.error_message or "it cannot be read"
        report.warn(f"{owner}: its volume file is left out: {why}")
        return None
    vdb = _openvdb()
    if vdb is None:
        report.warn(f"{owner}: this Blender has no module 'openvdb' to read volumes with, left out")
        return None
    found = _read(vdb, holder, owner, report)
    grids, low, high, frame = [], None, None, None
    for grid in volume.grids:
        given = found.get(grid.name)
        if given is None or given.activeVoxelCount() == 0:
            continue
        first, last = (np.array(end) for end in given.evalActiveVoxelBoundingBox())
        values = _values(given, first, last - first + 1, f"{owner}: grid '{grid.name}'", report)
        if values is None:
            continue
        matrix = grid.matrix_object.copy()
        grids.append((grid.name, values, rows(matrix @ Matrix.Translation(Vector((first + _MIDDLE).tolist())))))
        if frame is None:
            frame, low, high = matrix, first, last
        elif all(
            abs(a - b) < 1e-6 for one, other in zip(matrix, frame, strict=True) for a, b in zip(one, other, strict=True)
        ):
            low, high = np.minimum(low, first), np.maximum(high, last)
    if frame is None:
        return None
    # Between the last voxel and the next, values fade.
    ends = [(low - 1 + _MIDDLE).tolist(), (high + 1 + _MIDDLE).tolist()]
    corners = [frame @ Vector([ends[i >> axis & 1][axis] for axis in range(3)]) for i in range(8)]
    return Box(corners, volume.render.space == "OBJECT", grids)


def _read(vdb: ModuleType, holder: bpy.types.Object, owner: str, report: Report) -> dict[str, Any]:
    """The grids by name."""
    grids = holder.data.grids
    try:
        if not holder.modifiers and grids.frame_filepath and Path(grids.frame_filepath).is_file():
            return {grid.name: grid for grid in vdb.readAll(grids.frame_filepath)[0]}
        # Made by modifiers: Blender writes them.
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "made.vdb"
            if not grids.save(str(path)):
                raise OSError("it cannot be written")
            return {grid.name: grid for grid in vdb.readAll(str(path))[0]}
    except (OSError, RuntimeError, KeyError, TypeError) as error:
        report.warn(f"{owner}: its volume is left out: {error}")
        return {}


def _values(grid: Any, first: np.ndarray, size: np.ndarray, owner: str, report: Report) -> np.ndarray | None:
    """The values of a grid by z, y, x and channel."""
    channels = {"float": 1, "double": 1, "half": 1, "int32": 1, "int64": 1, "bool": 1, "vec3s": 3, "vec3d": 3}
    count = channels.get(grid.valueTypeName)
    if count is None:
        report.warn(f"{owner}: values of the type {grid.valueTypeName} are not supported, left out")
        return None
    if int(np.prod(size.astype(np.int64))) * count > _MOST_VOXELS:
        report.warn(f"{owner}: {size[0]} x {size[1]} x {size[2]} voxels are too many, left out")
        return None
    values = np.zeros((*size, 3) if count == 3 else tuple(size), np.float32)
    grid.copyToArray(values, ijk=tuple(int(part) for part in first))
    if grid.gridClass == "level set":
        report.warn(f"{owner}: level sets are not supported, left out")
        return None
    return np.ascontiguousarray(values.reshape(*size, count).transpose(2, 1, 0, 3))


def of_smoke(holder: bpy.types.Object, report: Report) -> list[Grid]:
    """The grids of a gas domain; empty for other meshes."""
    for modifier in holder.modifiers:
        if modifier.type == "FLUID" and modifier.show_render and modifier.fluid_type == "DOMAIN":
            domain = modifier.domain_settings
            if domain is not None and domain.domain_type == "GAS":
                return _smoke(holder, domain, report)
    return []


def _smoke(holder: bpy.types.Object, domain: bpy.types.FluidDomainSettings, report: Report) -> list[Grid]:
    size = np.array(domain.domain_resolution[:])
    voxels = int(np.prod(size))
    density = np.array(domain.density_grid, np.float32)
    if voxels == 0 or density.size == 0:
        report.warn(f"Object '{holder.name}': its smoke is not baked, it is left out")
        return []
    # Noise makes voxels finer, by the same along each side.
    finer = round((density.size / voxels) ** (1 / 3))
    size = size * max(finer, 1)
    low, high = Vector(holder.bound_box[0]), Vector(holder.bound_box[6])
    scale = Matrix.Diagonal((*((high[axis] - low[axis]) / size[axis] for axis in range(3)), 1.0))
    matrix = rows(Matrix.Translation(low) @ scale @ Matrix.Translation((0.5, 0.5, 0.5)))
    found = []
    for name, channels in _OF_SMOKE.items():
        values = density if name == "density" else np.array(getattr(domain, f"{name}_grid"), np.float32)
        if values.size == int(np.prod(size)) * channels:
            found.append((name, values.reshape(size[2], size[1], size[0], channels), matrix))
    return found
