# SPDX-License-Identifier: GPL-3.0-or-later
"""Follows links through a node tree.

Reroutes, muted nodes and groups are passed through. An input is either a value that stands still, or the output of
a node that the caller must understand.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy

# From this version on what is linked to nothing but a reroute or a muted node keeps its own value; before, it got zero.
_KEEPS_VALUES = (5, 0, 0)
#: The type of the node Raycast, of Blender 5.1 and later.
RAYCAST = "MATERIAL_RAYCAST"
# Deeper than any sane tree; a group that holds itself cannot be made in Blender.
_DEEPEST = 1000


@dataclass(frozen=True)
class Input:
    """A node's input socket, with the group nodes that lead to it, outermost first."""

    socket: bpy.types.NodeSocket
    groups: tuple[bpy.types.Node, ...] = ()


@dataclass(frozen=True)
class Source:
    """The output socket of a node that feeds an input, with the group nodes that lead to it."""

    node: bpy.types.Node
    socket: bpy.types.NodeSocket
    groups: tuple[bpy.types.Node, ...] = ()

    def input(self, name: str) -> Input:
        """An input of the node by name."""
        return Input(self.node.inputs[name], self.groups)

    def inputs(self) -> list[Input]:
        """All inputs of the node that are in use."""
        return [Input(socket, self.groups) for socket in self.node.inputs if socket.enabled]


def trace(start: Input) -> Source | Input | None:
    """The source of an input: a node's output; or the input whose own value counts; or nothing (a dead end)."""
    socket, groups = start.socket, start.groups
    # The last one that has a value of its own.
    reader = start
    for _ in range(_DEEPEST):
        # `links` looks through all links of the tree: most sockets have none.
        links = socket.links if socket.is_linked else ()
        link = next((link for link in links if link.is_valid and not link.is_muted), None)
        if link is None:
            return reader if socket == reader.socket or bpy.app.version >= _KEEPS_VALUES else None
        node, output = link.from_node, link.from_socket
        if node.mute:
            socket = next((inner.from_socket for inner in node.internal_links if inner.to_socket == output), None)
            if socket is None:
                return reader
            continue
        if node.type == "REROUTE":
            socket = node.inputs[0]
            continue
        if node.type == "GROUP":
            socket = _group_result(node, output)
            groups = (*groups, node)
        elif node.type == "GROUP_INPUT" and groups:
            socket = next((outer for outer in groups[-1].inputs if outer.identifier == output.identifier), None)
            groups = groups[:-1]
        else:
            return Source(node, output, groups)
        if socket is None:
            return None
        reader = Input(socket, groups)
    return None


def _group_result(node: bpy.types.Node, output: bpy.types.NodeSocket) -> bpy.types.NodeSocket | None:
    """The input of a group's output node that feeds an output of the group node."""
    if node.node_tree is None:
        return None
    ends = [inner for inner in node.node_tree.nodes if inner.type == "GROUP_OUTPUT"]
    end = next((inner for inner in ends if inner.is_active_output), None)
    if end is None:
        return None
    return next((socket for socket in end.inputs if socket.identifier == output.identifier), None)


def subsurface_method(node: bpy.types.Node, name: str) -> str:
    """The value of that property by its name of since Blender 5.1: the random walk of before is the legacy one."""
    method = getattr(node, name)
    known = node.bl_rna.properties[name].enum_items
    return f"{method}_LEGACY" if method == "RANDOM_WALK" and "RANDOM_WALK_LEGACY" not in known else method


def value(socket: bpy.types.NodeSocket) -> Any:
    """A socket's own value: a float, or a tuple of them; None for shaders."""
    own = getattr(socket, "default_value", None)
    if own is None:
        return None
    return tuple(own) if hasattr(own, "__len__") else float(own)
