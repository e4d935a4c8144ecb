# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes as arrays: positions, triangles, normals at the corners, UV maps, material slots."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np

# As many as Blender itself shows by default.
_MOST_UV_MAPS = 8


@dataclass
class MeshArrays:
    """What the engine's `add_mesh` takes."""

    positions: np.ndarray  # (vertices, 3) float32
    triangles: np.ndarray  # (triangles, 3) int32
    corner_normals: np.ndarray | None  # (triangles, 3, 3) float32; None is flat
    uv_maps: dict[str, np.ndarray]  # (triangles, 3, 2) float32, the map used for rendering first
    material_slots: np.ndarray | None  # (triangles,) int32; None is slot 0


def arrays(mesh: bpy.types.Mesh) -> MeshArrays | None:
    """The mesh's triangles; None where it has none."""
    mesh.calc_loop_triangles()
    count = len(mesh.loop_triangles)
    if count == 0:
        return None
    positions = _read(mesh.attributes["position"].data, "vector", len(mesh.vertices) * 3, np.float32)
    triangles = _read(mesh.loop_triangles, "vertices", count * 3, np.int32)
    corners = _read(mesh.loop_triangles, "loops", count * 3, np.int32)
    return MeshArrays(
        positions.reshape(-1, 3),
        triangles.reshape(-1, 3),
        _normals(mesh, corners),
        _uv_maps(mesh, corners),
        _slots(mesh, count),
    )


def _normals(mesh: bpy.types.Mesh, corners: np.ndarray) -> np.ndarray | None:
    if mesh.normals_domain == "FACE":
        return None
    normals = _read(mesh.corner_normals, "vector", len(mesh.loops) * 3, np.float32).reshape(-1, 3)
    return normals[corners].reshape(-1, 3, 3)


def _uv_maps(mesh: bpy.types.Mesh, corners: np.ndarray) -> dict[str, np.ndarray]:
    layers = sorted(mesh.uv_layers, key=lambda layer: not layer.active_render)[:_MOST_UV_MAPS]
    return {
        layer.name: _read(layer.uv, "vector", len(mesh.loops) * 2, np.float32).reshape(-1, 2)[corners].reshape(-1, 3, 2)
        for layer in layers
    }


def _slots(mesh: bpy.types.Mesh, count: int) -> np.ndarray | None:
    index = mesh.attributes.get("material_index")
    if index is None:
        return None
    by_face = _read(index.data, "value", len(mesh.polygons), np.int32)
    face = _read(mesh.loop_triangles, "polygon_index", count, np.int32)
    return by_face[face]


def _read(collection, name: str, length: int, dtype) -> np.ndarray:
    out = np.empty(length, dtype)
    collection.foreach_get(name, out)
    return out
