# SPDX-License-Identifier: GPL-3.0-or-later
"""The world: one colour, an equirectangular image with its rotation, or a graph of its nodes."""

from __future__ import annotations

import json
from typing import Any

import bpy
from mathutils import Euler, Matrix

from petzval.description import WorldDescription

from . import graph, nodes, visibility
from .aovs import Aovs
from .camera import rows
from .image import Images
from .material import uses_nodes

#: Nodes that look an image up.
_IMAGES = {"ShaderNodeTexEnvironment", "ShaderNodeTexImage"}


def describe(world: bpy.types.World | None, images: Images, aovs: Aovs) -> WorldDescription:
    """The description of the world for the engine; no world is black."""
    if world is None:
        return WorldDescription()
    description = _surface(world, images)
    description.hidden_from = visibility.world_hidden_from(world)
    if uses_nodes(world):
        found = aovs.describe(world.node_tree, lambda node: images.of_node(node, world))
        if found is not None:
            description.aovs = json.dumps(found[0]), found[1]
    cycles = getattr(world, "cycles", None)
    # Without light samples of the world neither does anything in Cycles.
    if getattr(cycles, "sampling_method", "NONE") != "NONE":
        description.max_bounces, description.cast_shadow = cycles.max_bounces, getattr(cycles, "use_shadows", True)
    return description


def occlusion_distance(world: bpy.types.World | None) -> float | None:
    """Length of the rays of ambient occlusion, Blender units; None: without end."""
    return None if world is None else world.light_settings.distance


def mist(world: bpy.types.World | None) -> tuple[float, float, float]:
    """The start of mist, its depth until nothing is seen, and the power by which it grows."""
    if world is None:
        return 0.0, 1.0, 1.0
    own = world.mist_settings
    return own.start, own.depth, {"QUADRATIC": 2.0, "LINEAR": 1.0, "INVERSE_QUADRATIC": 0.5}[own.falloff]


def fills_space(world: bpy.types.World | None) -> bool:
    """True if the world has a volume."""
    if world is None or not uses_nodes(world):
        return False
    output = world.node_tree.get_output_node("CYCLES")
    return output is not None and isinstance(nodes.trace(nodes.Input(output.inputs["Volume"])), nodes.Source)


def _surface(world: bpy.types.World, images: Images) -> WorldDescription:
    if not uses_nodes(world):
        return WorldDescription(color=tuple(world.color))
    described = graph.describe(world.node_tree, lambda node: images.of_node(node, world))
    has_image = any(node["type"] in _IMAGES for node in described["nodes"])
    return _plain(described) or WorldDescription(graph=json.dumps(described), has_image=has_image)


def _plain(described: dict[str, Any]) -> WorldDescription | None:
    """A colour or an equirectangular image, turned; None where the nodes say more."""
    if described["volume"] is not None:
        return None
    if described["surface"] is None:
        return WorldDescription()
    color, strength = described["surface"], 1.0
    shader = described["nodes"][color["node"]]
    if shader["type"] in {"ShaderNodeBackground", "ShaderNodeEmission"}:
        color, strength = shader["inputs"]["Color"], shader["inputs"]["Strength"]
    if isinstance(strength, dict):
        return None
    if not isinstance(color, dict):
        return WorldDescription(color=tuple(part * strength for part in color))
    image = described["nodes"][color["node"]]
    options = image["options"]
    is_plain = image["type"] == "ShaderNodeTexEnvironment" and options["projection"] == "EQUIRECTANGULAR"
    rotation = _rotation(image["inputs"].get("Vector"), described["nodes"]) if is_plain else None
    if rotation is None or color["socket"] != "Color" or options["image"] is None:
        return None
    return WorldDescription(color=(strength,) * 3, image=options["image"], rotation=rows(rotation))


def _rotation(vector: Any, described: list[dict[str, Any]]) -> Matrix | None:
    """The rotation from a direction in the world to one in its image, if that is all that the nodes before it do."""
    matrix = Matrix.Identity(4)
    while isinstance(vector, dict):
        node = described[vector["node"]]
        if node["type"] == "ShaderNodeTexCoord" and vector["socket"] in {"Generated", "Object"}:
            # Of a world they are the direction itself.
            vector = None
        elif node["type"] == "ShaderNodeMapping" and node["options"]["vector_type"] in {"POINT", "TEXTURE"}:
            step = _mapping(node)
            if step is None:
                return None
            matrix, vector = matrix @ step, node["inputs"].get("Vector")
        else:
            return None
    x, y, z = matrix.to_scale()
    if vector is not None or matrix.translation.length > 1e-6 or max(abs(x - y), abs(x - z)) > 1e-5:
        return None
    return matrix.to_quaternion().to_matrix()


def _mapping(node: dict[str, Any]) -> Matrix | None:
    """The map of a Mapping node, where nothing drives it."""
    parts = [node["inputs"].get(name) for name in ("Location", "Rotation", "Scale")]
    if any(isinstance(part, dict) for part in parts):
        return None
    location, rotation, scale = (part or [fill] * 3 for part, fill in zip(parts, (0.0, 0.0, 1.0), strict=True))
    turn = Euler(rotation).to_matrix().to_4x4()
    matrix = Matrix.Translation(location) @ turn @ Matrix.Diagonal(scale).to_4x4()
    return matrix.inverted_safe() if node["options"]["vector_type"] == "TEXTURE" else matrix
