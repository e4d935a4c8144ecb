# SPDX-License-Identifier: GPL-3.0-or-later
"""Three places as .blend files, made as scenes by others are: a meadow under a sun, a room lit by its window, and a street at
night. Imported where bpy is. Metres, z up; all numbers are drawn from fixed seeds.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import bpy
import numpy as np

from . import scene

#: Blades of a cluster of grass, clusters in the meadow, and leaves of a tree.
BLADES, CLUSTERS, LEAVES = 30, 4000, 1500
#: The number of lamps of the street at night.
LAMPS = 70


def meadow() -> None:
    """Hills with 120,000 blades of grass and two trees whose leaves are cut out by their material, all by instances; sun and sky."""
    dice = np.random.default_rng(1)
    ground = _principled("soil", (0.16, 0.11, 0.07), 0.9, bump=0.3)
    _mesh("hills", *_hills(80, 30.0), ground, smooth=True)
    grass = _leaf("grass", (0.16, 0.30, 0.06), cutout=False)
    for i in range(3):
        cluster = _mesh(f"grass{i}", *_grass(np.random.default_rng(10 + i)), grass, smooth=True)
        places = dice.uniform((-14.0, -2.0), (14.0, 26.0), (CLUSTERS // 3, 2))
        _scatter(f"meadow{i}", np.c_[places, _height(*places.T)], cluster)
    bark, leaf = _principled("bark", (0.12, 0.08, 0.05), 0.8, bump=0.6), _leaf("leaf", (0.10, 0.24, 0.05), cutout=True)
    card = [(-0.12, 0.0, 0.0), (0.12, 0.0, 0.0), (0.12, 0.34, 0.06), (-0.12, 0.34, 0.06)]
    for i, (x, y) in enumerate([(-3.2, 9.0), (4.5, 14.0)]):
        base = np.array([x, y, float(_height(np.array(x), np.array(y)))])
        shape, triangles = scene.bumpy_ball(24, 5 + i)
        _mesh(f"trunk{i}", shape * (0.28, 0.28, 2.2) + base + (0.0, 0.0, 1.6), triangles, bark, smooth=True)
        one = _mesh(f"leaf{i}", np.array(card), np.array([(0, 1, 2), (0, 2, 3)]), leaf, smooth=False)
        one.data.uv_layers.new(name="UVMap").data.foreach_set("uv", [0, 0, 1, 0, 1, 1, 0, 0, 1, 1, 0, 1])
        directions = dice.normal(size=(LEAVES, 3))
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        crown = base + (0.0, 0.0, 4.4) + directions * (2.1, 2.1, 1.6) * dice.uniform(0.5, 1.0, (LEAVES, 1))
        _scatter(f"crown{i}", crown, one, directions)
    _sun(3.0, math.radians(50.0), math.radians(140.0))
    _world(_sky, 0.5)
    _camera((0.0, -3.0, 1.7 + float(_height(np.array(0.0), np.array(-3.0)))), 1.52, 28.0)


def room() -> None:
    """A room whose one window brings in sun and sky: painted walls, a wooden floor, a table, bottles of glass, a mirror."""
    wall, floor = _principled("wall", (0.72, 0.70, 0.66), 0.7, bump=0.05), _wood()
    wide, deep, high = 5.0, 6.0, 2.8
    _box("floor", (0.0, 0.5 * deep, -0.05), (wide, deep, 0.1), floor)
    _box("ceiling", (0.0, 0.5 * deep, high + 0.05), (wide, deep, 0.1), wall)
    _box("left", (-0.5 * wide - 0.05, 0.5 * deep, 0.5 * high), (0.1, deep, high), wall)
    _box("back", (0.0, deep + 0.05, 0.5 * high), (wide, 0.1, high), wall)
    _box("front", (0.0, -0.05, 0.5 * high), (wide, 0.1, high), wall)
    # The right wall about the window.
    for name, y, length, z, height in (("near", 1.0, 2.0, 1.4, 2.8), ("far", 5.0, 2.0, 1.4, 2.8),
                                       ("below", 3.0, 2.0, 0.45, 0.9), ("above", 3.0, 2.0, 2.55, 0.5)):  # fmt: skip
        _box(f"right {name}", (0.5 * wide + 0.05, y, z), (0.1, length, height), wall)
    table = _principled("lacquer", (0.30, 0.06, 0.04), 0.15, coat=0.6)
    _box("table", (0.2, 3.4, 0.72), (1.6, 0.9, 0.05), table)
    for i in range(4):
        _box(f"leg{i}", (0.2 + (0.7 if i % 2 else -0.7), 3.4 + (0.35 if i > 1 else -0.35), 0.35), (0.06, 0.06, 0.7), table)  # fmt: skip
    made = [
        _glass("glass"), _principled("brass", (0.85, 0.62, 0.25), 0.2, metallic=1.0),
        _principled("clay", (0.55, 0.28, 0.17), 0.6, bump=0.4), _principled("cloth", (0.10, 0.16, 0.35), 0.9, sheen=0.8),
    ]  # fmt: skip
    for i in range(8):
        shape, triangles = scene.bumpy_ball(40, 20 + i) if i % 2 else scene.bumpy_ring(48, float(i))
        centre = (-0.45 + 0.18 * i, 3.25 + 0.1 * (i % 4), 0.85)
        _mesh(f"thing{i}", shape * 0.09 + centre, triangles, made[i % 4], smooth=True)
    _box("mirror", (-0.5 * wide + 0.02, 3.4, 1.5), (0.02, 1.2, 1.0), _principled("mirror", (0.9, 0.9, 0.9), 0.02, metallic=1.0))  # fmt: skip
    _box("sofa", (-1.5, 4.8, 0.4), (1.6, 0.8, 0.8), made[3])
    _sun(4.0, math.radians(58.0), math.radians(98.0))
    _world(_sky, 1.0)
    _camera((-0.6, 0.4, 1.5), 1.50, 22.0)


def night() -> None:
    """A wet street between houses with lit windows, seventy lamps, and fog in all space."""
    dice = np.random.default_rng(3)
    street = _principled("asphalt", (0.05, 0.05, 0.055), 0.25, bump=0.25)
    _mesh("street", np.array([(-30.0, -5.0, 0.0), (30.0, -5.0, 0.0), (30.0, 80.0, 0.0), (-30.0, 80.0, 0.0)]),
          np.array([(0, 1, 2), (0, 2, 3)]), street, smooth=False)  # fmt: skip
    facade = _facade()
    for i in range(16):
        side, row = (-1.0 if i % 2 else 1.0), i // 2
        height = dice.uniform(7.0, 16.0)
        _box(f"house{i}", (side * dice.uniform(9.0, 10.5), 3.0 + 9.0 * row, 0.5 * height), (7.0, 8.0, height), facade)
    for i in range(LAMPS):
        data = bpy.data.lights.new(f"lamp{i}", "POINT")
        data.color = (1.0, dice.uniform(0.55, 0.9), dice.uniform(0.25, 0.8))
        data.energy, data.shadow_soft_size = dice.uniform(20.0, 90.0), 0.06
        made = bpy.data.objects.new(f"lamp{i}", data)
        made.location = (dice.choice((-1.0, 1.0)) * dice.uniform(2.5, 4.8), dice.uniform(2.0, 70.0), dice.uniform(2.2, 4.5))  # fmt: skip
        bpy.context.scene.collection.objects.link(made)
    steel = _principled("steel", (0.4, 0.4, 0.42), 0.3, metallic=1.0)
    for i in range(10):
        shape, triangles = scene.bumpy_ball(30, 40 + i)
        centre = (dice.uniform(-2.5, 2.5), 5.0 + 4.0 * i, 0.5)
        _mesh(f"thing{i}", shape * 0.5 + centre, triangles, steel, smooth=True)
    _world(_fog, 0.012)
    _camera((0.0, -2.0, 1.8), 1.55, 26.0)


#: The functions that make the places, by name.
MAKERS: dict[str, Callable[[], None]] = {"meadow": meadow, "room": room, "night": night}


def _height(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return 0.5 * np.sin(0.31 * x + 0.4) * np.cos(0.23 * y) + 0.2 * np.sin(0.9 * y + 0.5 * x)


def _hills(n: int, half: float) -> tuple[np.ndarray, np.ndarray]:
    x, y = (axis.ravel() for axis in np.meshgrid(np.linspace(-half, half, n), np.linspace(-half / 2, half * 1.5, n)))
    at = np.arange(n * n).reshape(n, n)
    a, b, c, d = (corner.ravel() for corner in (at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]))
    return np.c_[x, y, _height(x, y)], np.concatenate([np.c_[a, b, c], np.c_[a, c, d]])


def _grass(dice: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Blades of four bends each, about the origin."""
    vertices, triangles = [], []
    for i in range(BLADES):
        root, turn = dice.uniform(-0.25, 0.25, 2), dice.uniform(0.0, 2.0 * math.pi)
        tall, lean = dice.uniform(0.12, 0.35), dice.uniform(0.02, 0.14)
        for k in range(5):
            part = k / 4.0
            away, half = lean * part * part, 0.006 * (1.0 - part) + 0.0005
            for side in (-1.0, 1.0):
                along = np.array([math.cos(turn), math.sin(turn)]) * away
                across = np.array([-math.sin(turn), math.cos(turn)]) * half * side
                vertices.append((*(root + along + across), tall * part))
        for k in range(4):
            a = 10 * i + 2 * k
            triangles += [(a, a + 1, a + 3), (a, a + 3, a + 2)]
    return np.array(vertices), np.array(triangles)


def _mesh(
    name: str, vertices: np.ndarray, triangles: np.ndarray, material: bpy.types.Material, *, smooth: bool
) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(np.asarray(vertices, float).tolist(), [], np.asarray(triangles).tolist())
    mesh.shade_smooth() if smooth else mesh.shade_flat()
    mesh.materials.append(material)
    made = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(made)
    return made


def _box(name: str, centre: tuple, size: tuple, material: bpy.types.Material) -> None:
    corners = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * size + centre
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(corners.tolist(), [], sides)
    mesh.materials.append(material)
    bpy.context.scene.collection.objects.link(bpy.data.objects.new(name, mesh))


def _scatter(name: str, places: np.ndarray, one: bpy.types.Object, normals: np.ndarray | None = None) -> None:
    """Instances of an object at places, turned by normals where there are any."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(np.asarray(places, float).tolist(), [], [])
    if normals is not None:
        mesh.normals_split_custom_set_from_vertices(normals.tolist())
    holder = bpy.data.objects.new(name, mesh)
    holder.instance_type, holder.use_instance_vertices_rotation = "VERTS", normals is not None
    bpy.context.scene.collection.objects.link(holder)
    one.parent = holder


def emptied_tree(holder: Any) -> Any:
    """The node tree of a material or a world, without nodes."""
    if holder.node_tree is None or bpy.app.version < (5, 0, 0):
        holder.use_nodes = True
    holder.node_tree.nodes.clear()
    return holder.node_tree


def _made(name: str) -> tuple[bpy.types.Material, Any, Any]:
    """A material, its tree, and the tree's output."""
    made = bpy.data.materials.new(name)
    tree = emptied_tree(made)
    return made, tree, tree.nodes.new("ShaderNodeOutputMaterial")


def _principled(
    name: str, rgb: tuple, roughness: float, *, metallic: float = 0.0, coat: float = 0.0, sheen: float = 0.0, bump: float = 0.0
) -> bpy.types.Material:  # fmt: skip
    made, tree, output = _made(name)
    node = tree.nodes.new("ShaderNodeBsdfPrincipled")
    values = {"Base Color": (*rgb, 1.0), "Roughness": roughness, "Metallic": metallic}
    values |= {"Coat Weight": coat, "Sheen Weight": sheen}
    for socket, value in values.items():
        node.inputs[socket].default_value = value
    if bump:
        noise, bumps = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes.new("ShaderNodeBump")
        noise.inputs["Scale"].default_value, noise.inputs["Detail"].default_value = 6.0, 4.0
        bumps.inputs["Strength"].default_value, bumps.inputs["Distance"].default_value = bump, 0.05
        where = tree.nodes.new("ShaderNodeTexCoord")
        tree.links.new(where.outputs["Object"], noise.inputs["Vector"])
        tree.links.new(noise.outputs[0], bumps.inputs["Height"])
        tree.links.new(bumps.outputs[0], node.inputs["Normal"])
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    return made


def _glass(name: str) -> bpy.types.Material:
    made, tree, output = _made(name)
    node = tree.nodes.new("ShaderNodeBsdfGlass")
    node.inputs["IOR"].default_value, node.inputs["Roughness"].default_value = 1.5, 0.0
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    return made


def _leaf(name: str, rgb: tuple, *, cutout: bool) -> bpy.types.Material:
    """Diffuse and translucent in halves; with a cutout, transparent outside of an oval of its UV map."""
    made, tree, output = _made(name)
    nodes, link = tree.nodes, tree.links.new
    front, through, both = (nodes.new(f"ShaderNode{kind}") for kind in ("BsdfDiffuse", "BsdfTranslucent", "MixShader"))
    for node in (front, through):
        node.inputs["Color"].default_value = (*rgb, 1.0)
    both.inputs[0].default_value = 0.45
    link(front.outputs[0], both.inputs[1])
    link(through.outputs[0], both.inputs[2])
    if not cutout:
        link(both.outputs[0], output.inputs["Surface"])
        return made
    where, middle, size, inside, clear, cut = (
        nodes.new(f"ShaderNode{kind}")
        for kind in ("TexCoord", "VectorMath", "VectorMath", "Math", "BsdfTransparent", "MixShader")
    )
    middle.operation, size.operation, inside.operation = "SUBTRACT", "LENGTH", "LESS_THAN"
    middle.inputs[1].default_value, inside.inputs[1].default_value = (0.5, 0.5, 0.0), 0.46
    link(where.outputs["UV"], middle.inputs[0])
    link(middle.outputs[0], size.inputs[0])
    link(size.outputs["Value"], inside.inputs[0])
    link(inside.outputs[0], cut.inputs[0])
    link(clear.outputs[0], cut.inputs[1])
    link(both.outputs[0], cut.inputs[2])
    link(cut.outputs[0], output.inputs["Surface"])
    return made


def _wood() -> bpy.types.Material:
    """Planks of a wave texture, glossy where it is dark."""
    made, tree, output = _made("wood")
    nodes, link = tree.nodes, tree.links.new
    where, wave, ramp, node = (
        nodes.new(f"ShaderNode{kind}") for kind in ("TexCoord", "TexWave", "ValToRGB", "BsdfPrincipled")
    )
    wave.inputs["Scale"].default_value, wave.inputs["Distortion"].default_value = 1.5, 6.0
    ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (0.14, 0.07, 0.03, 1.0), (0.42, 0.24, 0.11, 1.0)  # fmt: skip
    link(where.outputs["Object"], wave.inputs["Vector"])
    link(wave.outputs["Fac"], ramp.inputs[0])
    link(ramp.outputs["Color"], node.inputs["Base Color"])
    link(wave.outputs["Fac"], node.inputs["Roughness"])
    link(node.outputs[0], output.inputs["Surface"])
    return made


def _facade() -> bpy.types.Material:
    """Bricks as large as windows, a third of which shine."""
    made, tree, output = _made("facade")
    nodes, link = tree.nodes, tree.links.new
    where, brick, lit, node = (
        nodes.new(f"ShaderNode{kind}") for kind in ("TexCoord", "TexBrick", "Math", "BsdfPrincipled")
    )
    brick.offset, brick.inputs["Scale"].default_value = 0.0, 1.0
    brick.inputs["Color1"].default_value, brick.inputs["Color2"].default_value = (0.0, 0.0, 0.0, 1.0), (1.0, 1.0, 1.0, 1.0)  # fmt: skip
    brick.inputs["Mortar"].default_value = (0.0, 0.0, 0.0, 1.0)
    brick.inputs["Mortar Size"].default_value = 0.35
    brick.inputs["Brick Width"].default_value, brick.inputs["Row Height"].default_value = 1.6, 1.7
    lit.operation, lit.inputs[1].default_value = "GREATER_THAN", 0.66
    parts, along, place = (nodes.new(f"ShaderNode{kind}") for kind in ("SeparateXYZ", "Math", "CombineXYZ"))
    node.inputs["Base Color"].default_value, node.inputs["Roughness"].default_value = (0.2, 0.17, 0.15, 1.0), 0.8
    node.inputs["Emission Color"].default_value = (1.0, 0.75, 0.4, 1.0)
    # Along the wall, whichever way it runs, and up.
    link(where.outputs["Object"], parts.inputs[0])
    link(parts.outputs["X"], along.inputs[0])
    link(parts.outputs["Y"], along.inputs[1])
    link(along.outputs[0], place.inputs["X"])
    link(parts.outputs["Z"], place.inputs["Y"])
    link(place.outputs[0], brick.inputs["Vector"])
    link(brick.outputs["Color"], lit.inputs[0])
    link(lit.outputs[0], node.inputs["Emission Strength"])
    link(node.outputs[0], output.inputs["Surface"])
    return made


def _world(of: Callable[[Any, Any], None], strength: float) -> None:
    made = bpy.data.worlds.new("world")
    tree = emptied_tree(made)
    of(tree, strength)
    bpy.context.scene.world = made


def _sky(tree: Any, strength: float) -> None:
    sky, background, output = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexSky", "Background", "OutputWorld"))
    sky.sky_type, sky.turbidity = "HOSEK_WILKIE", 3.0
    sky.sun_direction = (0.5, 0.4, 0.76)
    background.inputs["Strength"].default_value = strength
    tree.links.new(sky.outputs[0], background.inputs["Color"])
    tree.links.new(background.outputs[0], output.inputs["Surface"])


def _fog(tree: Any, density: float) -> None:
    background, scatter, output = (
        tree.nodes.new(f"ShaderNode{kind}") for kind in ("Background", "VolumeScatter", "OutputWorld")
    )
    background.inputs["Color"].default_value = (0.01, 0.012, 0.02, 1.0)
    scatter.inputs["Density"].default_value, scatter.inputs["Anisotropy"].default_value = density, 0.4
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    tree.links.new(scatter.outputs[0], output.inputs["Volume"])


def _sun(strength: float, from_zenith_rad: float, turn_rad: float) -> None:
    data = bpy.data.lights.new("sun", "SUN")
    data.energy, data.angle = strength, math.radians(0.53)
    made = bpy.data.objects.new("sun", data)
    made.rotation_euler = (from_zenith_rad, 0.0, turn_rad)
    bpy.context.scene.collection.objects.link(made)


def _camera(eye: tuple, tilt_rad: float, focal_length_mm: float) -> None:
    data = bpy.data.cameras.new("camera")
    data.lens, data.clip_start, data.clip_end = focal_length_mm, 0.01, 1000.0
    made = bpy.data.objects.new("camera", data)
    made.location, made.rotation_euler = eye, (tilt_rad, 0.0, 0.0)
    bpy.context.scene.collection.objects.link(made)
    bpy.context.scene.camera = made
