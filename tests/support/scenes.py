# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes for the tests in Blender, and their pictures as arrays. Imported inside of tests: it needs bpy."""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

import bpy
import numpy as np

from support import kept_references


def addon():
    """The add-on's package, as the `blender` fixture has registered it."""
    return sys.modules["petzval_addon"]


def part(name: str):
    """A module of the add-on: `part("export.nodes")`."""
    import importlib

    return importlib.import_module(f"petzval_addon.{name}")


def set_up(width: int = 48, height: int = 32, samples: int = 4, model: str = "PINHOLE") -> bpy.types.Scene:
    """The scene of an empty file: Petzval, a small EXR, a camera at the origin that looks along +y, a grey world."""
    scene = bpy.context.scene
    scene.render.engine = "PETZVAL"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    scene.petzval.samples = samples
    undenoised(scene)
    exr(scene)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.rotation_euler = (np.pi / 2, 0.0, 0.0)
    camera.data.petzval.model = model
    without_diffraction(scene)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.world = grey_world(0.5)
    return scene


def undenoised(scene: bpy.types.Scene) -> None:
    """Pictures as their samples have them: a new scene is denoised."""
    if hasattr(scene, "cycles"):
        scene.cycles.use_denoising = False


def straight(scene: bpy.types.Scene) -> None:
    """Light as its rays alone take it through the lens: nothing is taken of it, and nothing strays."""
    for effect in ("transmission", "ghosts", "glare", "diffraction"):
        setattr(scene.petzval.effects, effect, "OFF")


def without_diffraction(scene: bpy.types.Scene) -> None:
    """Where it is not what is tested: small pictures show none, and it takes a second of each through a lens."""
    scene.petzval.effects.diffraction = "OFF"


def exr(scene: bpy.types.Scene, file_format: str = "OPEN_EXR") -> None:
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "MULTI_LAYER_IMAGE" if file_format == "OPEN_EXR_MULTILAYER" else "IMAGE"
    settings.file_format = file_format
    if file_format.startswith("OPEN_EXR"):
        settings.color_depth = "32"
    settings.color_mode = "RGBA"


def with_nodes(holder):
    """Its node tree, emptied."""
    if holder.node_tree is None or bpy.app.version < (5, 0, 0):
        holder.use_nodes = True
    holder.node_tree.nodes.clear()
    return holder.node_tree


def grey_world(value: float, name: str = "World") -> bpy.types.World:
    world = bpy.data.worlds.new(name)
    tree = with_nodes(world)
    background = tree.nodes.new("ShaderNodeBackground")
    background.inputs["Color"].default_value = (value, value, value, 1.0)
    out = tree.nodes.new("ShaderNodeOutputWorld")
    tree.links.new(background.outputs[0], out.inputs["Surface"])
    return world


def material(name: str = "Material"):
    """A material with an output alone: (material, tree, output's surface socket)."""
    made = bpy.data.materials.new(name)
    tree = with_nodes(made)
    out = tree.nodes.new("ShaderNodeOutputMaterial")
    return made, tree, out.inputs["Surface"]


def emitter(colour=(1.0, 1.0, 1.0), strength: float = 1.0, name: str = "Glow") -> bpy.types.Material:
    made, tree, surface = material(name)
    node = tree.nodes.new("ShaderNodeEmission")
    node.inputs["Color"].default_value = (*colour, 1.0)
    node.inputs["Strength"].default_value = strength
    tree.links.new(node.outputs[0], surface)
    return made


def mesh_object(name: str, vertices, faces, *materials, uv=None) -> bpy.types.Object:
    """An object from plain data, linked to the scene."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(map(float, v)) for v in vertices], [], [tuple(map(int, f)) for f in faces])
    if uv is not None:
        layer = mesh.uv_layers.new(name="UVMap")
        layer.uv.foreach_set("vector", np.asarray(uv, np.float32).reshape(-1))
    for one in materials:
        mesh.materials.append(one)
    made = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(made)
    return made


def square(name: str, centre, size: float, *materials) -> bpy.types.Object:
    """Upright, facing the camera of `set_up`, UV from its lower left corner."""
    h = size / 2
    made = mesh_object(
        name, [(-h, 0, -h), (h, 0, -h), (h, 0, h), (-h, 0, h)], [(0, 1, 2, 3)], *materials,
        uv=[(0, 0), (1, 0), (1, 1), (0, 1)],
    )  # fmt: skip
    made.location = centre
    return made


def image(name: str, pixels, *, is_float: bool = False, space: str | None = None) -> bpy.types.Image:
    """A generated image; `pixels` (height, width, 4), first row at the bottom, as Blender shows them."""
    pixels = np.asarray(pixels, np.float32)
    made = bpy.data.images.new(name, pixels.shape[1], pixels.shape[0], alpha=True, float_buffer=is_float)
    if space:
        made.colorspace_settings.name = space
    made.pixels.foreach_set(pixels.reshape(-1))
    made.update()
    made.pack()
    return made


def render(folder: Path, name: str = "picture.exr") -> np.ndarray:
    """Renders the scene into a file; its pixels (height, width, 4) as the file has them."""
    path = Path(folder) / name
    bpy.context.scene.render.filepath = str(path)
    kept_references.render_still()
    return read(path)


def read(path: Path) -> np.ndarray:
    """The pixels of a picture, (height, width, 4), first row at the bottom, as they stand in the file."""
    loaded = bpy.data.images.load(str(path))
    try:
        loaded.colorspace_settings.name = "Non-Color"
        loaded.alpha_mode = "CHANNEL_PACKED"
        width, height = loaded.size
        assert width and height, f"{path} cannot be read"
        pixels = np.empty(width * height * loaded.channels, np.float32)
        loaded.pixels.foreach_get(pixels)
        return pixels.reshape(height, width, loaded.channels)
    finally:
        bpy.data.images.remove(loaded)


def at_corners(mesh: dict, values: tuple[str, np.ndarray]) -> np.ndarray:
    """What was sent, (triangles, 3, numbers)."""
    domain, rows = values
    return rows[mesh["triangles"] if domain == "POINT" else mesh["loops"]]


class Recorder:
    """The engine's own builder, with a record of what was sent to it."""

    def __init__(self) -> None:
        self._builder = part("native").engine().SceneBuilder()
        self.images, self.materials, self.meshes, self.instances, self.lights, self.world = [], [], [], [], [], None
        # By their index among the meshes, where nothing else stands.
        self.curves: dict[int, dict] = {}
        self.points: dict[int, dict] = {}
        #: How often a method was called.
        self.calls = Counter()

    def add_image(self, name, pixels, *, srgb):
        self.images.append((name, pixels.copy(), srgb))
        return self._builder.add_image(name, pixels, srgb=srgb)

    def add_tiles(self, name, tiles):
        # Of their own index, which counts among the images.
        self.images.append((name, tiles, None))
        return self._builder.add_tiles(name, tiles)

    def add_material(self, description):
        self.materials.append(description)
        return self._builder.add_material(description)

    def add_mesh(self, name, positions, triangles, **more):
        self.meshes.append({"name": name, "positions": positions, "triangles": triangles, **more})
        return self._builder.add_mesh(name, positions, triangles, **more)

    def add_curves(self, name, keys, first_keys, shape, **more):
        index = self._builder.add_curves(name, keys, first_keys, shape, **more)
        self.curves[index] = {"name": name, "keys": keys, "first_keys": first_keys, "shape": shape, **more}
        self.meshes.append(None)
        return index

    def add_points(self, name, points, **more):
        index = self._builder.add_points(name, points, **more)
        self.points[index] = {"name": name, "points": points, **more}
        self.meshes.append(None)
        return index

    def add_instance(self, name, mesh, matrix, materials, *, others=None, **more):
        told = {"name": name, "mesh": mesh, "matrix": np.array(matrix), "materials": materials, **more}
        self.instances.append(told)
        for further, random in zip(*(others or ([], [])), strict=True):
            color, number, _ = more["info"]
            self.instances.append({**told, "matrix": further, "info": (color, number, random)})
        self.calls["add_instance"] += 1
        return self._builder.add_instance(name, mesh, matrix, materials, others=others, **more)

    def add_light(self, light):
        self.lights.append(light)
        return self._builder.add_light(light)

    def set_world(self, world):
        self.world = world
        return self._builder.set_world(world)

    def corners(self, instance: dict) -> np.ndarray:
        """World positions of an instance's triangles, (triangles, 3, 3)."""
        mesh = self.meshes[instance["mesh"]]
        corners = mesh["positions"][mesh["triangles"]].astype(float)
        matrix = instance["matrix"]
        return corners @ matrix[:3, :3].T + matrix[:3, 3]

    def of(self, name: str) -> list[dict]:
        """The instances of an object."""
        return [one for one in self.instances if one["name"] == name]

    def build(self):
        return self._builder.build((0.0, 0.0, 0.0), 1)


class _Sent(bpy.types.RenderEngine):
    """Blender makes a render's dependency graph for an engine alone: this one looks at what Petzval would send."""

    bl_idname = "PETZVAL_TEST"
    bl_label = "Petzval's export"
    kept = None

    def render(self, depsgraph):
        recorder, report = Recorder(), part("export.report").Report()
        try:
            part("export").send_scene(depsgraph, recorder, report, lambda: None)
            scene = depsgraph.scene_eval
            width, height = part("export.camera").resolution(scene.render)
            try:
                camera = part("export.camera").describe(scene.camera, scene, width, height, report)
            except part("export.errors").ExportError as error:
                camera = error
            _Sent.kept = (recorder, report.warnings, camera)
        except BaseException as error:
            import traceback

            traceback.print_exc()
            _Sent.kept = error
        black = np.zeros((self.resolution_y, self.resolution_x, 4), np.float32)
        result = self.begin_result(0, 0, self.resolution_x, self.resolution_y)
        result.layers[0].passes["Combined"].rect.foreach_set(black.reshape(-1))
        self.end_result(result)


def sent():
    """What a render of the scene would send: (recorder, warnings, camera description)."""
    scene = bpy.context.scene
    bpy.utils.register_class(_Sent)
    engine = scene.render.engine
    scene.render.engine = _Sent.bl_idname
    _Sent.kept = None
    try:
        bpy.ops.render.render()
    finally:
        scene.render.engine = engine
        bpy.utils.unregister_class(_Sent)
    if isinstance(_Sent.kept, BaseException):
        raise _Sent.kept
    return _Sent.kept
