# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps: their colour times energy in Blender's units, their shape, their place."""

from __future__ import annotations

import json
from math import acos, atan, cos, pi, sin, tan
from typing import Any

import bpy
from mathutils import Matrix

from petzval.description import Colour, LightDescription

from . import graph
from .camera import rows
from .image import Images
from .light_groups import LightGroups
from .linking import Links
from .material import uses_nodes


class Lights:
    """The lamps of one scene; the nodes of a light are read once, wherever it stands."""

    def __init__(self, images: Images, links: Links, groups: LightGroups) -> None:
        self._images = images
        self._links = links
        self._groups = groups
        # By the light datablock: its nodes, if they change anything.
        self._nodes: dict[int, str | None] = {}

    def describe(self, holder: bpy.types.Object, matrix: Matrix, hidden_from: tuple[str, ...]) -> LightDescription:
        """The description of a lamp object for the engine; `matrix` is the matrix of this instance of it."""
        light = holder.data
        key = light.original.as_pointer()
        if key not in self._nodes:
            self._nodes[key] = _nodes(light, self._images)
        description = LightDescription(
            object_name=holder.name,
            kind=light.type,
            matrix_world=rows(matrix),
            color=_colour(light),
            graph=self._nodes[key],
            hidden_from=hidden_from,
            sets=self._links.sets(holder),
            light_group=self._groups.number(holder),
            # Cycles's own setting; without Cycles nothing limits it.
            max_bounces=getattr(getattr(light, "cycles", None), "max_bounces", 1024),
            cast_shadow=light.use_shadow,
        )
        _shape(description, light, matrix)
        return description


def is_portal(light: bpy.types.Light) -> bool:
    """True if the light only tells Cycles where the sky comes in, and gives no light."""
    return light.type == "AREA" and getattr(getattr(light, "cycles", None), "is_portal", False)


def _shape(description: LightDescription, light: bpy.types.Light, matrix: Matrix) -> None:
    """Fills in the fields that only some kinds of light have."""
    if light.type in {"POINT", "SPOT"}:
        description.radius = light.shadow_soft_size
        description.soft_falloff = light.use_soft_falloff
    if light.type == "SPOT":
        description.spot_angle_rad, description.spot_blend = _cone(light, matrix)
    elif light.type == "SUN":
        description.angle_rad = light.angle
    elif light.type == "AREA":
        description.shape = "ELLIPSE" if light.shape in {"DISK", "ELLIPSE"} else "RECTANGLE"
        description.size = (light.size, light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else light.size)
        description.spread_rad = light.spread
    if not getattr(light, "normalize", True):
        size = _size(light, matrix)
        description.color = tuple(part * size for part in description.color)


def _colour(light: bpy.types.Light) -> Colour:
    # Exposure and temperature came with 4.5.
    strength = light.energy * 2.0 ** getattr(light, "exposure", 0.0)
    colour = [part * strength for part in light.color]
    if getattr(light, "use_temperature", False):
        colour = [a * b for a, b in zip(colour, light.temperature_color, strict=True)]
    return tuple(colour)


def _nodes(light: bpy.types.Light, images: Images) -> str | None:
    """The nodes of a light as the engine takes them; the nodes of a new light, which change nothing, are left out."""
    if not uses_nodes(light):
        return None
    described = graph.describe(light.node_tree, lambda node: images.of_node(node, light))
    return None if described["nodes"] and _is_plain(described) else json.dumps(described)


def _is_plain(described: dict[str, Any]) -> bool:
    """True if the description is one Emission as Blender makes it."""
    first, *more = described["nodes"]
    inputs = first["inputs"]
    one = first["type"] == "ShaderNodeEmission" and inputs["Color"] == [1.0] * 3 and inputs["Strength"] == 1.0
    return one and not more


def _cone(light: bpy.types.Light, matrix: Matrix) -> tuple[float, float]:
    """A spot's angle and blend; its object's scale stretches the cone."""
    x, y, z = (abs(part) for part in matrix.to_scale())
    if z == 0.0 or x == y == z:
        return light.spot_size, light.spot_blend

    def stretched(angle: float) -> float:
        return atan(tan(angle) * 0.5 * (x + y) / z)

    rim = 0.5 * light.spot_size
    # Where the light is full: the blend is a part of the cone by its cosine.
    full = acos(cos(rim) + (1.0 - cos(rim)) * light.spot_blend)
    rim, full = stretched(rim), stretched(full)
    return 2.0 * rim, (cos(full) - cos(rim)) / (1.0 - cos(rim)) if rim > 0.0 else 0.0


def _size(light: bpy.types.Light, matrix: Matrix) -> float:
    """The divisor by which Blender spreads a light's power over its size."""
    if light.type == "SUN":
        size = pi * sin(0.5 * light.angle) ** 2
    elif light.type == "AREA":
        size_y = light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else light.size
        across = matrix.to_scale()
        size = light.size * abs(across.x) * size_y * abs(across.y)
        if light.shape in {"DISK", "ELLIPSE"}:
            size *= 0.25 * pi
    else:
        # That of a sphere; Cycles takes 4 for one without size.
        size = 4.0 * pi * light.shadow_soft_size**2 or 4.0
    return size or 1.0
