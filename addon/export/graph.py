# SPDX-License-Identifier: GPL-3.0-or-later
"""A material's node tree as the engine's description of a shader graph: lists and dicts, ready for JSON.

Groups, reroutes and muted nodes are followed away. Ramps and curves come as tables, evaluated by Blender.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import bpy

from ..native import engine
from . import image_pixels, nodes

#: Gives the engine's index of the image that a texture node shows; None: it shows none.
ImageIndex = Callable[[bpy.types.Node], int | None]

# As many rows as Cycles takes, ends included.
_ROWS = 257
#: Bytes of an IES file; measured luminaires have some ten thousand.
_LONGEST_LUMINAIRE = 4 << 20
# From this version on Blender scatters the points of the Voronoi texture otherwise.
_NEW_CELLS = (5, 0, 0)
#: Ends of the tree, by the description's name for each.
_ENDS = {"surface": "Surface", "volume": "Volume", "displacement": "Displacement"}
#: The coordinates of a texture without a linked vector, if not generated ones.
_COORDINATES = {
    "TEX_IMAGE": ("ShaderNodeTexCoord", "UV"),
    "TEX_ENVIRONMENT": ("ShaderNodeNewGeometry", "Position"),
}
_DIRECTIONS = {"Normal", "Coat Normal", "Tangent"}
_NO_MAPPING = {"Location": [0.0] * 3, "Rotation": [0.0] * 3, "Scale": [1.0] * 3}
_VALUE_TYPES = {"VALUE", "INT", "BOOLEAN", "VECTOR", "RGBA"}
_OPTION_TYPES = {"ENUM", "BOOLEAN", "INT", "FLOAT", "STRING"}


def describe(tree: bpy.types.NodeTree, image_index: ImageIndex) -> dict[str, Any]:
    """The nodes and the ends of the tree's active output. A tree without an output is empty."""
    output = tree.get_output_node("CYCLES")
    walk = _Walk(image_index)
    ends = {}
    for name, socket in _ENDS.items():
        given = output.inputs.get(socket) if output is not None else None
        found = nodes.trace(nodes.Input(given)) if given is not None else None
        ends[name] = walk.link(found) if isinstance(found, nodes.Source) else None
    walk.finish()
    return {"nodes": walk.nodes, **ends}


class Ends:
    """A description whose ends are given one by one."""

    def __init__(self, image_index: ImageIndex) -> None:
        self._walk = _Walk(image_index)

    def input(self, socket: bpy.types.NodeSocket, groups: tuple[bpy.types.Node, ...] = ()) -> Any:
        """The value of an input socket, or its link."""
        return self._walk.given(socket, nodes.trace(nodes.Input(socket, groups)))

    def add(self, described: dict[str, Any], socket: str = "Emission") -> dict[str, Any]:
        """A link to an output of a node that the tree does not have."""
        return self._walk.add(described, socket)

    def finished(self) -> list[dict[str, Any]]:
        """All nodes."""
        self._walk.finish()
        return self._walk.nodes


class _Walk:
    """Gathers nodes from the ends up, each once."""

    def __init__(self, image_index: ImageIndex) -> None:
        self.nodes: list[dict[str, Any]] = []
        self._image_index = image_index
        self._places: dict[tuple[int, ...], int] = {}
        self._waiting: list[tuple[nodes.Source, dict[str, Any]]] = []

    def link(self, source: nodes.Source) -> dict[str, Any]:
        """A link to an output; its node is noted for later."""
        # A node in a group is another one for each place where the group is used.
        key = (source.node.as_pointer(), *(group.as_pointer() for group in source.groups))
        if key not in self._places:
            self._places[key] = len(self.nodes)
            described = {"type": source.node.bl_idname, "name": source.node.name, "options": {}, "inputs": {}}
            self.nodes.append(described)
            self._waiting.append((source, described))
        socket = source.socket.identifier
        if source.node.type == nodes.RAYCAST and socket.startswith("Attribute_"):
            # Blender goes on counting where others were removed.
            shown = [one for one in source.node.outputs if one.identifier.startswith("Attribute_")]
            socket = f"Attribute_{shown.index(source.socket)}"
        return {"node": self._places[key], "socket": socket}

    def given(self, socket: bpy.types.NodeSocket, found: nodes.Source | nodes.Input | None) -> Any:
        """The value of an input socket, or its link; None where the node takes it from the surface."""
        if not isinstance(found, nodes.Source):
            return _constant(socket, found) if socket.type in _VALUE_TYPES else None
        link = self.link(found)
        unlinked = _constant(socket, nodes.Input(socket)) if socket.type in _VALUE_TYPES else None
        return link if unlinked is None else {**link, "unlinked": unlinked}

    def finish(self) -> None:
        """Describes the nodes that were noted, and those that they lead to."""
        while self._waiting:
            source, described = self._waiting.pop()
            described["options"] = _options(source.node, self._image_index)
            for given in source.inputs():
                self._describe_input(given, described)
            if source.node.type == nodes.RAYCAST:
                described["options"] |= _attributes(source.node, described["options"])
            self._map_coordinates(source.node, described)

    def _map_coordinates(self, node: bpy.types.Node, described: dict[str, Any]) -> None:
        """Puts the mapping in a texture node's sidebar before its coordinates, as a node of its own."""
        mapping = getattr(node, "texture_mapping", None)
        if mapping is None or "Vector" not in node.inputs:
            return
        parts = {
            "Location": list(mapping.translation),
            "Rotation": list(mapping.rotation),
            "Scale": list(mapping.scale),
        }
        if parts == _NO_MAPPING:
            return
        given = described["inputs"].get("Vector")
        if given is None:
            kind, socket = _COORDINATES.get(node.type, ("ShaderNodeTexCoord", "Generated"))
            given = self.add({"type": kind, "name": node.name, "options": {}, "inputs": {}}, socket)
        mapper = {
            "type": "ShaderNodeMapping",
            "name": node.name,
            "options": {"vector_type": mapping.vector_type},
            "inputs": {"Vector": given, **parts},
        }
        described["inputs"]["Vector"] = self.add(mapper, "Vector")

    def add(self, described: dict[str, Any], socket: str) -> dict[str, Any]:
        """A link to a node that the tree does not have."""
        self.nodes.append(described)
        return {"node": len(self.nodes) - 1, "socket": socket}

    def _describe_input(self, given: nodes.Input, described: dict[str, Any]) -> None:
        socket = given.socket
        found = nodes.trace(given)
        if socket.type == "STRING":
            if isinstance(found, nodes.Input):
                described["options"][socket.identifier] = found.socket.default_value
            return
        value = self.given(socket, found)
        if value is not None:
            described["inputs"][socket.identifier] = value


def _constant(socket: bpy.types.NodeSocket, found: nodes.Input | None) -> float | list[float] | None:
    """The value of an input; None where the node takes it from the surface."""
    if found is None:
        # Nothing arrives through a dead end: Blender takes zero.
        return 0.0
    # Before 5.0 Blender copies the value of a group's input into the socket itself, whose value such a socket does not take.
    if (found.socket == socket or bpy.app.version < (5, 0, 0)) and _takes_default(socket):
        return None
    if found.socket.hide_value and _is_direction(socket):
        # The group that the node is in shows no value here, so Cycles takes none.
        return None
    value = nodes.value(found.socket)
    return list(value[:3]) if isinstance(value, tuple) else value


def _takes_default(socket: bpy.types.NodeSocket) -> bool:
    """True if an empty input is a normal, a coordinate or the like, rather than the value that it hides."""
    return socket.hide_value and (socket.type == "VECTOR" or socket.identifier == "Random")


def _is_direction(socket: bpy.types.NodeSocket) -> bool:
    """True if an input is a normal or a tangent, which an empty one takes from the surface."""
    return socket.hide_value and socket.type == "VECTOR" and socket.identifier in _DIRECTIONS


@cache
def _option_names(kind: str) -> tuple[str, ...]:
    """The properties of a kind of node that are its own."""
    common = bpy.types.ShaderNode.bl_rna.properties.keys()
    properties = getattr(bpy.types, kind).bl_rna.properties
    return tuple(one.identifier for one in properties if one.identifier not in common and one.type in _OPTION_TYPES)


def _options(node: bpy.types.Node, image_index: ImageIndex) -> dict[str, Any]:
    options = {}
    for name in _option_names(node.bl_idname):
        value = getattr(node, name)
        options[name] = value if isinstance(value, (str, bool, int, float)) else list(value)
    if node.type in {"TEX_IMAGE", "TEX_ENVIRONMENT"}:
        options["image"] = image_index(node)
        options["alpha_is_transparency"] = node.image is not None and image_pixels.is_transparency(node.image)
    elif node.type in {"BSDF_PRINCIPLED", "SUBSURFACE_SCATTERING"}:
        name = "falloff" if node.type == "SUBSURFACE_SCATTERING" else "subsurface_method"
        options[name] = nodes.subsurface_method(node, name)
    elif node.type == "TEX_VORONOI":
        options["cell_hash"] = "PCG" if bpy.app.version >= _NEW_CELLS else "LOOKUP3"
    elif node.type == "TEX_IES":
        options["ies_text"] = _luminaire(node)
    elif node.type in {"VALUE", "RGB", "NORMAL"}:
        value = nodes.value(node.outputs[0])
        options["value"] = list(value[:3]) if isinstance(value, tuple) else value
    elif node.type == "VALTORGB":
        options["table"] = [list(node.color_ramp.evaluate(row / (_ROWS - 1))) for row in range(_ROWS)]
        options["interpolate"] = node.color_ramp.interpolation != "CONSTANT"
    elif node.type in {"CURVE_RGB", "CURVE_VEC", "CURVE_FLOAT"}:
        options |= _curves(node.mapping)
    elif node.type == "TEX_COORD" and node.object is not None:
        options["object_matrix"] = [list(row) for row in node.object.matrix_world.inverted_safe()]
    return options


def _attributes(node: bpy.types.Node, names: dict[str, Any]) -> dict[str, Any]:
    """The attributes that a Raycast node asks of a hit surface: their names and the kinds of their outputs, by their places in its list."""
    asked = [names.get(one.identifier, "") for one in node.inputs if one.type == "STRING"]
    kinds = [one.type for one in node.outputs if one.identifier.startswith("Attribute_")]
    found = {f"attribute_{place}": name for place, name in enumerate(asked)}
    return found | {f"attribute_{place}_kind": kind for place, kind in enumerate(kinds)}


def _luminaire(node: bpy.types.Node) -> str | None:
    """The text of an IES file; None where there is none."""
    if node.mode == "INTERNAL":
        return None if node.ies is None else node.ies.as_string()
    library = node.id_data.library
    path = bpy.path.abspath(node.filepath, library=library) if node.filepath else None
    try:
        return engine().read_bounded(path, _LONGEST_LUMINAIRE).decode("latin-1") if path is not None else None
    except OSError:
        return None


def _curves(mapping: bpy.types.CurveMapping) -> dict[str, Any]:
    """The curves of x, y and z, after the one for all where there is one; over the range that they cover together."""
    mapping.update()
    curves = list(mapping.curves)
    low = min(curve.points[0].location.x for curve in curves)
    high = max(curve.points[-1].location.x for curve in curves)
    parts = curves[:3] if len(curves) >= 3 else curves[:1] * 3
    table = []
    for row in range(_ROWS):
        place = low + (high - low) * row / (_ROWS - 1)
        if len(curves) == 4:
            place = mapping.evaluate(curves[3], place)
        table.append([*(mapping.evaluate(curve, place) for curve in parts), 1.0])
    return {"table": table, "range": [low, high], "extrapolate": mapping.extend == "EXTRAPOLATED"}
