# SPDX-License-Identifier: GPL-3.0-or-later
"""An evaluated mesh as the engine's arrays. Whole arrays are copied; nothing runs once a vertex in Python."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import bpy
import numpy as np

from . import attributes

# What Blender itself allows.
MOST_UV_MAPS = 8


#: The domain of values ("POINT", "CORNER", "TRIANGLE"), and these, one a row.
Values = tuple[str, np.ndarray]


@dataclass
class MeshArrays:
    """The arguments of `SceneBuilder.add_mesh`: values as the mesh keeps them, and which of them each triangle has."""

    positions: np.ndarray
    triangles: np.ndarray
    #: By triangle, the corners of the faces that its corners are.
    loops: np.ndarray
    corner_normals: Values | None = None
    uv_maps: dict[str, Values] = field(default_factory=dict)
    material_slots: np.ndarray | None = None
    attributes: dict[str, Values] = field(default_factory=dict)

    @property
    def loops_if_asked(self) -> np.ndarray | None:
        """The loops of the triangles; None where nothing is kept by corners."""
        normals = [self.corner_normals] if self.corner_normals else []
        found = any(domain == "CORNER" for domain, _ in (*normals, *self.uv_maps.values(), *self.attributes.values()))
        return self.loops if found else None

    def fits(self, normals: Values | None) -> bool:
        """True if normals are of this mesh."""
        if normals is None:
            return False
        domain, values = normals
        if domain == "POINT":
            return len(values) == len(self.positions)
        # Corners of edges without faces are none of a triangle's.
        return len(values) > self.loops.max(initial=-1)


@contextmanager
def shape(holder: bpy.types.Object, data: bpy.types.Mesh) -> Iterator[bpy.types.Mesh]:
    """An object's mesh; of one in edit mode its current state: its data are empty until then."""
    if not data.is_editmode:
        yield data
        return
    made = holder.to_mesh()
    try:
        yield made
    finally:
        holder.to_mesh_clear()


def triangle_count(mesh: bpy.types.Mesh) -> int:
    """The number of triangles that the mesh's faces are made of."""
    return max(len(mesh.loops) - 2 * len(mesh.polygons), 0)


def extract(
    mesh: bpy.types.Mesh, wanted: Iterable[str] = (), check_stop: Callable[[], None] = lambda: None
) -> MeshArrays | None:
    """The arrays of a mesh in object space, and the attributes of these names; None where it has no triangles. `check_stop` is called
    between the arrays, which of a large mesh take a while each, and may raise."""
    mesh.calc_loop_triangles()
    count = len(mesh.loop_triangles)
    if count == 0:
        return None
    check_stop()
    loops = _read(mesh.loop_triangles, "loops", (count, 3), np.int32)
    triangles = _attribute(mesh, ".corner_vert", "value", (len(mesh.loops),), np.int32).take(loops)
    check_stop()
    corner_normals = normals(mesh)
    check_stop()
    uv_maps = _uv_maps(mesh)
    check_stop()
    return MeshArrays(
        positions=positions(mesh),
        triangles=triangles,
        loops=loops,
        corner_normals=corner_normals,
        uv_maps=uv_maps,
        material_slots=_slots(mesh, count),
        attributes=attributes.read(mesh, wanted, count),
    )


def positions(mesh: bpy.types.Mesh) -> np.ndarray:
    """The vertices, (vertices, 3), object space."""
    return _attribute(mesh, "position", "vector", (len(mesh.vertices), 3), np.float32)


def _read(collection: bpy.types.bpy_prop_collection, name: str, shape: tuple[int, ...], kind: type) -> np.ndarray:
    array = np.empty(shape, kind)
    collection.foreach_get(name, array.reshape(-1))
    return array


def _attribute(mesh: bpy.types.Mesh, name: str, value: str, shape: tuple[int, ...], kind: type) -> np.ndarray:
    """An attribute that every mesh has: the same as `vertices` or `loops` give, a hundred times as fast."""
    return _read(mesh.attributes[name].data, value, shape, kind)


def normals(mesh: bpy.types.Mesh) -> Values | None:
    """The normals by vertex, or by corner where these differ; None where all faces are flat."""
    if mesh.normals_domain == "FACE":
        return None
    if mesh.normals_domain == "POINT":
        return "POINT", _read(mesh.vertex_normals, "vector", (len(mesh.vertices), 3), np.float32)
    return "CORNER", _read(mesh.corner_normals, "vector", (len(mesh.loops), 3), np.float32)


def _uv_maps(mesh: bpy.types.Mesh) -> dict[str, Values]:
    """UV maps by name, the one that is rendered by default first."""
    layers = sorted(mesh.uv_layers, key=lambda layer: not layer.active_render)[:MOST_UV_MAPS]
    return {layer.name: ("CORNER", _read(layer.uv, "vector", (len(mesh.loops), 2), np.float32)) for layer in layers}


def _slots(mesh: bpy.types.Mesh, count: int) -> np.ndarray | None:
    """The material slot of each triangle; None where all have the first."""
    if mesh.attributes.get("material_index") is None:
        return None
    slots = _attribute(mesh, "material_index", "value", (len(mesh.polygons),), np.int32)
    if not slots.any():
        return None
    if len(slots) == count:
        return slots
    return slots.take(_read(mesh.loop_triangles, "polygon_index", (count,), np.int32))
