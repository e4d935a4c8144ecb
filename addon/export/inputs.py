# SPDX-License-Identifier: GPL-3.0-or-later
"""A shader's inputs: constants, or images; anything else by the nearest of these, and a word about it."""

from __future__ import annotations

from collections import deque

from ..description import Colour, ColourInput, FloatInput, ImageInput, Report
from .image import Images
from .nodes import Output, Socket, constant, value

_INTERPOLATION = {"Linear": "LINEAR", "Cubic": "LINEAR", "Smart": "LINEAR", "Closest": "CLOSEST"}
_EXTENSION = {"REPEAT": "REPEAT", "EXTEND": "EXTEND", "CLIP": "CLIP", "MIRROR": "MIRROR"}
_CHANNELS = {"Red": "RED", "R": "RED", "Green": "GREEN", "G": "GREEN", "Blue": "BLUE", "B": "BLUE"}


class Inputs:
    """Reads the inputs of one material's shaders."""

    def __init__(self, material: str, images: Images, report: Report) -> None:
        self._material = material
        self._images = images
        self._report = report

    def colour(self, n: Output, otherwise: Colour, *names: str) -> ColourInput:
        return self.of(n.input(*names), otherwise, colour=True)

    def number(self, n: Output, otherwise: float, *names: str) -> FloatInput:
        return self.of(n.input(*names), otherwise, colour=False)

    def plain(self, n: Output, otherwise: float, *names: str) -> float:
        """A number that the engine wants the same everywhere."""
        found = self.of(n.input(*names), otherwise, colour=False)
        return self._no_image(found, otherwise, names[0])

    def plain_colour(self, n: Output, otherwise: Colour, *names: str) -> Colour:
        found = self.of(n.input(*names), otherwise, colour=True)
        return self._no_image(found, otherwise, names[0])

    def of(self, socket: Socket | None, otherwise, *, colour: bool):
        """What drives a socket; `otherwise` where this version of Blender has no such socket."""
        if socket is None:
            return otherwise
        plain = constant(socket)
        if plain is not None:
            return _as(plain, colour)
        source = socket.source()
        image = self._image(source)
        if image is not None:
            return image
        inner = self._image_before(source)
        if inner is not None:
            self._warn(f"node '{source.node.name}' ({source.node.bl_label}) on '{socket.name}' is not supported yet; "
                       "the image before it is used as it is")  # fmt: skip
            return inner
        self._warn(f"node '{source.node.name}' ({source.node.bl_label}) on '{socket.name}' is not supported yet; "
                   "the socket's own value is used")  # fmt: skip
        return _as(value(socket.socket), colour)

    def _image(self, source: Output | Socket) -> ImageInput | None:
        """The image that a node output is; also one channel of it."""
        if isinstance(source, Socket):
            return None
        channel = "COLOR"
        if source.node.type in {"SEPARATE_COLOR", "SEPRGB"} and source.socket.name in _CHANNELS:
            channel = _CHANNELS[source.socket.name]
            source = next(source.inputs()).source()
            if isinstance(source, Socket):
                return None
        if source.node.type != "TEX_IMAGE":
            return None
        if source.socket.name == "Alpha":
            channel = "ALPHA"
        node = source.node
        if node.projection != "FLAT":
            self._warn(f"image texture '{node.name}': {node.projection.lower()} projection is not supported yet")
        uv_map, mapping = self._coordinates(source)
        return ImageInput(
            image=self._images.index(node.image, f"material '{self._material}'"),
            uv_map=uv_map,
            mapping=mapping,
            interpolation=_INTERPOLATION.get(node.interpolation, "LINEAR"),
            extension=_EXTENSION.get(node.extension, "REPEAT"),
            channel=channel,
        )

    def _image_before(self, source: Output | Socket) -> ImageInput | None:
        """The nearest image upstream of a node that is not known."""
        waiting = deque([source])
        for _ in range(64):
            if not waiting:
                return None
            here = waiting.popleft()
            if isinstance(here, Socket):
                continue
            image = self._image(here)
            if image is not None:
                return image
            waiting.extend(socket.source() for socket in here.inputs())
        return None

    def _coordinates(self, texture: Output) -> tuple[str | None, tuple]:
        """UV map and affine map of a texture's vector."""
        mapping = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
        source = texture.input("Vector").source()
        if isinstance(source, Output) and source.node.type == "MAPPING":
            mapping = self._mapping(source)
            source = source.input("Vector").source()
        if isinstance(source, Socket) or (source.node.type == "TEX_COORD" and source.socket.name == "UV"):
            return None, mapping
        if source.node.type == "UVMAP":
            return source.node.uv_map or None, mapping
        what = f"'{source.node.name}' ({source.node.bl_label}, {source.socket.name})"
        self._warn(f"image texture '{texture.node.name}': coordinates from {what} are not supported yet; UV are used")
        return None, mapping

    def _mapping(self, node: Output) -> tuple:
        """A Mapping node in the plane of the texture, as Blender applies it to (u, v, 0)."""
        from mathutils import Matrix, Vector

        parts = {name: node.input(name) for name in ("Location", "Rotation", "Scale")}
        values = {name: constant(socket) if socket else None for name, socket in parts.items()}
        if any(socket is not None and values[name] is None for name, socket in parts.items()):
            self._warn(f"mapping '{node.node.name}': values that vary are not supported yet; taken as unmapped")
            return ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
        kind = node.node.vector_type
        place = Vector(values["Location"] or (0.0, 0.0, 0.0))
        angles = values["Rotation"] or (0.0, 0.0, 0.0)
        scale = Vector(values["Scale"] or (1.0, 1.0, 1.0))
        turn = _euler(angles)
        if kind == "TEXTURE":
            safe = Matrix.Diagonal([1.0 / s if s else 0.0 for s in scale])
            linear = safe @ turn.transposed()
            place = -(linear @ place)
        else:
            linear = turn @ Matrix.Diagonal(scale)
            if kind != "POINT":
                place = Vector((0.0, 0.0, 0.0))
        return tuple((linear[i][0], linear[i][1], place[i]) for i in range(2))

    def _no_image(self, found, otherwise, name: str):
        if isinstance(found, ImageInput):
            self._warn(f"an image on '{name}' is not supported yet; the default is used")
            return otherwise
        return found

    def _warn(self, text: str) -> None:
        self._report.warn(f"material '{self._material}': {text}")


def _euler(angles):
    from mathutils import Euler

    return Euler(angles, "XYZ").to_matrix()


def _as(plain, colour: bool):
    """A number where a colour is wanted is grey; a colour where a number is wanted is its luminance."""
    if colour:
        return plain if isinstance(plain, tuple) else (plain,) * 3
    return plain if isinstance(plain, float) else 0.2126 * plain[0] + 0.7152 * plain[1] + 0.0722 * plain[2]
