# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps."""

from __future__ import annotations

import bpy

from ..description import LightDescription, Report
from .matrix import rows
from .nodes import constant, output_surface


def describe(obj: bpy.types.Object, matrix_world, report: Report) -> LightDescription:
    data = obj.data
    colour = [channel * data.energy for channel in data.color]
    # Since 4.5 a lamp has an exposure, and a temperature that multiplies its colour.
    exposure = 2.0 ** getattr(data, "exposure", 0.0)
    tint = data.temperature_color if getattr(data, "use_temperature", False) else (1.0, 1.0, 1.0)
    nodes = _node_factor(obj.name, data, report)
    colour = tuple(c * exposure * t * n for c, t, n in zip(colour, tint, nodes, strict=True))
    if not getattr(data, "normalize", True):
        report.warn(f"light '{obj.name}': 'Normalize' switched off is not supported yet; taken as on")
    common = {
        "object_name": obj.name,
        "matrix_world": rows(matrix_world),
        "color": colour,
        "visible_camera": obj.visible_camera,
        "cast_shadow": getattr(data, "use_shadow", True),
    }
    if data.type == "SUN":
        return LightDescription(kind="SUN", angle_rad=data.angle, **common)
    if data.type == "AREA":
        # Square and disk have one size for both sides.
        one_size = data.shape in {"SQUARE", "DISK"}
        return LightDescription(
            kind="AREA",
            shape="ELLIPSE" if data.shape in {"DISK", "ELLIPSE"} else "RECTANGLE",
            size=(data.size, data.size if one_size else data.size_y),
            spread_rad=data.spread,
            **common,
        )
    if data.type == "SPOT":
        return LightDescription(
            kind="SPOT",
            radius=data.shadow_soft_size,
            spot_angle_rad=data.spot_size,
            spot_blend=data.spot_blend,
            **common,
        )
    return LightDescription(kind="POINT", radius=data.shadow_soft_size, **common)


def _node_factor(name: str, data: bpy.types.Light, report: Report) -> tuple[float, float, float]:
    """What a lamp's own nodes multiply its light by: one Emission node with constants."""
    if not getattr(data, "use_nodes", False) or data.node_tree is None:
        return (1.0, 1.0, 1.0)
    found = output_surface(data.node_tree)
    if found is None:
        return (0.0, 0.0, 0.0)
    if found.node.type != "EMISSION":
        report.warn(f"light '{name}': node '{found.node.name}' is not supported yet; its light is taken as plain")
        return (1.0, 1.0, 1.0)
    colour = constant(found.input("Color"))
    strength = constant(found.input("Strength"))
    if colour is None or strength is None:
        report.warn(f"light '{name}': nodes that vary its light are not supported yet; taken as plain")
        return (1.0, 1.0, 1.0)
    return tuple(channel * strength for channel in colour)
