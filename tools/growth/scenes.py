# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes of one number that grows, built in bpy: a ground, a light, a camera above, and so many of one kind of thing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import bpy
import numpy as np

#: A triplet of plain glasses; so many flat windows stand in front of it.
TRIPLET = (
    "12.0 2.0 1.620/60.3 12 0.0 0",
    "80.0 3.0 air 12 0.0 0",
    "-25.0 1.0 1.620/36.3 9 0.0 0",
    "11.5 1.2 air 9 0.0 0",
    "0.0 1.8 air 7 0.0 1",
    "60.0 2.0 1.620/60.3 10 0.0 0",
    "-18.0 30.0 air 10 0.0 0",
)


def new(width: int, height: int, samples: int) -> bpy.types.Scene:
    """A ground in a grey world under a sun, seen from above through a pinhole."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    scene.cycles.device, scene.cycles.samples, scene.petzval.samples = "CPU", samples, samples
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.render.use_persistent_data = True
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    linked("Sun", bpy.data.lights.new("Sun", "SUN")).rotation_euler = (0.6, 0.2, 0.0)
    camera = linked("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0.0, -14.0, 9.0), (1.0, 0.0, 0.0)
    camera.data.petzval.model = "PINHOLE"
    for frame in (1, 2):
        camera.keyframe_insert("location", frame=frame)
        camera.location.x += 0.01
    scene.camera = camera
    linked("Ground", waves("Ground", 2, 12.0))
    return scene


def linked(name: str, data: bpy.types.ID) -> bpy.types.Object:
    """A new object of the data, in the scene."""
    holder = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(holder)
    return holder


def waves(name: str, triangles: int, side: float) -> bpy.types.Mesh:
    """A square in waves, smooth, with a UV map, of about so many triangles."""
    steps = max(round((triangles / 2) ** 0.5), 1)
    x, y = np.meshgrid(*[np.linspace(-0.5, 0.5, steps + 1, dtype=np.float32)] * 2)
    places = np.stack([side * x, side * y, 0.1 * np.sin(17 * x) * np.cos(13 * y)], -1).reshape(-1, 3)
    first = np.arange(steps * (steps + 1), dtype=np.int32).reshape(steps, steps + 1)[:, :-1].ravel()
    faces = np.stack([first, first + 1, first + steps + 2, first + steps + 1], -1)
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(places))
    mesh.vertices.foreach_set("co", places.ravel())
    mesh.loops.add(faces.size)
    mesh.loops.foreach_set("vertex_index", faces.ravel())
    mesh.polygons.add(len(faces))
    mesh.polygons.foreach_set("loop_start", np.arange(0, faces.size, 4, dtype=np.int32))
    mesh.update(calc_edges=True)
    mesh.shade_smooth()
    mesh.uv_layers.new().uv.foreach_set("vector", (places[faces.ravel(), :2] / side + 0.5).ravel())
    return mesh


def places(count: int, side: float = 11.0) -> np.ndarray:
    """Centres of a square's cells, (count, 2), and so many that they fill it."""
    cells = max(int(np.ceil(count**0.5)), 1)
    x, y = np.meshgrid(*[(np.arange(cells) + 0.5) / cells - 0.5] * 2)
    return (side * np.stack([x, y], -1).reshape(-1, 2)[:count]).astype(float)


def triangles(scene: bpy.types.Scene, count: int) -> None:
    linked("Waves", waves("Waves", count, 11.0)).location.z = 0.5


def objects(scene: bpy.types.Scene, count: int) -> None:
    """Objects, each with a mesh of its own, of eight triangles."""
    side = 8.0 / count**0.5
    for index, (x, y) in enumerate(places(count)):
        linked(f"Object {index}", waves(f"Mesh {index}", 8, side)).location = (x, y, 0.5)


def instances(scene: bpy.types.Scene, count: int) -> None:
    """Instances at the vertices of a mesh."""
    mesh = bpy.data.meshes.new("Places")
    mesh.vertices.add(count)
    at = places(count)
    mesh.vertices.foreach_set("co", np.column_stack([at, np.full(count, 0.5)]).astype(np.float32).ravel())
    holder, one = linked("Places", mesh), linked("One", waves("One", 200, 8.0 / count**0.5))
    one.parent, holder.instance_type = holder, "VERTS"


def materials(scene: bpy.types.Scene, count: int) -> None:
    """Materials on the faces of one mesh, each with a colour of its own and a noise."""
    faces = max(int(np.ceil(count**0.5)), 1)
    mesh = waves("Faces", 2 * faces * faces, 11.0)
    for index in range(count):
        material = bpy.data.materials.new(f"Material {index}")
        material.use_nodes = True
        tree = material.node_tree
        noise = tree.nodes.new("ShaderNodeTexNoise")
        noise.inputs["Scale"].default_value = 3.0 + index % 17
        tree.links.new(noise.outputs[0], tree.nodes["Principled BSDF"].inputs["Roughness"])
        tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (index % 7 / 7, index % 5 / 5, 0.5, 1.0)
        mesh.materials.append(material)
    mesh.polygons.foreach_set("material_index", np.arange(faces * faces, dtype=np.int32) % count)
    linked("Faces", mesh).location.z = 0.5


def textures(scene: bpy.types.Scene, count: int) -> None:
    """Images of 256 x 256 pixels on faces of one mesh, each in a material of its own."""
    materials(scene, count)
    dice = np.random.default_rng(1)
    for index, material in enumerate(bpy.data.materials):
        image = bpy.data.images.new(f"Image {index}", 256, 256)
        image.pixels.foreach_set(dice.random(256 * 256 * 4, dtype=np.float32))
        tree = material.node_tree
        texture = tree.nodes.new("ShaderNodeTexImage")
        texture.image = image
        tree.links.new(texture.outputs[0], tree.nodes["Principled BSDF"].inputs["Base Color"])


def texture_pixels(scene: bpy.types.Scene, count: int) -> None:
    """Pixels of one image of bytes on the ground."""
    side = max(round(count**0.5), 1)
    image = bpy.data.images.new("Image", side, side)
    row = np.linspace(0.0, 1.0, side, dtype=np.float32)
    image.pixels.foreach_set(np.broadcast_to(row[None, :, None], (side, side, 4)).ravel())
    material = bpy.data.materials.new("Ground")
    material.use_nodes = True
    tree = material.node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    tree.links.new(texture.outputs[0], tree.nodes["Principled BSDF"].inputs["Base Color"])
    scene.objects["Ground"].data.materials.append(material)


def lamps(scene: bpy.types.Scene, count: int) -> None:
    """Point lights of as much power together."""
    lamp = bpy.data.lights.new("Lamp", "POINT")
    lamp.energy, lamp.shadow_soft_size = 2000.0 / count, 0.05
    for index, (x, y) in enumerate(places(count)):
        linked(f"Lamp {index}", lamp).location = (x, y, 1.0 + index % 3 * 0.5)


def glowing_triangles(scene: bpy.types.Scene, count: int) -> None:
    """Triangles of one mesh that shines."""
    material = bpy.data.materials.new("Glow")
    material.use_nodes = True
    tree = material.node_tree
    glow = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(glow.outputs[0], tree.get_output_node("CYCLES").inputs["Surface"])
    mesh = waves("Glow", count, 3.0)
    mesh.materials.append(material)
    holder = linked("Glow", mesh)
    holder.location, holder.rotation_euler = (0.0, 3.0, 3.0), (2.0, 0.0, 0.0)


def hairs(scene: bpy.types.Scene, count: int) -> None:
    """Strands of eight points each."""
    data = bpy.data.hair_curves.new("Hairs")
    data.add_curves([8] * count)
    dice = np.random.default_rng(1)
    root = np.column_stack([dice.uniform(-5.5, 5.5, (count, 2)), np.zeros(count)])
    lean = np.column_stack([dice.normal(0.0, 0.3, (count, 2)), np.ones(count)])
    along = np.linspace(0.0, 1.5, 8)
    at = root[:, None] + along[None, :, None] * lean[:, None] + 0.1 * (along**2)[None, :, None] * lean[::-1][:, None]
    data.position_data.foreach_set("vector", at.astype(np.float32).ravel())
    radius = data.attributes.new("radius", "FLOAT", "POINT")
    radius.data.foreach_set("value", np.full(8 * count, 0.004, np.float32))
    linked("Hairs", data)


def nothing(scene: bpy.types.Scene, count: int) -> None:
    """The ground alone: the number is the picture's."""


def lens_surfaces(scene: bpy.types.Scene, count: int) -> None:
    """Surfaces of the exact lens: a triplet of seven surfaces behind flat windows, a pair of surfaces each."""
    windows = ["0.0 0.1 1.517/64.2 30 0.0 0", "0.0 0.1 air 30 0.0 0"] * ((count - len(TRIPLET)) // 2)
    header = ("# name: windows before a triplet", "#radius thickness glass diameter conic isstop")
    path = Path(bpy.app.tempdir) / f"windows-{count}.lens"
    path.write_text("\n".join([*header, *windows, *TRIPLET]) + "\n", encoding="utf-8")
    settings = scene.camera.data.petzval
    settings.model, settings.lens_file = "LENS", str(path)


class Kind(NamedTuple):
    """A number that grows: the things that it counts, its values, and how a scene of so many is built."""

    title: str
    values: tuple[int, ...]
    build: Callable[[bpy.types.Scene, int], None]
    #: The number is the samples' or the pixels' of the picture.
    of_picture: str = ""
    by_cycles: bool = True


KINDS = {
    "samples": Kind("samples a pixel", (1, 10, 100, 1000, 10_000), nothing, "samples"),
    "pixels": Kind("pixels of the picture", (1000, 10_000, 100_000, 1_000_000, 10_000_000), nothing, "pixels"),
    "triangles": Kind("triangles of one mesh", (1000, 10_000, 100_000, 1_000_000, 10_000_000), triangles),
    "objects": Kind("objects, each with its own mesh", (1, 10, 100, 1000, 10_000), objects),
    "instances": Kind("instances of a mesh", (100, 1000, 10_000, 100_000, 1_000_000), instances),
    "hairs": Kind("hairs of eight points", (10, 100, 1000, 10_000, 100_000), hairs),
    "materials": Kind("materials with a noise", (1, 10, 100, 1000, 10_000), materials),
    "textures": Kind("images of 256 x 256 pixels", (1, 10, 100, 1000), textures),
    "texture-pixels": Kind("pixels of one image", (1000, 10_000, 100_000, 1_000_000, 10_000_000), texture_pixels),
    "lamps": Kind("point lights", (1, 10, 100, 1000, 10_000), lamps),
    "glowing-triangles": Kind("triangles that shine", (10, 100, 1000, 10_000, 100_000), glowing_triangles),
    "lens-surfaces": Kind("surfaces of the exact lens", (9, 17, 33, 65, 129), lens_surfaces, by_cycles=False),
}
