# SPDX-License-Identifier: GPL-3.0-or-later
"""Point clouds, as geometry nodes make them: each point is a ball with a radius of its own."""

from __future__ import annotations

import bpy
import numpy as np

from . import scene
from .studio import BLUE, CREAM, GOLD, RED, WHITE, Tree, ball, cube, empty_studio, lamp, material, plain, put


def holder_of(places: np.ndarray, radii: np.ndarray, name: str = "Points") -> bpy.types.Object:
    """A mesh of loose vertices, each with a size, a colour and a number; not yet points."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(map(float, place)) for place in places], [], [])
    mesh.attributes.new("size", "FLOAT", "POINT").data.foreach_set("value", np.asarray(radii, np.float32))
    dice = np.random.default_rng(len(places))
    colours = np.ones((len(places), 4), np.float32)
    colours[:, :3] = 0.15 + 0.75 * dice.random((len(places), 3))
    mesh.attributes.new("paint", "FLOAT_COLOR", "POINT").data.foreach_set("color", colours.ravel())
    mesh.attributes.new("warmth", "FLOAT", "POINT").data.foreach_set(
        "value", dice.random(len(places)).astype(np.float32)
    )
    return bpy.data.objects.new(name, mesh)


def nodes_on(holder: bpy.types.Object, build) -> bpy.types.Object:
    """Gives it geometry nodes; `build` has the tree and the geometry, and gives the new one."""
    tree = bpy.data.node_groups.new("Nodes", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    tree.links.new(
        build(tree, tree.nodes.new("NodeGroupInput").outputs[0]), tree.nodes.new("NodeGroupOutput").inputs[0]
    )
    holder.modifiers.new("Nodes", "NODES").node_group = tree
    return holder


def shown(tree, geometry, surface):
    """With a material."""
    node = tree.nodes.new("GeometryNodeSetMaterial")
    node.inputs["Material"].default_value = surface
    tree.links.new(geometry, node.inputs["Geometry"])
    return node.outputs[0]


def _as_points(surface):
    def build(tree, geometry):
        size = tree.nodes.new("GeometryNodeInputNamedAttribute")
        size.inputs["Name"].default_value = "size"
        made = tree.nodes.new("GeometryNodeMeshToPoints")
        tree.links.new(geometry, made.inputs["Mesh"])
        tree.links.new(size.outputs["Attribute"], made.inputs["Radius"])
        return shown(tree, made.outputs[0], surface)

    return build


def cloud(count: int, radius: float, surface, location=(0.0, 0.0, 0.9), spread: float = 1.0, seed: int = 1, **more):
    """So many points in a ball of unit radius, of radii from a third to all of this one."""
    dice = np.random.default_rng(seed)
    places = dice.normal(size=(count, 3))
    places *= spread * (dice.random((count, 1)) ** (1 / 3)) / np.linalg.norm(places, axis=1, keepdims=True)
    radii = radius * (1.0 / 3.0 + 2.0 / 3.0 * dice.random(count))
    return put(nodes_on(holder_of(places, radii), _as_points(surface)), location, **more)


def _painted(t: Tree) -> None:
    t.shows(t.principled(Base_Color=t.node("Attribute", {"attribute_name": "paint"}).outputs[0], Roughness=0.5))


@scene("Points: a radius and a colour of their own, and gloss")
def points_coloured():
    empty_studio()
    cloud(300, 0.14, material(_painted), (-1.2, 0.0, 0.95), 0.9)
    cloud(12, 0.5, plain(CREAM, Roughness=0.4, Metallic=1.0), (1.3, 0.2, 0.8), 0.8, seed=3)
    cube(plain(BLUE), (0.4, 1.6, 0.6), 1.0)


@scene("What Point Info and coordinates tell")
def points_info():
    empty_studio()

    def own(t: Tree) -> None:
        info = t.node("PointInfo")
        size = t.math("MULTIPLY", info.outputs["Radius"], 3.0)
        t.shows(t.diffuse(t.node("CombineColor", Red=info.outputs["Random"], Green=size, Blue=0.2).outputs[0]))

    def placed(t: Tree) -> None:
        info = t.node("PointInfo")
        near = t.node("VectorMath", {"operation": "MULTIPLY_ADD"}, _0=info.outputs["Position"], _1=(0.3, 0.3, 0.4), _2=(0.4, 0.4, 0.1))  # fmt: skip
        t.shows(t.diffuse(near.outputs[0]))

    def where(t: Tree) -> None:
        normal = t.node("VectorMath", {"operation": "MULTIPLY_ADD"}, _0=t.coordinates("Normal"), _1=(0.3, 0.3, 0.3), _2=(0.5, 0.5, 0.5))  # fmt: skip
        heat = t.node("Attribute", {"attribute_name": "warmth"}).outputs["Fac"]
        waves = t.node("TexWave", Vector=t.coordinates("Generated"), Scale=2.0).outputs[0]
        t.shows(t.diffuse(t.mixed_colour(heat, normal.outputs[0], waves)))

    for i, build in enumerate((own, placed, where)):
        stretched = (0.7, 0.7, 0.7) if i < 2 else (0.7, 0.6, 0.9)
        cloud(
            60, 0.3, material(build), (1.9 * i - 1.9, 0.0, 0.8), 0.9, seed=4 + i, rotation=(20, 10, 30), scale=stretched
        )


@scene("Points that shine, are seen through, and let light in")
def points_seen_through():
    empty_studio()
    kinds = (
        lambda t: t.shows(t.node("Emission", Color=GOLD, Strength=3.0).outputs[0]),
        lambda t: t.shows(t.mix(0.5, t.node("BsdfTransparent").outputs[0], t.diffuse(BLUE))),
        lambda t: t.shows(t.node("BsdfTranslucent", Color=CREAM).outputs[0]),
        lambda t: t.shows(t.node("BsdfGlass", Color=WHITE, Roughness=0.3).outputs[0]),
    )
    for i, build in enumerate(kinds):
        cloud(10, 0.35, material(build), (1.5 * i - 2.25, 0.2 * i, 0.7), 0.6, seed=11 + i)


@scene("Instances of points: turned, mirrored, stretched; and points in a volume")
def points_instanced():
    empty_studio()
    source = cloud(40, 0.25, material(_painted), (0.0, 0.0, -5.0), 0.8)
    holder = put(bpy.data.objects.new("Planted", bpy.data.meshes.new("Planted")), (-1.0, 0.0, 0.5))
    holder.data.from_pydata([(-1, 0, 0), (0.2, 0.4, 0.2), (1.0, -0.6, 0.0)], [], [])

    def planted(tree, geometry):
        from_object = tree.nodes.new("GeometryNodeObjectInfo")
        from_object.inputs["Object"].default_value = source
        from_object.inputs["As Instance"].default_value = True
        place = tree.nodes.new("GeometryNodeInstanceOnPoints")
        place.inputs["Scale"].default_value = (0.5, -0.4, 0.7)
        place.inputs["Rotation"].default_value = (0.3, 0.2, 0.9)
        tree.links.new(geometry, place.inputs["Points"])
        tree.links.new(from_object.outputs["Geometry"], place.inputs["Instance"])
        return place.outputs[0]

    nodes_on(holder, planted)
    inside = put(bpy.data.objects.new("Inside", bpy.data.meshes.new("Inside")), (1.5, 0.3, 0.8))

    def spread(tree, _):
        room = tree.nodes.new("GeometryNodeVolumeCube")
        room.inputs["Min"].default_value, room.inputs["Max"].default_value = (-0.7,) * 3, (0.7,) * 3
        thrown = tree.nodes.new("GeometryNodeDistributePointsInVolume")
        thrown.inputs["Density"].default_value = 40.0
        size = tree.nodes.new("GeometryNodeSetPointRadius")
        size.inputs["Radius"].default_value = 0.09
        tree.links.new(room.outputs[0], thrown.inputs["Volume"])
        tree.links.new(thrown.outputs[0], size.inputs["Points"])
        return shown(tree, size.outputs[0], plain(RED))

    nodes_on(inside, spread)


@scene("Many points from near and far, under a small lamp")
def points_dust():
    empty_studio(strength=0.1, lit=False)
    lamp("POINT", 250.0, (2.5, -3.0, 3.5), shadow_soft_size=0.15)
    ball(plain(CREAM), (0.0, 0.6, 0.8), 0.8)
    cloud(8000, 0.012, plain(GOLD), (0.0, 0.0, 1.0), 1.6, seed=21)
    cloud(3, 0.12, plain(RED), (0.0, -4.6, 2.0), 0.5, seed=22)
