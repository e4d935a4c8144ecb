# SPDX-License-Identifier: GPL-3.0-or-later
"""A landscape: flowers and stones in front, trees between fields, hills for seven kilometres. Made of numbers; CC0.

python tests/scenes/gallery/landscape.py landscape.blend
"""

from __future__ import annotations

import math
import random

import bpy
import numpy as np
from parts import Stage, day_sky, main, math_node, mix_node, noise_node, ramp_node, turned

from demo_mesh import Shape, icosphere, join, tube

HAZE_M = 5200.0
HAZE = (0.74, 0.88, 1.04)
SUN_FROM = (-0.62, -0.35, 0.62)


def height(x, y):
    """The ground's height in metres over a place; 0 about the origin. Numbers or arrays."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    d = np.hypot(x, y)

    def rise(low, high):
        t = np.clip((d - low) / (high - low), 0.0, 1.0)
        return t * t * (3.0 - 2.0 * t)

    z = 0.10 * np.sin(x * 0.31 + 0.4) * np.sin(y * 0.23) * rise(2.0, 12.0)
    z = z - 14.0 * rise(12.0, 220.0)
    z = z + 9.0 * rise(150.0, 500.0) * np.sin(x / 97.0 + 1.0) * np.sin(y / 141.0 + 0.4)
    for k, (start, full, tall, wide) in enumerate(
        ((350.0, 900.0, 42.0, 330.0), (1300.0, 2300.0, 120.0, 900.0), (3600.0, 5200.0, 330.0, 1900.0))
    ):
        wave = 0.62 + 0.38 * np.sin(x / wide * 2.1 + 1.9 * k + 0.4) + 0.2 * np.sin(x / wide * 5.3 + k)
        wave = wave + 0.08 * np.sin(x / wide * 13.0 + 3.0 * k) * np.sin(y / wide * 11.0)
        z = z + tall * rise(start, full) * wave
    return z


def _hazed(material) -> None:
    """Air before it: the farther from the origin, the paler."""
    tree = material.node_tree
    place = tree.nodes.new("ShaderNodeNewGeometry").outputs["Position"]
    length = tree.nodes.new("ShaderNodeVectorMath")
    length.operation = "LENGTH"
    tree.links.new(place, length.inputs[0])
    clear = math_node(tree, "EXPONENT", math_node(tree, "MULTIPLY", length.outputs["Value"], -1.0 / HAZE_M))
    air = tree.nodes.new("ShaderNodeEmission")
    air.inputs["Color"].default_value = (*HAZE, 1.0)
    mixed = tree.nodes.new("ShaderNodeMixShader")
    tree.links.new(math_node(tree, "SUBTRACT", 1.0, clear), mixed.inputs[0])
    tree.links.new(tree.nodes["Principled BSDF"].outputs[0], mixed.inputs[1])
    tree.links.new(air.outputs[0], mixed.inputs[2])
    tree.links.new(mixed.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    # The air is seen; it need not be looked for as a lamp.
    material.cycles.emission_sampling = "NONE"


def _fields():
    """Meadow near by, farther off a patchwork of fields and woods."""
    material = bpy.data.materials.new("Land")
    material.use_nodes = True
    tree = material.node_tree
    place = tree.nodes.new("ShaderNodeNewGeometry").outputs["Position"]
    length = tree.nodes.new("ShaderNodeVectorMath")
    length.operation = "LENGTH"
    tree.links.new(place, length.inputs[0])
    flat = tree.nodes.new("ShaderNodeVectorMath")
    flat.operation = "MULTIPLY"
    flat.inputs[1].default_value = (1.0, 1.0, 0.0)
    tree.links.new(place, flat.inputs[0])
    cells = tree.nodes.new("ShaderNodeTexVoronoi")
    cells.inputs["Scale"].default_value = 1.0 / 140.0
    tree.links.new(flat.outputs[0], cells.inputs["Vector"])
    of_cell = tree.nodes.new("ShaderNodeSeparateColor")
    tree.links.new(cells.outputs["Color"], of_cell.inputs[0])
    tones = [(0.0, (0.10, 0.17, 0.035)), (0.25, (0.20, 0.25, 0.06)), (0.45, (0.36, 0.31, 0.10)), (0.6, (0.15, 0.22, 0.05)),
             (0.8, (0.25, 0.19, 0.09)), (1.0, (0.10, 0.18, 0.05))]  # fmt: skip
    patches = ramp_node(tree, of_cell.outputs[0], tones)
    tree.nodes[-1].color_ramp.interpolation = "CONSTANT"
    wood = ramp_node(
        tree, noise_node(tree, flat.outputs[0], 1.0 / 420.0, 5.0, 0.6), [(0.5, (0, 0, 0)), (0.535, (1, 1, 1))]
    )
    rough = noise_node(tree, place, 0.09, 6.0, 0.7)
    trees = ramp_node(tree, rough, [(0.35, (0.018, 0.04, 0.012)), (0.65, (0.05, 0.085, 0.022))])
    far = mix_node(tree, wood, patches, trees)
    grass = ramp_node(
        tree,
        noise_node(tree, place, 0.8, 8.0, 0.65),
        [(0.3, (0.055, 0.10, 0.02)), (0.5, (0.11, 0.17, 0.035)), (0.7, (0.20, 0.22, 0.07))],
    )
    away = ramp_node(
        tree, math_node(tree, "MULTIPLY", length.outputs["Value"], 1.0 / 400.0), [(0.25, (0, 0, 0)), (0.7, (1, 1, 1))]
    )
    shader = tree.nodes["Principled BSDF"]
    shader.inputs["Roughness"].default_value = 0.95
    shader.inputs["Specular IOR Level"].default_value = 0.1
    tree.links.new(mix_node(tree, away, grass, far), shader.inputs["Base Color"])
    _hazed(material)
    return material


def _green(name, dark, light, scale, air=True):
    """A leaf's colour, other from leaf to leaf."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    place = tree.nodes.new("ShaderNodeNewGeometry").outputs["Position"]
    shader = tree.nodes["Principled BSDF"]
    shader.inputs["Roughness"].default_value = 0.7
    tone = ramp_node(tree, noise_node(tree, place, scale, 2.0), [(0.35, dark), (0.65, light)])
    tree.links.new(tone, shader.inputs["Base Color"])
    if air:
        _hazed(material)
    return material


def _quads(points):
    """Quads of four points each, with leaf UVs."""
    count = len(points) // 4
    uvs = np.tile(np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float), (count, 1))
    faces = [(4 * k, 4 * k + 1, 4 * k + 2, 4 * k + 3) for k in range(count)]
    return Shape(np.array(points, float), faces, uvs, np.zeros(count, np.int32))


def _tree(seed: int, leaves: int, slim: float = 1.0):
    """A broad tree one metre tall: 0 bark, 1 leaves."""
    rng = np.random.default_rng(seed)
    limbs, tips = [tube([(0, 0, -0.05), (0.006, 0.004, 0.15), (0, 0.006, 0.34)], [0.032, 0.024, 0.018], 8)], []
    for k in range(9):
        turn, up = k * 2.4 + rng.uniform(-0.3, 0.3), rng.uniform(0.18, 0.34)
        out = rng.uniform(0.16, 0.30) * slim
        end = np.array([out * math.cos(turn), out * math.sin(turn), rng.uniform(0.42, 0.86)])
        middle = end * (0.45, 0.45, 0.0) + (0, 0, (up + end[2]) / 2 - 0.02)
        limbs.append(tube([(0, 0, up), middle, end], [0.011, 0.008, 0.003], 5))
        tips += [end, (middle + end) / 2]
    tips.append(np.array([0.0, 0.0, 0.88]))
    tips = np.array(tips)
    at = tips[rng.integers(0, len(tips), leaves)]
    aside = rng.normal(size=(leaves, 3))
    aside *= (rng.uniform(0, 1, leaves) ** 0.4 / np.linalg.norm(aside, axis=1))[:, None]
    at = at + aside * (0.135 * slim, 0.135 * slim, 0.10)
    u = rng.normal(size=(leaves, 3))
    u /= np.linalg.norm(u, axis=1)[:, None]
    v = np.cross(u, rng.normal(size=(leaves, 3)))
    v /= np.linalg.norm(v, axis=1)[:, None]
    size = rng.uniform(0.007, 0.0125, leaves)[:, None]
    u, v = u * size, v * size * 0.7
    points = np.stack([at - u - v, at + u - v, at + u + v, at - u + v], axis=1).reshape(-1, 3)
    return join([*limbs, _quads(points).slot(1)])


def _far_tree(seed: int):
    """A tree for kilometres: a lumpy ball on the ground, one metre tall."""
    shape = icosphere(0.5, 2)
    rng = np.random.default_rng(seed)
    lumps = sum(np.sin(shape.verts @ rng.normal(0, 9.0, 3) + rng.uniform(0, 6)) for _ in range(5))
    shape.verts = shape.verts * (1.0 + 0.06 * lumps)[:, None] * (0.8, 0.8, 1.0) + (0, 0, 0.46)
    return shape


def _stone(seed: int):
    """A field stone, one metre wide."""
    shape = icosphere(0.5, 4)
    rng = np.random.default_rng(seed)
    out = np.ones(len(shape.verts))
    for _ in range(7):
        normal = rng.normal(size=3)
        normal /= np.linalg.norm(normal)
        # Faces as of a broken stone.
        reach = shape.verts @ normal / 0.5
        out = np.minimum(out, np.where(reach > 0.55, rng.uniform(0.6, 0.8) / np.maximum(reach, 1e-3), 1.0))
    fine = sum(np.sin(shape.verts @ rng.normal(0, 30.0, 3) + rng.uniform(0, 6)) for _ in range(6))
    shape.verts = shape.verts * (out + 0.008 * fine)[:, None] * (1.0, 0.8, 0.62)
    return shape


def _tuft(seed: int, blades: int):
    """Grass: blades of three quads, about 0.3 m tall."""
    rng = np.random.default_rng(seed)
    points = []
    for _ in range(blades):
        turn, lean, tall = rng.uniform(0, 6.3), rng.uniform(0.02, 0.13), rng.uniform(0.12, 0.32)
        root = rng.normal(0, 0.05, 2)
        way = np.array([math.cos(turn), math.sin(turn), 0.0])
        side = np.array([-way[1], way[0], 0.0]) * rng.uniform(0.0018, 0.0032)
        line = [np.array([*root, -0.02]) + way * lean * t**2 + np.array([0, 0, tall * t]) for t in (0, 0.4, 0.75, 1.0)]
        for k, (a, b) in enumerate(zip(line, line[1:], strict=False)):
            wide, narrow = (1.0, 0.85, 0.5)[k], (0.85, 0.5, 0.06)[k]
            points += [a - side * wide, a + side * wide, b + side * narrow, b - side * narrow]
    return _quads(points)


def _flower(seed: int, petals: int, long: float, tall: float, cup: float):
    """A flower on its stem: 0 stem, 1 petals, 2 heart."""
    rng = np.random.default_rng(seed)
    top = np.array([rng.normal(0, 0.03), rng.normal(0, 0.03), tall])
    stem = tube([(0, 0, -0.02), (top[0] * 0.2, top[1] * 0.2, tall * 0.5), top], [0.0022, 0.002, 0.0016], 5)
    points = []
    for k in range(petals):
        turn = 2 * math.pi * k / petals + rng.normal(0, 0.08)
        way, side = np.array([math.cos(turn), math.sin(turn), 0.0]), np.array([-math.sin(turn), math.cos(turn), 0.0])
        wide = long * min(0.75, 2.6 / petals)
        rows = [
            (0.05, 0.25, 0.0), (0.45, 0.9, cup * 0.5), (0.8, 1.0, cup * 0.9), (1.0, 0.55, cup * (1.0 + rng.normal(0, 0.1)))
        ]  # fmt: skip
        for (r0, w0, z0), (r1, w1, z1) in zip(rows, rows[1:], strict=False):
            a, b = top + way * long * r0 + (0, 0, z0 * long), top + way * long * r1 + (0, 0, z1 * long)
            points += [
                a - side * wide * w0 / 2,
                a + side * wide * w0 / 2,
                b + side * wide * w1 / 2,
                b - side * wide * w1 / 2,
            ]
    heart = icosphere(long * 0.22, 2)
    heart.verts = heart.verts * (1, 1, 0.6) + top + (0, 0, long * 0.08)
    return join([stem, _quads(points).slot(1), heart.slot(2)])


def _ground(stage: Stage, nearest: float, half_angle: float, drop: float) -> None:
    """A fan of land about the origin: cells are as wide as they look."""
    columns, rows = 260, 300
    d = nearest * (7400.0 / nearest) ** np.linspace(0.0, 1.0, rows)
    angle = np.linspace(-half_angle, half_angle, columns)
    x, y = d[:, None] * np.sin(angle)[None, :], d[:, None] * np.cos(angle)[None, :]
    verts = np.stack([x, y, height(x, y) - drop], -1).reshape(-1, 3)
    cell = np.arange(rows * columns).reshape(rows, columns)
    quads = np.stack([cell[:-1, :-1], cell[:-1, 1:], cell[1:, 1:], cell[1:, :-1]], -1).reshape(-1, 4)
    mesh = bpy.data.meshes.new("Land")
    mesh.from_pydata(verts.tolist(), [], quads.tolist())
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    mesh.materials.append(_fields())
    mesh.update()
    made = bpy.data.objects.new("Land", mesh)
    stage.collection.objects.link(made)


def build_land(
    stage: Stage, *, nearest=1.0, half_angle=0.75, drop=0.0, trees=(20.0, 320.0), count=46, open_view=(-0.16, 0.16)
) -> None:
    """Land, trees and the sun; `drop` lowers it all, `nearest` is where it begins, `open_view` the angles without near trees."""
    chance = random.Random(5)
    _ground(stage, nearest, half_angle, drop)
    bark = _green("Bark", (0.05, 0.035, 0.025), (0.10, 0.075, 0.05), 4.0)
    greens = [
        _green("Leaves 1", (0.04, 0.085, 0.015), (0.10, 0.17, 0.03), 1.4),
        _green("Leaves 2", (0.03, 0.07, 0.018), (0.075, 0.13, 0.03), 1.4),
        _green("Leaves 3", (0.075, 0.10, 0.02), (0.16, 0.18, 0.04), 1.4),
    ]
    near = [stage.mesh(_tree(k, 9000, 1.0 if k < 2 else 0.7), f"Tree {k}", [bark, greens[k]], False) for k in range(3)]
    placed = []
    while len(placed) < count:
        d, angle = trees[0] * (trees[1] / trees[0]) ** chance.random(), chance.uniform(-half_angle, half_angle)
        tall = chance.uniform(7.0, 13.0)
        if d < 90.0 and open_view[0] < angle < open_view[1]:
            continue
        x, y = d * math.sin(angle), d * math.cos(angle)
        if any(math.hypot(x - a, y - b) < 6.0 for a, b in placed):
            continue
        placed.append((x, y))
        spot = (x, y, float(height(x, y)) - drop)
        stage.again(near[chance.randrange(3)], f"Tree {len(placed)}", turned(spot, chance.uniform(0, 360), tall))
    far = [stage.mesh(_far_tree(k), f"Far tree {k}", [greens[k]]) for k in range(3)]
    for k in range(950):
        # In hedges and groups.
        if k % 19 == 0:
            d, angle = 170.0 * (3000.0 / 170.0) ** chance.random(), chance.uniform(-half_angle, half_angle)
            x, y, way, step = d * math.sin(angle), d * math.cos(angle), chance.uniform(0, 6.3), 5.0 + 0.004 * d
        x, y = (
            x + step * math.cos(way) * 1.3 + chance.gauss(0, step * 0.4),
            y + step * math.sin(way) + chance.gauss(0, step * 0.4),
        )
        if math.hypot(x, y) < 150.0:
            continue
        spot = (x, y, float(height(x, y)) - drop)
        stage.again(far[k % 3], f"Far tree {k}", turned(spot, chance.uniform(0, 360), chance.uniform(6.0, 11.0)))
    stage.lamp(
        "Sun", "SUN", (0, 0, 50), 6.0, (1.0, 0.9, 0.74), aim=(-SUN_FROM[0], -SUN_FROM[1], 50 - SUN_FROM[2]), angle=0.02
    )


def _foreground(stage: Stage) -> None:
    """Flowers, grass and stones from 1.5 to 25 m."""
    chance = random.Random(17)
    grass = _green("Grass", (0.06, 0.12, 0.02), (0.19, 0.24, 0.06), 3.0, air=False)
    tufts = [stage.mesh(_tuft(k, 70), f"Tuft {k}", [grass], False) for k in range(4)]
    half = 0.62

    def spot(low, high, power=1.0):
        d, angle = low * (high / low) ** (chance.random() ** power), chance.uniform(-half, half)
        x, y = d * math.sin(angle), d * math.cos(angle)
        return (x, y, float(height(x, y)))

    for k in range(2600):
        stage.again(
            tufts[k % 4], f"Grass {k}", turned(spot(1.1, 30.0), chance.uniform(0, 360), chance.uniform(0.6, 1.25))
        )
    stem = _green("Stems", (0.06, 0.11, 0.03), (0.10, 0.16, 0.05), 9.0, air=False)
    poppy = _green("Poppy", (0.52, 0.015, 0.008), (0.72, 0.05, 0.015), 14.0, air=False)
    daisy = _green("Daisy", (0.72, 0.71, 0.66), (0.80, 0.79, 0.76), 9.0, air=False)
    corn = _green("Cornflower", (0.05, 0.08, 0.45), (0.12, 0.17, 0.66), 14.0, air=False)
    dark = _green("Heart", (0.012, 0.01, 0.012), (0.03, 0.025, 0.02), 20.0, air=False)
    yellow = _green("Yellow", (0.62, 0.38, 0.02), (0.75, 0.52, 0.04), 20.0, air=False)
    kinds = [
        stage.mesh(_flower(1, 5, 0.042, 0.42, 0.45), "Poppy", [stem, poppy, dark], False),
        stage.mesh(_flower(2, 6, 0.038, 0.36, 0.75), "Poppy in bud", [stem, poppy, dark], False),
        stage.mesh(_flower(3, 15, 0.024, 0.34, 0.12), "Daisy", [stem, daisy, yellow], False),
        stage.mesh(_flower(4, 11, 0.020, 0.40, 0.5), "Cornflower", [stem, corn, dark], False),
    ]
    for k in range(520):
        one = kinds[chance.choices(range(4), (0.32, 0.1, 0.4, 0.18))[0]]
        matrix = turned(spot(1.5, 26.0), chance.uniform(0, 360), chance.uniform(0.8, 1.2), chance.gauss(0, 9))
        stage.again(one, f"Flower {k}", matrix)
    rock = bpy.data.materials.new("Rock")
    rock.use_nodes = True
    tree = rock.node_tree
    place = tree.nodes.new("ShaderNodeNewGeometry").outputs["Position"]
    tone = ramp_node(
        tree,
        noise_node(tree, place, 9.0, 8.0, 0.65),
        [(0.3, (0.12, 0.11, 0.10)), (0.5, (0.3, 0.28, 0.25)), (0.7, (0.42, 0.4, 0.36))],
    )
    lichen = ramp_node(tree, noise_node(tree, place, 5.0, 6.0, 0.6), [(0.58, (0, 0, 0)), (0.64, (1, 1, 1))])
    tree.links.new(mix_node(tree, lichen, tone, (0.36, 0.34, 0.12)), tree.nodes["Principled BSDF"].inputs["Base Color"])
    tree.nodes["Principled BSDF"].inputs["Roughness"].default_value = 0.9
    stones = [stage.mesh(_stone(k), f"Stone {k}", [rock]) for k in range(3)]
    fixed = [(-0.72, 2.5, 0.46), (-1.15, 3.2, 0.62), (0.95, 4.2, 0.40), (2.1, 6.0, 0.85), (-2.9, 8.0, 1.1)]
    for k, (x, y, wide) in enumerate(fixed):
        matrix = turned((x, y, float(height(x, y)) + 0.10 * wide), 77.0 * k, wide)
        stage.again(stones[k % 3], f"Stone {k}", matrix)
    for k in range(26):
        x, y, z = spot(3.0, 30.0)
        matrix = turned((x, y, z), chance.uniform(0, 360), chance.uniform(0.08, 0.3))
        stage.again(stones[k % 3], f"Pebble {k}", matrix)


def build() -> Stage:
    """The landscape alone, a camera at the height of the knees of someone who kneels among flowers."""
    stage = Stage("Landscape")
    day_sky(stage, 1.5)
    build_land(stage, nearest=0.4)
    _foreground(stage)
    stage.camera((0.0, 0.0, 0.95), (0.0, 30.0, -0.2), 40.0, (36.0, 24.0), 2.6, 8.0)
    stage.targets(stone=(-0.72, 2.5, 0.2), trees=(0.0, 60.0, 0.0), hills=(0.0, 2000.0, 0.0))
    return stage


if __name__ == "__main__":
    main(build)
