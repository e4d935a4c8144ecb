# SPDX-License-Identifier: GPL-3.0-or-later
"""Inputs of a shader: a constant, or an Image Texture with what stands before it."""

from __future__ import annotations

from typing import Any

import bpy
from mathutils import Euler, Matrix, Vector

from ..description import ImageInput, Report
from . import nodes, values
from .image import Images

CHANNELS = {"Red": "RED", "Green": "GREEN", "Blue": "BLUE", "R": "RED", "G": "GREEN", "B": "BLUE"}
INTERPOLATIONS = {"Closest": "CLOSEST"}


class Inputs:
    """Reads the inputs of one material's (or world's, or light's) nodes; says what it could not hand over."""

    def __init__(self, owner: str, images: Images, report: Report) -> None:
        self.owner = owner
        self.images = images
        self._report = report

    def warn(self, text: str) -> None:
        """A warning that begins with the owner."""
        self._report.warn(f"{self.owner}: {text}")

    def colour(self, start: nodes.Input) -> Any:
        """A constant colour or an image."""
        given = self._value_or_image(start)
        return given[:3] if isinstance(given, tuple) else given

    def number(self, start: nodes.Input) -> Any:
        """A constant number or an image."""
        return self._value_or_image(start)

    def constant(self, start: nodes.Input) -> Any:
        """A value that must stand still; where it varies, the socket's own, and a warning."""
        given = values.constant(start)
        if given is None:
            self.warn(f"{_label(start)} cannot vary over the surface yet, one value is used")
            given = self._one_value(start)
        return given[:3] if isinstance(given, tuple) else given

    def _value_or_image(self, start: nodes.Input) -> Any:
        given = values.constant(start)
        if given is not None:
            return given
        found = nodes.trace(start)
        image = self._image(found)
        if image is not None:
            return image
        node_name = found.node.bl_label if isinstance(found, nodes.Source) else "its input"
        behind = nodes.find_upstream(start, "TEX_IMAGE")
        if behind is not None:
            self.warn(f"{_label(start)}: {node_name} is not supported yet, the image before it is used as it is")
            return self._texture(behind, "ALPHA" if behind.socket.name == "Alpha" else "COLOR")
        self.warn(f"{_label(start)}: {node_name} is not supported yet, one value is used for the whole surface")
        return self._one_value(start)

    def _one_value(self, start: nodes.Input) -> Any:
        """About the average of an input that varies, else its own value."""
        guess = values.estimate(start)
        return nodes.value(start.socket) if guess is None else guess

    def _image(self, found: nodes.Source | nodes.Input | None) -> ImageInput | None:
        """An image that drives an input directly, or by one of its channels."""
        if not isinstance(found, nodes.Source):
            return None
        if found.node.type == "TEX_IMAGE":
            return self._texture(found, "ALPHA" if found.socket.name == "Alpha" else "COLOR")
        if found.node.type in {"SEPARATE_COLOR", "SEPRGB"} and found.socket.name in CHANNELS:
            whole = nodes.trace(nodes.Input(found.node.inputs[0], found.groups))
            if isinstance(whole, nodes.Source) and whole.node.type == "TEX_IMAGE" and whole.socket.name == "Color":
                return self._texture(whole, CHANNELS[found.socket.name])
        return None

    def _texture(self, source: nodes.Source, channel: str) -> ImageInput:
        node = source.node
        if node.projection != "FLAT":
            self.warn(f"the projection {node.projection.title()} of an Image Texture is not supported yet, UV is used")
        uv_map, matrix = self._coordinates(source.input("Vector"))
        if node.interpolation in {"Cubic", "Smart"}:
            self.warn(f"{node.interpolation.lower()} interpolation of images is not supported yet, linear is used")
        return ImageInput(
            image=self.images.index(node.image, self.owner, associated=not node.outputs["Alpha"].is_linked),
            uv_map=uv_map,
            mapping=tuple((matrix[row][0], matrix[row][1], matrix[row][3]) for row in range(2)),
            interpolation=INTERPOLATIONS.get(node.interpolation, "LINEAR"),
            extension=node.extension,
            channel=channel,
        )

    def _coordinates(self, start: nodes.Input) -> tuple[str | None, Matrix]:
        """The UV map's name (None: the active one), and the map from UV to the image."""
        matrix = Matrix.Identity(4)
        found = nodes.trace(start)
        while isinstance(found, nodes.Source) and found.node.type == "MAPPING":
            matrix = matrix @ self.mapping(found)
            found = nodes.trace(found.input("Vector"))
        if not isinstance(found, nodes.Source):
            return None, matrix
        node = found.node
        if node.type == "UVMAP":
            return node.uv_map or None, matrix
        if node.type == "ATTRIBUTE" and node.attribute_type == "GEOMETRY" and found.socket.name == "Vector":
            return node.attribute_name or None, matrix
        if not (node.type == "TEX_COORD" and found.socket.name == "UV"):
            kind = found.socket.name if node.type == "TEX_COORD" else node.bl_label
            self.warn(f"{kind} coordinates of an Image Texture are not supported yet, UV is used")
        return None, matrix

    def mapping(self, source: nodes.Source) -> Matrix:
        """What a Mapping node does to a point."""
        node = source.node

        def given(name: str, otherwise: Vector) -> Vector:
            socket = node.inputs.get(name)
            return Vector(self.constant(source.input(name))) if socket and socket.enabled else otherwise

        location = given("Location", Vector((0.0, 0.0, 0.0)))
        rotation = Euler(given("Rotation", Vector((0.0, 0.0, 0.0)))).to_matrix().to_4x4()
        size = given("Scale", Vector((1.0, 1.0, 1.0)))
        matrix = Matrix.Translation(location) @ rotation @ Matrix.Diagonal(size).to_4x4()
        if node.vector_type == "TEXTURE":
            return matrix.inverted_safe()
        return matrix


def _label(start: nodes.Input) -> str:
    node: bpy.types.Node = start.socket.node
    return f"{node.bl_label}'s {start.socket.name}"
