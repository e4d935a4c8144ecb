# SPDX-License-Identifier: GPL-3.0-or-later
"""Walking node graphs: through reroutes, muted nodes and groups, to what drives a socket."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import bpy

# Deeper than any graph that people draw; a circle, which Blender refuses, would never end.
_MOST_STEPS = 256


@dataclass(frozen=True)
class Socket:
    """An input socket, and the group nodes that its tree was entered by."""

    socket: bpy.types.NodeSocket
    groups: tuple[bpy.types.Node, ...] = ()

    @property
    def name(self) -> str:
        return self.socket.name

    def source(self) -> Output | Socket:
        """The node output that drives it; or the unlinked socket at the end whose own value counts."""
        here = self
        for _ in range(_MOST_STEPS):
            link = next((link for link in here.socket.links if link.is_valid and not link.is_muted), None)
            if link is None:
                return here
            node, groups = link.from_node, here.groups
            if node.type == "REROUTE":
                here = Socket(node.inputs[0], groups)
            elif node.mute:
                inside = next((i.from_socket for i in node.internal_links if i.to_socket == link.from_socket), None)
                if inside is None:
                    return Output(node, link.from_socket, groups)
                here = Socket(inside, groups)
            elif node.type == "GROUP" and node.node_tree is not None:
                out = _group_output(node.node_tree)
                inner = out.inputs.get(link.from_socket.name) if out else None
                if inner is None:
                    return Output(node, link.from_socket, groups)
                here = Socket(inner, (*groups, node))
            elif node.type == "GROUP_INPUT" and groups:
                outer = groups[-1].inputs.get(link.from_socket.name)
                if outer is None:
                    return Output(node, link.from_socket, groups)
                here = Socket(outer, groups[:-1])
            else:
                return Output(node, link.from_socket, groups)
        return here


@dataclass(frozen=True)
class Output:
    """An output of a node that does something."""

    node: bpy.types.Node
    socket: bpy.types.NodeSocket
    groups: tuple[bpy.types.Node, ...] = ()

    def input(self, *names: str) -> Socket | None:
        """The first of the node's inputs that has one of the names: they differ between Blender's versions."""
        for name in names:
            found = self.node.inputs.get(name)
            if found is not None:
                return Socket(found, self.groups)
        return None

    def inputs(self) -> Iterator[Socket]:
        for socket in self.node.inputs:
            if socket.enabled:
                yield Socket(socket, self.groups)


def output_surface(tree: bpy.types.NodeTree) -> Output | None:
    """What is linked to the surface of the tree's active output."""
    node = tree.get_output_node("CYCLES")
    socket = node.inputs.get("Surface") if node else None
    found = Socket(socket).source() if socket else None
    return found if isinstance(found, Output) else None


def constant(socket: Socket | None) -> float | tuple[float, float, float] | None:
    """The value of a socket that nothing but plain values drive; None where it varies."""
    if socket is None:
        return None
    found = socket.source()
    if isinstance(found, Socket):
        return value(found.socket)
    if found.node.type in {"RGB", "VALUE"}:
        return value(found.node.outputs[0])
    if found.node.type == "BLACKBODY":
        return None
    return None


def value(socket: bpy.types.NodeSocket) -> float | tuple[float, float, float]:
    """A socket's own value; a colour loses its alpha."""
    v = socket.default_value
    return float(v) if isinstance(v, (int, float)) else tuple(float(x) for x in v)[:3]


def _group_output(tree: bpy.types.NodeTree) -> bpy.types.Node | None:
    outputs = [n for n in tree.nodes if n.type == "GROUP_OUTPUT"]
    return next((n for n in outputs if n.is_active_output), outputs[0] if outputs else None)
