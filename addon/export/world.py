# SPDX-License-Identifier: GPL-3.0-or-later
"""The world: one colour, or an equirectangular image with its turn."""

from __future__ import annotations

import json

import bpy
from mathutils import Matrix

from ..description import Colour, Report, WorldDescription
from . import graph, nodes, values, visibility
from .camera import rows
from .image import Images
from .material import uses_nodes
from .texture import Inputs


def describe(world: bpy.types.World | None, images: Images, report: Report) -> WorldDescription:
    """What the engine is told of the world; none is black."""
    if world is None:
        return WorldDescription()
    described = Report()
    try:
        description = _surface(world, Inputs(f"World '{world.name}'", images, described))
    except nodes.TooLarge:
        description = None
    if description is None or described.warnings:
        description = _by_its_nodes(world, images, report)
    description.hidden_from = visibility.world_hidden_from(world)
    return description


def mist(world: bpy.types.World | None) -> tuple[float, float, float]:
    """Where mist begins, how deep it is until nothing is seen, and the power by which it grows."""
    if world is None:
        return 0.0, 1.0, 1.0
    own = world.mist_settings
    return own.start, own.depth, {"QUADRATIC": 2.0, "LINEAR": 1.0, "INVERSE_QUADRATIC": 0.5}[own.falloff]


def fills_space(world: bpy.types.World | None) -> bool:
    """Whether it has a volume."""
    if world is None or not uses_nodes(world):
        return False
    output = world.node_tree.get_output_node("CYCLES")
    return output is not None and isinstance(nodes.trace(nodes.Input(output.inputs["Volume"])), nodes.Source)


def _by_its_nodes(world: bpy.types.World, images: Images, report: Report) -> WorldDescription:
    owner = f"World '{world.name}'"
    return WorldDescription(graph=json.dumps(graph.describe(world.node_tree, lambda node: images.of_node(node, owner))))


def _surface(world: bpy.types.World, inputs: Inputs) -> WorldDescription:
    if not uses_nodes(world):
        return WorldDescription(color=tuple(world.color))
    output = world.node_tree.get_output_node("CYCLES")
    if output is None:
        return WorldDescription()
    if isinstance(nodes.trace(nodes.Input(output.inputs["Volume"])), nodes.Source):
        inputs.warn("volume: its nodes say what fills space")
    start = nodes.Input(output.inputs["Surface"])
    found = nodes.trace(start)
    if not isinstance(found, nodes.Source):
        return WorldDescription()
    if found.node.type == "TEX_ENVIRONMENT":
        # A colour where a shader is expected shines as it is.
        return _shining(start, 1.0, inputs)
    if found.node.type not in {"BACKGROUND", "EMISSION"}:
        behind = nodes.find_upstream(start, "BACKGROUND")
        inputs.warn(
            f"{found.node.bl_label} is not supported yet, "
            + ("its first background is used" if behind else "the plain world colour is used")
        )
        if behind is None:
            return WorldDescription(color=tuple(world.color))
        found = behind
    return _shining(found.input("Color"), inputs.constant(found.input("Strength")), inputs)


def _shining(start: nodes.Input, strength: float, inputs: Inputs) -> WorldDescription:
    """What shines with the colour of an input, so strongly."""
    colour = values.constant(start)
    if colour is not None:
        return WorldDescription(color=_times(colour[:3], strength))
    found = nodes.trace(start)
    if found.node.type != "TEX_ENVIRONMENT":
        behind = nodes.find_upstream(start, "TEX_ENVIRONMENT")
        if behind is None:
            return _plain(found.node, start, strength, inputs)
        inputs.warn(f"{found.node.bl_label} is not supported yet, the image before it is used as it is")
        found = behind
    if found.node.projection != "EQUIRECTANGULAR":
        inputs.warn("the mirror ball projection is not supported yet, the image is taken as equirectangular")
    return WorldDescription(
        color=_times((1.0, 1.0, 1.0), strength),
        image=inputs.images.index(found.node.image, inputs.owner, associated=True),
        rotation=_turn(found, inputs),
    )


def _plain(node: bpy.types.Node, start: nodes.Input, strength: float, inputs: Inputs) -> WorldDescription:
    inputs.warn(f"{node.bl_label} is not supported yet, one colour is used")
    colour = values.estimate(start) or nodes.value(start.socket)
    return WorldDescription(color=_times(colour[:3], strength))


def _turn(source: nodes.Source, inputs: Inputs) -> tuple[tuple[float, ...], ...]:
    """World direction to image direction."""
    matrix = Matrix.Identity(4)
    found = nodes.trace(source.input("Vector"))
    while isinstance(found, nodes.Source) and found.node.type == "MAPPING":
        matrix = matrix @ inputs.mapping(found)
        found = nodes.trace(found.input("Vector"))
    # A world's Generated and Object coordinates are the direction itself.
    if isinstance(found, nodes.Source) and not (
        found.node.type == "TEX_COORD" and found.socket.name in {"Generated", "Object"}
    ):
        inputs.warn("coordinates other than Generated are not supported for its image yet, Generated is used")
    x, y, z = matrix.to_scale()
    if matrix.translation.length > 1e-6 or max(abs(x - y), abs(x - z)) > 1e-5:
        inputs.warn("location and scale of a Mapping node are not supported for its image yet, only rotation is used")
    return rows(matrix.to_quaternion().to_matrix())


def _times(colour: Colour, strength: float) -> Colour:
    return tuple(part * strength for part in colour)
