# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees in few words. Needs no Blender until a tree is there."""

from __future__ import annotations

#: A ramp's stops where none are given: (position, colour).
STOPS = ((0.3, (0.05, 0.1, 0.4, 1.0)), (0.7, (0.9, 0.5, 0.1, 1.0)))


class Tree:
    """Builds a node tree; `surface` is the input of its output node that `shows` links to."""

    def __init__(self, tree, surface):
        self.tree, self._surface = tree, surface

    def node(self, kind: str, settings: dict | None = None, **inputs):
        """A node; an input's value, or an output that is linked to it. `_2` is the input of that number."""
        made = self.tree.nodes.new(f"ShaderNode{kind}")
        for name, value in (settings or {}).items():
            setattr(made, name, value)
        for name, value in inputs.items():
            socket = made.inputs[int(name[1:])] if name[0] == "_" else made.inputs[name.replace("_", " ")]
            if hasattr(value, "is_linked"):
                self.tree.links.new(value, socket)
            else:
                socket.default_value = value
        return made

    def shows(self, output):
        """Links a shader to the tree's output."""
        self.tree.links.new(output, self._surface)

    def lifts(self, output):
        """Links a displacement to the tree's output."""
        self.tree.links.new(output, self._surface.node.inputs["Displacement"])

    def coordinates(self, output: str):
        return self.node("TexCoord").outputs[output]

    def math(self, operation: str, first, second=0.0):
        return self.node("Math", {"operation": operation}, _0=first, _1=second).outputs[0]

    def mix(self, share, first, second):
        """Of two shaders."""
        return self.node("MixShader", _0=share, _1=first, _2=second).outputs[0]

    def ramp(self, factor, *stops, interpolation="LINEAR"):
        """`stops`: (position, colour)."""
        stops = stops or STOPS
        made = self.node("ValToRGB", Fac=factor)
        elements = made.color_ramp.elements
        made.color_ramp.interpolation = interpolation
        while len(elements) < len(stops):
            elements.new(0.5)
        for element, (position, colour) in zip(elements, stops, strict=True):
            element.position, element.color = position, colour
        return made.outputs["Color"]
