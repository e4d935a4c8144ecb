# SPDX-License-Identifier: GPL-3.0-or-later
"""Values that shaders give out beside the surface: AOV Output nodes, as far as the view layer names them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bpy

from .graph import Ends, ImageIndex

#: Closures that the engine takes of a graph.
_MOST = 32


class Aovs:
    """The outputs that a view layer names, each with its number."""

    def __init__(self, view_layer: bpy.types.ViewLayer) -> None:
        valid = [(number, one) for number, one in enumerate(view_layer.aovs) if one.is_valid]
        self._known = {one.name: (number, one.type) for number, one in valid}

    def describe(self, tree: bpy.types.NodeTree | None, image_index: ImageIndex) -> tuple[dict, list[int]] | None:
        """A graph whose closures emit the inputs of a tree's AOV Output nodes, and the numbers of these; None where there are
        none that the view layer names."""
        if tree is None or not self._known:
            return None
        ends = Ends(image_index)
        numbers, links = [], []
        for node, groups in _outputs(tree):
            known = self._known.get(node.aov_name)
            if known is None or known[0] in numbers or len(numbers) == _MOST:
                continue
            number, kind = known
            given = ends.input(node.inputs["Value" if kind == "VALUE" else "Color"], groups)
            socket = "Strength" if kind == "VALUE" else "Color"
            inputs: dict[str, Any] = {"Color": [1.0, 1.0, 1.0], "Strength": 1.0, socket: given}
            links.append(ends.add({"type": "ShaderNodeEmission", "name": node.name, "options": {}, "inputs": inputs}))
            numbers.append(number)
        if not numbers:
            return None
        whole = links[0]
        for link in links[1:]:
            sockets = {"Shader": whole, "Shader_001": link}
            whole = ends.add(
                {"type": "ShaderNodeAddShader", "name": "AOVs", "options": {}, "inputs": sockets}, "Shader"
            )
        return {"nodes": ends.finished(), "surface": whole, "volume": None, "displacement": None}, numbers


def _outputs(
    tree: bpy.types.NodeTree, groups: tuple[bpy.types.Node, ...] = ()
) -> Iterator[tuple[bpy.types.Node, tuple[bpy.types.Node, ...]]]:
    """The AOV Output nodes of a tree and of the groups in it, with the groups that lead to each."""
    for node in tree.nodes:
        if node.mute:
            continue
        if node.type == "OUTPUT_AOV":
            yield node, groups
        elif node.type == "GROUP" and node.node_tree is not None and len(groups) < _MOST:
            yield from _outputs(node.node_tree, (*groups, node))
