# SPDX-License-Identifier: GPL-3.0-or-later
"""The data that shader graphs ask of a mesh beyond its UV maps: named attributes, colours, coordinates in its box, and the
attributes of its edges."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import bpy
import numpy as np

from ..native import engine

#: The engine's name for the coordinates of the undeformed mesh in its texture space.
GENERATED = ".generated"
#: The engine's name for the normals of curves, which orient elliptical hair.
CURVE_NORMAL = ".curve_normal"
#: Texture nodes that do not ask for those where nothing is linked to their vector.
_WITHOUT_GENERATED = {"ShaderNodeTexImage", "ShaderNodeTexEnvironment", "ShaderNodeTexCoord"}
#: The inputs of a shader node for stretched facets, which lie about a generated tangent where none is linked.
STRETCH = ("Anisotropic", "Anisotropy")
#: The engine's names for attributes of edges, by the output of a Geometry node that shows it.
_OF_EDGES = {"Pointiness": ".pointiness", "Random Per Island": ".random_per_island"}

#: The name of an attribute's values, and the count of numbers of each, by Blender's type.
KINDS = {
    "FLOAT": ("value", 1),
    "INT": ("value", 1),
    "INT8": ("value", 1),
    "BOOLEAN": ("value", 1),
    "FLOAT_VECTOR": ("vector", 3),
    "FLOAT2": ("vector", 2),
    "FLOAT_COLOR": ("color", 4),
    "BYTE_COLOR": ("color", 4),
}


def wanted(graph: dict[str, Any]) -> frozenset[str]:
    """The names of the attributes that a graph's nodes ask for; an empty one is the colour attribute for rendering."""
    of_geometry = {"Tangent": GENERATED, **_OF_EDGES}
    shown = _shown(graph, "ShaderNodeNewGeometry")
    names = {name for socket, name in of_geometry.items() if socket in shown}
    for node in graph["nodes"]:
        kind, options = node["type"], node["options"]
        if kind == "ShaderNodeAttribute" and options.get("attribute_type") == "GEOMETRY":
            names.add(options["attribute_name"])
        elif kind == "ShaderNodeVertexColor":
            names.add(options["layer_name"])
        elif kind == "ShaderNodeRaycast":
            names |= of_raycast(options)
        elif _is_elliptical(kind, node):
            names.add(CURVE_NORMAL)
        elif _takes_generated(kind, node["inputs"]):
            names.add(GENERATED)
    if "Generated" in _shown(graph, "ShaderNodeTexCoord"):
        names.add(GENERATED)
    return frozenset(names)


def of_raycast(options: dict[str, Any]) -> set[str]:
    """The names of the attributes that a Raycast node asks of a hit surface."""
    return {name for key, name in options.items() if key.startswith("attribute_") and not key.endswith("_kind")}


def _is_elliptical(kind: str, node: dict[str, Any]) -> bool:
    """True of hair whose cross-section is no circle."""
    is_huang = kind == "ShaderNodeBsdfHairPrincipled" and node["options"].get("model") == "HUANG"
    return is_huang and node["inputs"].get("Aspect Ratio", 1.0) != 1.0


def _takes_generated(kind: str, inputs: dict[str, Any]) -> bool:
    """True if a node takes generated coordinates by itself: for a texture without a linked vector, or for a tangent."""
    if kind == "ShaderNodeTangent" or any(inputs.get(name, 0.0) != 0.0 for name in STRETCH):
        return True
    return kind.startswith("ShaderNodeTex") and kind not in _WITHOUT_GENERATED and "Vector" not in inputs


def _shown(graph: dict[str, Any], kind: str) -> set[str]:
    """The outputs of nodes of a kind that others are linked to."""
    given = [value for node in graph["nodes"] for value in node["inputs"].values() if isinstance(value, dict)]
    return {link["socket"] for link in given if graph["nodes"][link["node"]]["type"] == kind}


def read(mesh: bpy.types.Mesh, names: Iterable[str], triangles: int) -> dict[str, tuple[str, np.ndarray]]:
    """The attributes by name: their domain, and four numbers each, as `mesh.Values`. `triangles` is the mesh's number of triangles."""
    found = {name: _values(mesh, name, triangles) for name in sorted(names)}
    return {name: values for name, values in found.items() if values is not None}


def _values(mesh: bpy.types.Mesh, name: str, triangles: int) -> tuple[str, np.ndarray] | None:
    if name == GENERATED:
        return "POINT", _in_box(mesh)
    if name in _OF_EDGES.values():
        return "POINT", _of_edges(mesh, name)
    attribute = mesh.attributes.get(name) if name else _colour_for_rendering(mesh)
    if attribute is None or attribute.data_type not in KINDS:
        return None
    if attribute.domain in ("POINT", "CORNER"):
        return attribute.domain, four(attribute)
    if attribute.domain == "FACE":
        faces = np.empty(triangles, np.int32)
        mesh.loop_triangles.foreach_get("polygon_index", faces)
        return "TRIANGLE", four(attribute).take(faces, 0)
    return None


def _colour_for_rendering(mesh: bpy.types.Mesh) -> bpy.types.Attribute | None:
    index = mesh.color_attributes.render_color_index
    return mesh.color_attributes[index] if 0 <= index < len(mesh.color_attributes) else None


def four(attribute: bpy.types.Attribute) -> np.ndarray:
    """Four numbers a value: a single number stands in the first three, missing ones are 0, and alpha is 1."""
    name, count = KINDS[attribute.data_type]
    kind = {"INT": np.int32, "INT8": np.int8, "BOOLEAN": bool}.get(attribute.data_type, np.float32)
    raw = np.empty(len(attribute.data) * count, kind)
    attribute.data.foreach_get(name, raw)
    raw = raw.reshape(-1, count)
    values = np.zeros((len(raw), 4), np.float32)
    values[:, 3] = 1.0
    values[:, : 3 if count == 1 else count] = raw
    return values


def _of_edges(mesh: bpy.types.Mesh, name: str) -> np.ndarray:
    """The numbers of an attribute of edges, by vertex."""
    edges = np.empty((len(mesh.edges), 2), np.int32)
    mesh.edges.foreach_get("vertices", edges.reshape(-1))
    if name == _OF_EDGES["Random Per Island"]:
        numbers = engine().random_per_island(len(mesh.vertices), edges)
    else:
        places = np.empty((2, len(mesh.vertices), 3), np.float32)
        mesh.vertices.foreach_get("co", places[0].reshape(-1))
        mesh.vertex_normals.foreach_get("vector", places[1].reshape(-1))
        numbers = engine().pointiness(*places, edges)
    return np.repeat(numbers[:, None], 4, 1)


def _in_box(mesh: bpy.types.Mesh) -> np.ndarray:
    """Generated coordinates by vertex, as in Cycles: 0 to 1 over the texture space, before modifiers moved anything."""
    places = np.empty((len(mesh.vertices), 3), np.float32)
    mesh.vertices.foreach_get("undeformed_co", places.reshape(-1))
    return in_box(mesh, places)


def in_box(mesh: bpy.types.Mesh, places: np.ndarray) -> np.ndarray:
    """Places of object space in a mesh's texture space, (places, 4)."""
    size = np.array(mesh.texspace_size, np.float32)
    scale = np.divide(0.5, size, out=np.zeros_like(size), where=size != 0.0)
    values = np.zeros((len(places), 4), np.float32)
    values[:, :3] = (places - np.array(mesh.texspace_location, np.float32)) * scale + np.float32(0.5)
    return values
