# SPDX-License-Identifier: GPL-3.0-or-later
"""The world: a colour or an equirectangular image."""

from __future__ import annotations

import bpy
from mathutils import Matrix

from ..description import Report, WorldDescription
from .image import Images
from .nodes import Output, Socket, constant, output_surface

_IDENTITY = Matrix.Identity(3)


def send(world: bpy.types.World | None, builder, images: Images, report: Report) -> None:
    """Hands the world over; without one it is black."""
    if world is None:
        return
    if world.node_tree is None or not getattr(world, "use_nodes", True):
        builder.set_world(WorldDescription(color=tuple(world.color)))
        return
    found = output_surface(world.node_tree)
    if found is None:
        return
    if found.node.type != "BACKGROUND":
        report.warn(f"world '{world.name}': node '{found.node.name}' is not supported yet; its viewport colour is used")
        builder.set_world(WorldDescription(color=tuple(world.color)))
        return
    builder.set_world(_background(world, found, images, report))


def _background(world: bpy.types.World, node: Output, images: Images, report: Report) -> WorldDescription:
    strength = constant(node.input("Strength"))
    if strength is None:
        report.warn(f"world '{world.name}': nodes that vary its strength are not supported yet; taken as 1")
        strength = 1.0
    colour = node.input("Color")
    plain = constant(colour)
    if plain is not None:
        return WorldDescription(color=tuple(c * strength for c in plain))
    source = colour.source()
    if source.node.type == "TEX_ENVIRONMENT":
        if source.node.projection != "EQUIRECTANGULAR":
            report.warn(f"world '{world.name}': mirror-ball images are not supported yet; taken as equirectangular")
        return WorldDescription(
            color=(strength,) * 3,
            image=images.index(source.node.image, f"world '{world.name}'"),
            rotation=tuple(tuple(row) for row in _rotation(world, source, report)),
        )
    report.warn(
        f"world '{world.name}': node '{source.node.name}' ({source.node.bl_label}) is not supported yet; "
        "its viewport colour is used"
    )
    return WorldDescription(color=tuple(c * strength for c in world.color))


def _rotation(world: bpy.types.World, texture: Output, report: Report) -> Matrix:
    """World direction to image direction, from a Mapping node on the texture's vector."""
    source = texture.input("Vector").source()
    if isinstance(source, Socket) or source.node.type == "TEX_COORD":
        return _IDENTITY
    if source.node.type != "MAPPING":
        report.warn(f"world '{world.name}': node '{source.node.name}' is not supported yet; its image is not turned")
        return _IDENTITY
    angles = source.node.inputs["Rotation"].default_value
    scale = source.node.inputs["Scale"].default_value
    if source.node.inputs["Rotation"].is_linked or any(abs(s - 1.0) > 1e-6 for s in scale):
        report.warn(f"world '{world.name}': of its Mapping node only a constant rotation is used yet")
    turned = angles.to_matrix()
    return turned.transposed() if source.node.vector_type == "TEXTURE" else turned
