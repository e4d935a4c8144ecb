# SPDX-License-Identifier: GPL-3.0-or-later
"""A stage that shows many node cases at once: a tilted tile for each, photographed by Cycles from straight above.

A tile glows with what its node gives. A second picture, with the same seed, shows where each pixel's ray fell.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from support.node_cases import Case

#: Pixels along a tile.
SIDE = 8
#: World units from one tile's centre to the next; the tile is 2 wide.
PITCH = 2.0
SLOPE = (0.4, 0.25)
SCALE = np.array((1.25, 0.8, 1.0))
CAMERA_HEIGHT = 10.0
CLIP_START = 0.1
NORMAL = np.array((-SLOPE[0], -SLOPE[1], 1.0)) / math.hypot(*SLOPE, 1.0)
PASS_INDICES = {"object": 3, "material": 5}


class Stage:
    """Shows cases; `expected` is Cycles's answer, `given` what our program says at the same points."""

    def __init__(self, bpy: Any, graph: Any, native: Any, cases: list[Case], folder: Path) -> None:
        self._bpy, self._graph, self._native = bpy, graph, native
        self._columns = math.ceil(math.sqrt(len(cases)))
        self._image = _image(bpy)
        _camera(bpy, self._columns * PITCH)
        self._tiles = {}
        self._materials = {}
        self._centres = {}
        #: Cases that this Blender cannot show: an older one lacks a node or option.
        self.unknown: set[str] = set()
        for number, case in enumerate(cases):
            row, column = divmod(number, self._columns)
            middle = (self._columns - 1) / 2.0
            centre = ((column - middle) * PITCH, (row - middle) * PITCH, 0.0)
            self._centres[case.name] = (row, column, np.array(centre))
            try:
                self._materials[case.name] = _Material(bpy, case, centre, self._image).material
            except (TypeError, AttributeError, RuntimeError):
                self.unknown.add(case.name)
                continue
            self._tiles[case.name] = _tile(bpy, centre, self._materials[case.name])
        bpy.context.view_layer.update()
        self._expected = _photograph(bpy, folder / "values.exr", self._columns * SIDE)
        bpy.context.view_layer.material_override = _position_material(bpy)
        self._positions = _photograph(bpy, folder / "positions.exr", self._columns * SIDE)

    def _tile_of(self, pixels: np.ndarray, name: str) -> np.ndarray:
        row, column, _ = self._centres[name]
        tile = pixels[row * SIDE : (row + 1) * SIDE, column * SIDE : (column + 1) * SIDE]
        return tile.reshape(-1, 3)

    def expected(self, case: Case) -> np.ndarray:
        """Cycles's values, (points, 3)."""
        return self._tile_of(self._expected, case.name)

    def given(self, case: Case) -> tuple[np.ndarray, list[str]]:
        """Our values, and what the compiler reported."""
        material = self._materials[case.name]
        described = self._graph.describe(material.node_tree, lambda node: 0)
        answer = self._native.evaluate_graph(
            json.dumps(described),
            self._points(case.name),
            images=[_linear_pixels(self._image)],
            world_to_object=np.linalg.inv(np.array(self._tiles[case.name].matrix_world, np.float64)),
            world_to_camera=np.diag((1.0, 1.0, -1.0, 1.0))
            @ np.linalg.inv(np.array(self._bpy.context.scene.camera.matrix_world, np.float64)),
        )
        (layer,) = answer["surface"]
        return layer["inputs"]["Color"] * layer["weight"], answer["reports"]

    def _points(self, name: str) -> dict[str, np.ndarray]:
        p = self._tile_of(self._positions, name).astype(np.float64)
        local = p - self._centres[name][2]
        up = np.broadcast_to((0.0, 0.0, 1.0), p.shape)
        normal = np.broadcast_to(NORMAL, p.shape)
        in_camera = p * (1.0, 1.0, -1.0) + (0.0, 0.0, CAMERA_HEIGHT)
        distance = np.linalg.norm(in_camera, axis=1, keepdims=True)
        uv = local @ np.array(UV_MATRIX)
        mesh_normal = NORMAL * SCALE / np.linalg.norm(NORMAL * SCALE)
        # Where u grows by one, v and the height over the tile do not.
        rows = np.vstack((np.array(UV_MATRIX)[:, :2].T * SCALE, mesh_normal))
        tangent = np.linalg.solve(rows, (1.0, 0.0, 0.0))
        extent = np.array((1.0, 1.0, sum(SLOPE)))
        fields = {
            "position": p,
            "normal": normal,
            "true_normal": normal,
            "mesh_normal": np.broadcast_to(mesh_normal, p.shape),
            "incoming": up,
            "object": local / SCALE,
            "generated": local / (2.0 * extent) + 0.5,
            "camera": in_camera,
            "window": (p / (self._columns * PITCH) + 0.5) * (1.0, 1.0, 0.0),
            "reflection": 2.0 * NORMAL[2] * normal - up,
            "object_location": p - local,
            "object_colour": np.broadcast_to((0.2, 0.4, 0.6), p.shape),
            "object_alpha": np.full(p.shape, 0.5),
            "object_index": np.full(p.shape, PASS_INDICES["object"]),
            "material_index": np.full(p.shape, PASS_INDICES["material"]),
            "view_vector": in_camera / distance,
            "view_depth": np.repeat(in_camera[:, 2:], 3, axis=1),
            "view_distance": np.repeat(distance, 3, axis=1),
            "is_camera_ray": np.ones(p.shape),
            # Cycles counts from where the camera begins to see.
            "ray_length": np.repeat(in_camera[:, 2:] - CLIP_START, 3, axis=1),
            # Across the line of sight a pixel of the stage is as wide everywhere; the slope shortens the axes of it.
            "pixel_width": np.full(p.shape, np.mean(np.linalg.norm(FOOTPRINT[:, :2], axis=1))),
            "edge_distance": np.repeat(_edge_distance(local)[:, None], 3, axis=1),
            "uv:": uv,
            "uv:UVMap": uv,
            "tangent:": np.column_stack((np.broadcast_to(tangent / np.linalg.norm(tangent), p.shape), np.ones(len(p)))),
            "colour:Paint": paint(local),
            "geometry:Paint": paint(local),
            "geometry:lone": np.repeat(lone(local)[:, None], 3, axis=1),
        }
        for axis, step in zip("xy", FOOTPRINT, strict=True):
            fields[f"footprint_{axis}"] = np.broadcast_to(step, p.shape)
            fields[f"position/{axis}"] = np.broadcast_to(step, p.shape)
            fields[f"object/{axis}"] = np.broadcast_to(step / SCALE, p.shape)
            fields[f"generated/{axis}"] = np.broadcast_to(step / (2.0 * extent), p.shape)
            fields[f"uv:UVMap/{axis}"] = np.broadcast_to(step @ np.array(UV_MATRIX), p.shape)
            fields[f"uv:/{axis}"] = np.broadcast_to(step @ np.array(UV_MATRIX), p.shape)
        return {name: np.ascontiguousarray(values, np.float32) for name, values in fields.items()}


def _edge_distance(local: np.ndarray) -> np.ndarray:
    """From the tile's four sides and the one across, between its two triangles."""
    corners = np.array(((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)))
    corners = np.column_stack((corners, corners @ SLOPE))
    distances = []
    for first, second in ((0, 1), (1, 2), (2, 3), (3, 0), (0, 2)):
        along = corners[second] - corners[first]
        away = np.cross(along / np.linalg.norm(along), local - corners[first])
        distances.append(np.linalg.norm(away, axis=1))
    return np.min(distances, axis=0)


def _footprint() -> np.ndarray:
    """Two axes across the tile, a pixel long: as Cycles chooses them, by the flat normal alone."""
    x, y, z = NORMAL
    first = np.array((z - y, x - z, y - x))
    first /= np.linalg.norm(first)
    return np.array((first, np.cross(NORMAL, first))) * (PITCH / SIDE)


FOOTPRINT = _footprint()


#: From a tile's own coordinates to its UV map: turned and skewed.
UV_MATRIX = ((0.7, 0.2, 0.0), (-0.3, 0.6, 0.0), (0.0, 0.0, 0.0))


def paint(local: np.ndarray) -> np.ndarray:
    """The colour attribute."""
    return np.column_stack(
        (local[:, 0] * 0.5 + 0.5, local[:, 1] * 0.4 + 0.5, *np.full((2, len(local)), ((0.3,), (0.8,))))
    )


def lone(local: np.ndarray) -> np.ndarray:
    """The attribute of one number."""
    return local[:, 0] + 2.0 * local[:, 1]


def _tile(bpy: Any, centre: tuple[float, ...], material: Any) -> Any:
    flat = np.array(((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)))
    local = np.column_stack((flat, flat @ SLOPE))
    mesh = bpy.data.meshes.new("tile")
    mesh.from_pydata((local / SCALE).tolist(), [], [(0, 1, 2, 3)])
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", (local @ np.array(UV_MATRIX))[:, :2].ravel())
    mesh.color_attributes.new("Paint", "FLOAT_COLOR", "POINT").data.foreach_set("color", paint(local).ravel())
    mesh.attributes.new("lone", "FLOAT", "POINT").data.foreach_set("value", lone(local))
    mesh.materials.append(material)
    tile = bpy.data.objects.new("tile", mesh)
    tile.location, tile.scale = centre, SCALE
    tile.color, tile.pass_index = (0.2, 0.4, 0.6, 0.5), PASS_INDICES["object"]
    bpy.context.scene.collection.objects.link(tile)
    return tile


def _camera(bpy: Any, width: float) -> None:
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale, camera.clip_start = "ORTHO", width, CLIP_START
    held = bpy.data.objects.new("camera", camera)
    held.location = (0.0, 0.0, CAMERA_HEIGHT)
    bpy.context.scene.collection.objects.link(held)
    bpy.context.scene.camera = held


def _image(bpy: Any) -> Any:
    """Small, so that every kind of interpolation shows; transparent in places."""
    image = bpy.data.images.new("noise", 7, 5, alpha=True, float_buffer=True, is_data=False)
    rng = np.random.default_rng(3)
    pixels = rng.random((5, 7, 4)).astype(np.float32)
    pixels[..., 3] = np.where(pixels[..., 3] < 0.5, 1.0, pixels[..., 3])
    image.alpha_mode = "PREMUL"
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    image.pack()
    return image


def _linear_pixels(image: Any) -> np.ndarray:
    """Colours multiplied by alpha."""
    width, height = image.size
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(height, width, 4)


def _photograph(bpy: Any, path: Path, side: int) -> np.ndarray:
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = side
    scene.render.resolution_percentage = 100
    scene.cycles.device = "CPU"
    scene.cycles.samples = 1
    scene.cycles.seed = 7
    scene.cycles.max_bounces = 0
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    # Nearly the pixels' centres; the picture of positions says where exactly.
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BLACKMAN_HARRIS", 0.01
    image = scene.render.image_settings
    if hasattr(image, "media_type"):
        image.media_type = "IMAGE"
    image.file_format, image.color_depth, image.color_mode = "OPEN_EXR", "32", "RGB"
    scene.render.filepath = str(path)
    from support import kept_references

    kept_references.render_still()
    loaded = bpy.data.images.load(str(path))
    pixels = np.empty(side * side * loaded.channels, np.float32)
    loaded.pixels.foreach_get(pixels)
    return pixels.reshape(side, side, loaded.channels)[..., :3]


def _new_material(bpy: Any, name: str) -> Any:
    material = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    material.pass_index = PASS_INDICES["material"]
    material.node_tree.nodes.clear()
    return material


def _position_material(bpy: Any) -> Any:
    material = _new_material(bpy, "position")
    nodes, links = material.node_tree.nodes, material.node_tree.links
    geometry, glow, output = (nodes.new(f"ShaderNode{kind}") for kind in ("NewGeometry", "Emission", "OutputMaterial"))
    links.new(geometry.outputs["Position"], glow.inputs["Color"])
    links.new(glow.outputs[0], output.inputs["Surface"])
    return material


class _Material:
    """A case's node tree."""

    def __init__(self, bpy: Any, case: Case, centre: tuple[float, ...], image: Any) -> None:
        self.material = _new_material(bpy, case.name)
        self._tree = self.material.node_tree
        self._centre = centre
        node = self._tree.nodes.new(case.kind)
        if case.kind in {"ShaderNodeTexImage", "ShaderNodeTexEnvironment"}:
            node.image = image
        for option, value in case.options.items():
            setattr(node, option, value)
        if case.curves == "camera":
            node.object = bpy.context.scene.camera
        elif case.curves in {"POINT", "TEXTURE", "VECTOR", "NORMAL"}:
            mapping = node.texture_mapping
            mapping.vector_type, mapping.translation = case.curves, (0.2, -0.3, 0.4)
            mapping.rotation, mapping.scale = (0.3, 0.5, -0.2), (1.5, 0.7, 1.2)
        elif case.curves:
            _set_curves(node, case.curves)
        if case.kind == "ShaderNodeRGB":
            node.outputs[0].default_value = (0.3, 0.5, 0.7, 1.0)
        elif case.kind == "ShaderNodeValue":
            node.outputs[0].default_value = -1.7
        elif case.kind == "ShaderNodeNormal":
            node.outputs[0].default_value = (0.48, 0.6, 0.64)
        for name, value in case.inputs.items():
            socket = next(
                socket
                for socket in node.inputs
                if name in (socket.identifier, socket.name) and socket.enabled or name == socket.identifier
            )
            if isinstance(value, str):
                self._tree.links.new(self._source(value), socket)
            else:
                socket.default_value = value
        glow, output = (self._tree.nodes.new(f"ShaderNode{kind}") for kind in ("Emission", "OutputMaterial"))
        result = next(socket for socket in node.outputs if socket.identifier == case.output)
        self._tree.links.new(result, glow.inputs["Color"])
        self._tree.links.new(glow.outputs[0], output.inputs["Surface"])

    def _source(self, name: str) -> Any:
        if name == "local":
            geometry = self._tree.nodes.new("ShaderNodeNewGeometry")
            return self._vector_math("SUBTRACT", geometry.outputs["Position"], self._centre)
        if name == "colour":
            return self._vector_math("MULTIPLY_ADD", self._source("local"), (0.5,) * 3, (0.5, 0.45, 0.55))
        if name == "wide":
            return self._vector_math("MULTIPLY_ADD", self._source("local"), (1.7, 1.6, 2.1), (0.2, 0.25, 0.1))
        if name == "tilted":
            leaned = self._vector_math("MULTIPLY_ADD", self._source("local"), (0.5, 0.4, 0.0), (0.0, 0.0, 1.0))
            return self._vector_math("NORMALIZE", leaned)
        if name.startswith("noise"):
            return self._noise(name.removeprefix("noise").strip())
        if name == "bumped":
            node = self._tree.nodes.new("ShaderNodeBump")
            self._tree.links.new(self._noise("object"), node.inputs["Height"])
            return node.outputs[0]
        if name == "x01":
            return self._part("colour", "X")
        return self._part("local", name.upper())

    def _noise(self, coordinates: str) -> Any:
        node = self._tree.nodes.new("ShaderNodeTexNoise")
        node.inputs["Scale"].default_value = 0.7
        given = self._source("local")
        if coordinates:
            given = self._tree.nodes.new("ShaderNodeTexCoord").outputs[
                coordinates.upper() if coordinates == "uv" else coordinates.title()
            ]
        self._tree.links.new(given, node.inputs["Vector"])
        return node.outputs[0]

    def _part(self, of: str, name: str) -> Any:
        separate = self._tree.nodes.new("ShaderNodeSeparateXYZ")
        self._tree.links.new(self._source(of), separate.inputs[0])
        return separate.outputs[name]

    def _vector_math(self, operation: str, first: Any, *others: tuple[float, ...]) -> Any:
        node = self._tree.nodes.new("ShaderNodeVectorMath")
        node.operation = operation
        self._tree.links.new(first, node.inputs[0])
        for socket, value in zip(node.inputs[1:], others, strict=False):
            socket.default_value = value
        return node.outputs["Vector"]


def _set_curves(node: Any, name: str) -> None:
    if node.type == "VALTORGB":
        ramp = node.color_ramp
        if name[:3] in {"hsv", "hsl"}:
            ramp.color_mode, ramp.hue_interpolation = name[:3].upper(), name[4:].upper()
        else:
            ramp.interpolation = name.upper()
        for place, colour in ((0.2, (0.9, 0.1, 0.2, 0.3)), (0.6, (0.1, 0.7, 0.9, 1.0))):
            ramp.elements.new(place).color = colour
        return
    mapping = node.mapping
    mapping.extend = "HORIZONTAL" if name == "bent_ends" else "EXTRAPOLATED"
    if name == "straight":
        return
    for number, curve in enumerate(mapping.curves):
        curve.points.new(0.3 + 0.1 * number, 0.6 - 0.2 * number)
        curve.points[-1].location.y = 0.9
    mapping.update()
