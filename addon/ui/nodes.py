# SPDX-License-Identifier: GPL-3.0-or-later
"""The nodes of a material, a light or a world in a panel: those behind the output that a render reads."""

from __future__ import annotations

import bpy
from bpy_extras.node_utils import find_node_input

from ..export.material import uses_nodes


def draw_nodes(layout: bpy.types.UILayout, holder: bpy.types.ID, name: str) -> bool:
    """Draws the node that is plugged into the output's socket of that name; True if the holder has nodes at all."""
    if not uses_nodes(holder) or holder.node_tree is None:
        if holder.node_tree is not None or bpy.app.version < (5, 0, 0):
            layout.prop(holder, "use_nodes", icon="NODETREE")
        return False
    tree = holder.node_tree
    # With outputs for several engines, Cycles's is the one that is read.
    node = tree.get_output_node("CYCLES")
    socket = find_node_input(node, name) if node is not None else None
    if socket is not None:
        layout.template_node_view(tree, node, socket)
    else:
        layout.label(text="No output node" if node is None else "Incompatible output node")
    return True
