# SPDX-License-Identifier: GPL-3.0-or-later
"""An evaluated mesh as the engine's arrays. Whole arrays are copied; nothing runs once a vertex in Python."""

from __future__ import annotations

from dataclasses import dataclass, field

import bpy
import numpy as np

# What Blender itself allows.
MOST_UV_MAPS = 8


@dataclass
class MeshArrays:
    """What `SceneBuilder.add_mesh` takes."""

    positions: np.ndarray
    triangles: np.ndarray
    corner_normals: np.ndarray | None = None
    uv_maps: dict[str, np.ndarray] = field(default_factory=dict)
    material_slots: np.ndarray | None = None


def extract(mesh: bpy.types.Mesh) -> MeshArrays | None:
    """The arrays of a mesh in object space; None where it has no triangles."""
    mesh.calc_loop_triangles()
    count = len(mesh.loop_triangles)
    if count == 0:
        return None
    corners = _read(mesh.loop_triangles, "loops", (count, 3), np.int32)
    vertex_of_corner = _read(mesh.loops, "vertex_index", (len(mesh.loops),), np.int32)
    triangles = vertex_of_corner[corners]
    return MeshArrays(
        positions=_read(mesh.vertices, "co", (len(mesh.vertices), 3), np.float32),
        triangles=triangles,
        corner_normals=_normals(mesh, corners, triangles),
        uv_maps=_uv_maps(mesh, corners),
        material_slots=_slots(mesh, count),
    )


def _read(collection: bpy.types.bpy_prop_collection, name: str, shape: tuple[int, ...], kind: type) -> np.ndarray:
    array = np.empty(shape, kind)
    collection.foreach_get(name, array.reshape(-1))
    return array


def _normals(mesh: bpy.types.Mesh, corners: np.ndarray, triangles: np.ndarray) -> np.ndarray | None:
    """Normals by corner; None where all faces are flat."""
    if mesh.normals_domain == "FACE":
        return None
    if mesh.normals_domain == "POINT":
        return _read(mesh.vertex_normals, "vector", (len(mesh.vertices), 3), np.float32)[triangles]
    return _read(mesh.corner_normals, "vector", (len(mesh.loops), 3), np.float32)[corners]


def _uv_maps(mesh: bpy.types.Mesh, corners: np.ndarray) -> dict[str, np.ndarray]:
    """UV maps by name, the one that is rendered by default first."""
    layers = sorted(mesh.uv_layers, key=lambda layer: not layer.active_render)[:MOST_UV_MAPS]
    return {layer.name: _read(layer.uv, "vector", (len(mesh.loops), 2), np.float32)[corners] for layer in layers}


def _slots(mesh: bpy.types.Mesh, count: int) -> np.ndarray | None:
    """The material slot of each triangle; None where all have the first."""
    if mesh.attributes.get("material_index") is None:
        return None
    slots = _read(mesh.polygons, "material_index", (len(mesh.polygons),), np.int32)
    if not slots.any():
        return None
    return slots[_read(mesh.loop_triangles, "polygon_index", (count,), np.int32)]
