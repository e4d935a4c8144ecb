# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the parity scenes are built: a floor, a wall, soft light, a camera; and few words for things and nodes."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np

from support import node_tree
from support.scenes import with_nodes

RED, GREEN, BLUE = (0.7, 0.12, 0.08, 1.0), (0.15, 0.5, 0.2, 1.0), (0.1, 0.2, 0.7, 1.0)
GOLD, CREAM, DARK = (0.9, 0.6, 0.2, 1.0), (0.8, 0.75, 0.6, 1.0), (0.05, 0.05, 0.06, 1.0)
WHITE, BLACK = (1.0, 1.0, 1.0, 1.0), (0.0, 0.0, 0.0, 1.0)


class Tree(node_tree.Tree):
    """With this studio's colours for shaders."""

    def mixed_colour(self, share, first, second, blend="MIX"):
        settings = {"data_type": "RGBA", "blend_type": blend}
        return self.node("Mix", settings, Factor=share, _6=first, _7=second).outputs[2]

    def diffuse(self, colour=CREAM, **inputs):
        return self.node("BsdfDiffuse", Color=colour, **inputs).outputs[0]

    def glossy(self, colour=WHITE, roughness=0.2, distribution="GGX", **inputs):
        return self.node(
            "BsdfAnisotropic", {"distribution": distribution}, Color=colour, Roughness=roughness, **inputs
        ).outputs[0]

    def principled(self, **inputs):
        return self.node("BsdfPrincipled", **inputs).outputs[0]


def material(build: Callable[[Tree], None], name: str = "Material") -> bpy.types.Material:
    """A material whose nodes `build` makes."""
    made = bpy.data.materials.new(name)
    tree = with_nodes(made)
    build(Tree(tree, tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"]))
    return made


def plain(colour=CREAM, **inputs) -> bpy.types.Material:
    """A Principled surface, not shiny unless said so."""
    inputs = {"Roughness": 0.6, **inputs}
    return material(lambda t: t.shows(t.principled(Base_Color=colour, **inputs)))


def world(build: Callable[[Tree], None]) -> bpy.types.World:
    """The scene's world, with the nodes that `build` makes."""
    made = bpy.context.scene.world = bpy.data.worlds.new("World")
    tree = with_nodes(made)
    build(Tree(tree, tree.nodes.new("ShaderNodeOutputWorld").inputs["Surface"]))
    return made


def grey_world(strength: float, colour=WHITE) -> None:
    world(lambda t: t.shows(t.node("Background", Color=colour, Strength=strength).outputs[0]))


def lamp(kind: str, energy: float, location, rotation=(0.0, 0.0, 0.0), colour=(1.0, 1.0, 1.0), **settings):
    """A light object; `rotation` in degrees."""
    data = bpy.data.lights.new(kind.title(), kind)
    data.energy, data.color = energy, colour
    for name, value in settings.items():
        setattr(data, name, value)
    return put(bpy.data.objects.new(kind.title(), data), location, rotation)


def put(thing: bpy.types.Object, location=(0, 0, 0), rotation=(0, 0, 0), scale=1.0) -> bpy.types.Object:
    """Links an object into the scene; `rotation` in degrees."""
    thing.location = location
    thing.rotation_euler = np.radians(rotation)
    thing.scale = (scale,) * 3 if np.isscalar(scale) else scale
    if thing.name not in bpy.context.scene.collection.objects:
        bpy.context.scene.collection.objects.link(thing)
    return thing


def _made(surface, smooth: bool) -> bpy.types.Object:
    thing = bpy.context.object
    if smooth:
        bpy.ops.object.shade_smooth()
    if surface is not None:
        thing.data.materials.append(surface)
    return thing


def ball(surface, location=(0.0, 0.0, 1.0), radius: float = 1.0) -> bpy.types.Object:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=radius, location=location)
    return _made(surface, smooth=True)


def cube(surface, location=(0.0, 0.0, 0.75), size: float = 1.5, turn: float = 30.0) -> bpy.types.Object:
    bpy.ops.mesh.primitive_cube_add(size=size, location=location, rotation=(0.0, 0.0, np.radians(turn)))
    return _made(surface, smooth=False)


def monkey(surface, location=(0.0, 0.0, 1.0), size: float = 2.2, turn: float = 0.0, levels: int = 1):
    """Blender's own head, subdivided."""
    bpy.ops.mesh.primitive_monkey_add(size=size, location=location, rotation=(0.0, 0.0, np.radians(turn)))
    thing = _made(surface, smooth=True)
    thing.modifiers.new("Subdivision", "SUBSURF").render_levels = levels
    return thing


def plane(surface, location=(0, 0, 0), size: float = 2.0, rotation=(0, 0, 0)) -> bpy.types.Object:
    bpy.ops.mesh.primitive_plane_add(size=size, location=location, rotation=np.radians(rotation))
    return _made(surface, smooth=False)


def test_card(size: int = 64) -> np.ndarray:
    """A picture that shows which way is up, and what is sharp: colours over squares, a dot in one corner."""
    y, x = np.mgrid[0:size, 0:size] / size
    squares = ((x * 8).astype(int) + (y * 8).astype(int)) % 2
    pixels = np.stack([0.2 + 0.7 * x, 0.2 + 0.7 * y, 0.25 + 0.5 * squares, np.ones_like(x)], 2)
    pixels[(x - 0.15) ** 2 + (y - 0.85) ** 2 < 0.01] = (1.0, 0.1, 0.1, 1.0)
    return pixels


def empty_studio(strength: float = 0.35, lit: bool = True, floor: bpy.types.Material | None = None) -> None:
    """A floor, a wall, a camera; a grey world, and a large lamp if it is to be lit."""
    scene = bpy.context.scene
    grey_world(strength)
    plane(floor or plain((0.45, 0.45, 0.47, 1.0)), size=14.0)
    plane(plain((0.5, 0.47, 0.42, 1.0)), (0, 4, 3), 14.0, (90, 0, 0))
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.lens = 50
    scene.camera = put(camera, (0.0, -6.5, 2.3), (77.5, 0.0, 0.0))
    if lit:
        lamp("AREA", 350.0, (-3.0, -2.5, 4.5), (40, -35, 0), (1.0, 0.93, 0.85), shape="RECTANGLE", size=2.5, size_y=1.5)
