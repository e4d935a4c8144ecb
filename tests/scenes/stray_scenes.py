# SPDX-License-Identifier: GPL-3.0-or-later
"""Two scenes full of stray light: a street at night, and the sun between trees. Made of nothing but numbers; CC0.

python tests/scenes/stray_scenes.py night street.blend
python tests/scenes/stray_scenes.py sun trees.blend
"""

from __future__ import annotations

import math
import random
import sys

import bpy
import numpy as np


def _material(name: str, colour, roughness: float = 0.8, emission=None, strength: float = 0.0, metallic: float = 0.0):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    shader = made.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*colour, 1.0)
    shader.inputs["Roughness"].default_value = roughness
    shader.inputs["Metallic"].default_value = metallic
    if emission is not None:
        shader.inputs["Emission Color"].default_value = (*emission, 1.0)
        shader.inputs["Emission Strength"].default_value = strength
    return made


def _mesh(name: str, points, faces, materials, indices=None, *, smooth: bool = False):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(p) for p in points], [], [tuple(f) for f in faces])
    for one in materials:
        mesh.materials.append(one)
    if indices is not None:
        mesh.polygons.foreach_set("material_index", indices)
    if smooth:
        mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    mesh.update()
    made = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(made)
    return made


class _Boxes:
    """Many boxes in one mesh."""

    CORNERS = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))

    def __init__(self) -> None:
        self.points, self.faces, self.indices = [], [], []

    def add(self, low, high, material: int) -> None:
        first = len(self.points)
        low, high = np.array(low, float), np.array(high, float)
        self.points += list(low + self.CORNERS * (high - low))
        self.faces += [tuple(first + i for i in face) for face in self.FACES]
        self.indices += [material] * 6

    def done(self, name: str, materials):
        return _mesh(name, self.points, self.faces, materials, self.indices)


def _ball(name: str, at, radius: float, material, rings: int = 12):
    points, faces, around = [], [], 2 * rings
    for i in range(rings + 1):
        for j in range(around):
            a, b = math.pi * i / rings, 2.0 * math.pi * j / around
            points.append(
                (math.sin(a) * math.cos(b) * radius, math.sin(a) * math.sin(b) * radius, math.cos(a) * radius)
            )
    for i in range(rings):
        for j in range(around):
            k = (j + 1) % around
            faces.append((i * around + j, (i + 1) * around + j, (i + 1) * around + k, i * around + k))
    made = _mesh(name, points, faces, [material], smooth=True)
    made.location = at
    return made


def _camera(at, look_at, lens_mm: float):
    from mathutils import Vector

    data = bpy.data.cameras.new("Camera")
    data.lens, data.sensor_width = lens_mm, 36.0
    made = bpy.data.objects.new("Camera", data)
    made.location = at
    made.rotation_euler = (Vector(look_at) - Vector(at)).to_track_quat("-Z", "Y").to_euler()
    scene = bpy.context.scene
    scene.collection.objects.link(made)
    scene.camera = made
    return made


def _world(colour, strength: float):
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    background = scene.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (*colour, 1.0)
    background.inputs["Strength"].default_value = strength
    return scene.world.node_tree


def _wet_asphalt():
    """Puddles between rough stones: roughness and colour by noise."""
    made = _material("Asphalt", (0.03, 0.03, 0.033), 0.4)
    nodes, links = made.node_tree.nodes, made.node_tree.links
    shader = nodes["Principled BSDF"]
    place = nodes.new("ShaderNodeNewGeometry")
    wide, fine = nodes.new("ShaderNodeTexNoise"), nodes.new("ShaderNodeTexNoise")
    wide.inputs["Scale"].default_value, fine.inputs["Scale"].default_value = 0.45, 40.0
    ramp = nodes.new("ShaderNodeMapRange")
    ramp.inputs["From Min"].default_value, ramp.inputs["From Max"].default_value = 0.42, 0.6
    ramp.inputs["To Min"].default_value, ramp.inputs["To Max"].default_value = 0.07, 0.5
    bump = nodes.new("ShaderNodeBump")
    bump.inputs["Strength"].default_value, bump.inputs["Distance"].default_value = 0.25, 0.01
    for noise in (wide, fine):
        links.new(place.outputs["Position"], noise.inputs["Vector"])
    links.new(wide.outputs[0], ramp.inputs["Value"])
    links.new(ramp.outputs["Result"], shader.inputs["Roughness"])
    links.new(fine.outputs[0], bump.inputs["Height"])
    links.new(bump.outputs["Normal"], shader.inputs["Normal"])
    return made


def night_street() -> None:
    """A wet street under lamps, lit windows, a car that comes and one that goes."""
    chance = random.Random(7)
    asphalt = _wet_asphalt()
    pavement = _material("Pavement", (0.16, 0.155, 0.15), 0.7)
    _mesh("Road", [(-4, -10, 0), (4, -10, 0), (4, 160, 0), (-4, 160, 0)], [(0, 1, 2, 3)], [asphalt])
    lines = _Boxes()
    for k in range(20):
        lines.add((-0.07, 2 + 8 * k, 0.001), (0.07, 5 + 8 * k, 0.004), 0)
    lines.done("Lines", [_material("Paint", (0.7, 0.7, 0.66), 0.5)])
    kerbs = _Boxes()
    for side in (-1, 1):
        low, high = sorted((side * 4.0, side * 7.0))
        kerbs.add((low, -10, -0.2), (high, 160, 0.14), 0)
    kerbs.done("Kerbs", [pavement])

    walls = [
        _material(f"Wall {i}", c, 0.85)
        for i, c in enumerate([(0.16, 0.1, 0.075), (0.15, 0.14, 0.125), (0.1, 0.105, 0.12)])
    ]
    frame, dark = _material("Frame", (0.5, 0.48, 0.45), 0.6), _material("Dark Pane", (0.02, 0.025, 0.03), 0.08)
    warm = _material("Warm Pane", (0.1, 0.08, 0.05), 0.3, (1.0, 0.62, 0.28), 1.6)
    cool = _material("Cool Pane", (0.08, 0.1, 0.12), 0.3, (0.75, 0.88, 1.0), 1.2)
    shop = _material("Shop", (0.1, 0.1, 0.1), 0.3, (1.0, 0.85, 0.6), 3.0)
    materials = [*walls, frame, dark, warm, cool, shop]
    houses = _Boxes()
    for side in (-1, 1):
        y = -6.0
        while y < 150.0:
            width, floors = chance.uniform(9.0, 15.0), chance.randint(3, 5)
            height, wall = 0.6 + 3.3 * floors + chance.uniform(0.5, 1.5), chance.randrange(3)
            near = side * 7.0
            low, high = sorted((near, near + side * 9.0))
            houses.add((low, y, 0.0), (high, y + width, height), wall)
            houses.add(
                (min(near, near - side * 0.25), y, height - 0.4),
                (max(near, near - side * 0.25), y + width, height),
                frame_index := 3,
            )
            count = int(width / 2.4)
            for floor in range(floors):
                for k in range(count):
                    middle = y + width * (k + 0.5) / count
                    z = 1.0 + 3.3 * floor
                    pane = chance.choices((4, 5, 6), (0.62, 0.28, 0.1))[0]
                    tall, half = 1.7, 0.55
                    if floor == 0:
                        pane, tall, half = (7 if chance.random() < 0.3 else 4), 2.0, 0.85
                    a, b = sorted((near, near - side * 0.06))
                    houses.add(
                        (a, middle - half - 0.12, z - 0.12), (b, middle + half + 0.12, z + tall + 0.12), frame_index
                    )
                    a, b = sorted((near - side * 0.05, near - side * 0.075))
                    houses.add((a, middle - half, z), (b, middle + half, z + tall), pane)
            y += width + (0.0 if chance.random() < 0.8 else 3.0)
    houses.done("Houses", materials)

    iron = _material("Iron", (0.03, 0.035, 0.03), 0.4, metallic=0.6)
    sodium = _material("Lamp", (0.0, 0.0, 0.0), 0.5, (1.0, 0.72, 0.42), 1300.0)
    posts = _Boxes()
    for k in range(9):
        for side in (-1, 1):
            y = 9.0 + 17.0 * k + (8.5 if side > 0 else 0.0)
            x = side * 4.6
            posts.add((x - 0.06, y - 0.06, 0.0), (x + 0.06, y + 0.06, 5.6), 0)
            arm = sorted((x, x - side * 1.3))
            posts.add((arm[0], y - 0.04, 5.52), (arm[1], y + 0.04, 5.6), 0)
            _ball(f"Lamp {k} {side}", (x - side * 1.3, y, 5.38), 0.11, sodium)
    posts.done("Posts", [iron])

    paint, glass = (
        _material("Car Paint", (0.25, 0.02, 0.02), 0.25, metallic=0.3),
        _material("Car Glass", (0.01, 0.01, 0.012), 0.05),
    )
    head = _material("Headlight", (0, 0, 0), 0.3, (1.0, 0.96, 0.9), 1500.0)
    tail = _material("Tail Light", (0, 0, 0), 0.3, (1.0, 0.03, 0.01), 60.0)
    tyre = _material("Tyre", (0.012, 0.012, 0.012), 0.8)
    for x, y, light, name in ((-1.9, 24.0, head, "Coming"), (1.9, 15.0, tail, "Going")):
        car = _Boxes()
        car.add((x - 0.88, y, 0.35), (x + 0.88, y + 4.3, 0.95), 0)
        car.add((x - 0.78, y + 0.9, 0.95), (x + 0.78, y + 3.4, 1.42), 1)
        car.add((x - 0.74, y + 1.2, 1.42), (x + 0.74, y + 3.1, 1.46), 0)
        for wheel in (y + 0.45, y + 3.2):
            for left in (x - 0.9, x + 0.68):
                car.add((left, wheel, 0.0), (left + 0.22, wheel + 0.62, 0.62), 2)
        car.done(name, [paint, glass, tyre])
        for lamp in (-0.62, 0.62):
            radius = 0.075 if light is head else 0.06
            _ball(f"{name} {lamp}", (x + lamp, y - 0.02, 0.68), radius, light)

    _world((0.008, 0.013, 0.03), 1.0)
    _camera((0.35, -2.0, 1.55), (-0.1, 30.0, 2.6), 35.0)


def sun_between_trees() -> None:
    """A low sun over meadows, trees before it."""
    chance = random.Random(3)
    size, side = 181, 240.0
    x, y = np.meshgrid(np.linspace(-side / 2, side / 2, size), np.linspace(-6.0, side - 6.0, size))
    z = (
        2.2 * np.sin(x / 31.0 + 0.6) * np.sin(y / 43.0)
        + 0.02 * np.maximum(y - 60.0, 0.0)
        + 0.06 * np.sin(x * 0.9) * np.sin(y * 0.7)
    )
    z -= 2.2 * np.sin(0.6) * np.sin(0.0)
    cell = np.arange(size * size).reshape(size, size)
    faces = np.stack([cell[:-1, :-1], cell[:-1, 1:], cell[1:, 1:], cell[1:, :-1]], -1).reshape(-1, 4)
    grass = _material("Meadow", (0.12, 0.2, 0.05), 0.9)
    nodes, links = grass.node_tree.nodes, grass.node_tree.links
    noise, ramp = nodes.new("ShaderNodeTexNoise"), nodes.new("ShaderNodeValToRGB")
    place = nodes.new("ShaderNodeNewGeometry")
    noise.inputs["Scale"].default_value = 0.35
    ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (0.05, 0.11, 0.02, 1), (0.16, 0.2, 0.045, 1)
    links.new(place.outputs["Position"], noise.inputs["Vector"])
    links.new(noise.outputs[0], ramp.inputs["Fac"])
    links.new(ramp.outputs["Color"], nodes["Principled BSDF"].inputs["Base Color"])
    _mesh("Meadow", np.stack([x, y, z], -1).reshape(-1, 3), faces.tolist(), [grass], smooth=True)

    def ground(px: float, py: float) -> float:
        i, j = int(round((py + 6.0) / side * (size - 1))), int(round((px + side / 2) / side * (size - 1)))
        return float(z[min(max(i, 0), size - 1), min(max(j, 0), size - 1)])

    bark, leaves = _material("Bark", (0.06, 0.04, 0.025), 0.9), _material("Leaves", (0.05, 0.11, 0.02), 0.7)

    def tree(px: float, py: float, height: float) -> None:
        base = ground(px, py) - 0.3
        points, faces = [], []

        def limb(a, b, r0: float, r1: float) -> None:
            a, b = np.array(a, float), np.array(b, float)
            along = (b - a) / np.linalg.norm(b - a)
            u = np.cross(along, (0.3, 0.5, 0.1))
            u /= np.linalg.norm(u)
            v = np.cross(along, u)
            first = len(points)
            for centre, r in ((a, r0), (b, r1)):
                points.extend(centre + r * (math.cos(t) * u + math.sin(t) * v) for t in np.arange(6) * math.tau / 6)
            faces.extend((first + k, first + (k + 1) % 6, first + 6 + (k + 1) % 6, first + 6 + k) for k in range(6))

        def grow(at, towards, length: float, radius: float, depth: int, tips: list) -> None:
            end = np.array(at) + np.array(towards) * length
            limb(at, end, radius, radius * 0.65)
            if depth == 0:
                tips.append(end)
                return
            for _ in range(3 if depth > 1 else 4):
                turned = np.array(towards) + np.array(
                    [chance.gauss(0, 0.45), chance.gauss(0, 0.45), chance.gauss(0.1, 0.25)]
                )
                grow(
                    end,
                    turned / np.linalg.norm(turned),
                    length * chance.uniform(0.62, 0.82),
                    radius * 0.6,
                    depth - 1,
                    tips,
                )

        tips: list = []
        grow((px, py, base), (0.0, 0.0, 1.0), 0.3 * height, 0.028 * height, 4, tips)
        _mesh("Tree", points, faces, [bark])
        points, faces = [], []
        for tip in tips:
            for _ in range(38):
                at = tip + np.array([chance.gauss(0, 0.045), chance.gauss(0, 0.045), chance.gauss(0, 0.04)]) * height
                u = np.array([chance.gauss(0, 1) for _ in range(3)])
                v = np.cross(u, [chance.gauss(0, 1) for _ in range(3)])
                u, v = 0.0055 * height * u / np.linalg.norm(u), 0.0038 * height * v / np.linalg.norm(v)
                first = len(points)
                points.extend([at - u - v, at + u - v, at + u + v, at - u + v])
                faces.append((first, first + 1, first + 2, first + 3))
        _mesh("Leaves", points, faces, [leaves])

    tree(-5.4, 15.0, 8.5)
    tree(7.8, 24.0, 10.0)
    tree(-15.0, 42.0, 9.0)
    tree(17.0, 55.0, 9.5)
    tree(3.6, 78.0, 8.0)
    for _ in range(8):
        tree(chance.uniform(-75, 75), chance.uniform(95, 150), chance.uniform(7, 11))

    fence = _Boxes()
    for k in range(12):
        px = -13.0 + 2.4 * k
        base = ground(px, 11.0)
        fence.add((px - 0.06, 10.94, base - 0.3), (px + 0.06, 11.06, base + 1.05), 0)
        for bar in (0.45, 0.85):
            fence.add((px, 10.98, base + bar), (px + 2.4, 11.02, base + bar + 0.09), 0)
    fence.done("Fence", [_material("Wood", (0.2, 0.14, 0.09), 0.8)])

    tree_of_nodes = _world((0.5, 0.6, 0.8), 0.12)
    sky = tree_of_nodes.nodes.new("ShaderNodeTexSky")
    kinds = [item.identifier for item in sky.bl_rna.properties["sky_type"].enum_items]
    sky.sky_type = "NISHITA" if "NISHITA" in kinds else "MULTIPLE_SCATTERING"
    sky.sun_disc, sky.sun_elevation = True, math.radians(14.0)
    sky.sun_rotation = math.radians(7.0)
    tree_of_nodes.links.new(sky.outputs["Color"], tree_of_nodes.nodes["Background"].inputs["Color"])
    _camera((0.0, 0.0, ground(0.0, 0.0) + 1.6), (0.5, 30.0, 5.2), 28.0)


def main() -> None:
    kind, out = sys.argv[-2:]
    bpy.ops.wm.read_factory_settings(use_empty=True)
    {"night": night_street, "sun": sun_between_trees}[kind]()
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 1536, 1024
    scene.view_settings.view_transform = "AgX"
    scene.view_settings.exposure = {"night": -0.3, "sun": -1.1}[kind]
    # Fireflies of lamps in the wet road.
    scene.cycles.sample_clamp_indirect = 20.0
    scene.cycles.use_denoising = False
    bpy.ops.wm.save_as_mainfile(filepath=out, compress=True)


if __name__ == "__main__":
    main()
