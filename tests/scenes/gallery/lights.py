# SPDX-License-Identifier: GPL-3.0-or-later
"""A garden table at night under strings of lamps, for the shapes of blurred lights. Made of numbers; CC0.

python tests/scenes/gallery/lights.py lights.blend [near|points|far|wide]

near: the table at 1.3 m from the camera, lamps from 3 to 14 m, for lenses of about 100 mm; one bare lamp glares.
points: the same with lamps a third as wide, and no bare one: nearly points, which show the shape of the blur.
far: the same garden from 9 m, for a lens of 500 mm.
wide: from 3.5 m, for an anamorphic lens on a film of 22 x 18.6 mm; a bare lamp stands in the picture.
"""

from __future__ import annotations

import math
import random

import bpy
import numpy as np
from landscape import _green, _tree
from parts import Stage, bulb, main, plain_world, turned

import demo_props as props
import demo_room as house
from demo_mesh import catenary, join, lathe, tube
from demo_room import slab

TABLE = 0.74


def _string(stage: Stage, name: str, a, b, sag: float, spacing: float, radius: float, material) -> None:
    """Lamps hung on a cable between two points."""
    cable = catenary(a, b, sag, 60)
    stage.put(tube(cable, 0.004, 6), f"{name} cable", ["black"])
    points = house.hung_lights(cable, spacing, spacing / 2)
    sockets = [tube([p, p - [0, 0, 1.2 * radius]], radius * 0.5, 10) for p in points]
    stage.put(join(sockets), f"{name} sockets", ["black"])
    drop = np.array([0.0, 0.0, 2.1 * radius])
    stage.put(props.bulbs(points - drop, np.full(len(points), radius)), f"{name} lamps", [material])


def _lantern():
    """A lantern of four posts and a roof, one candle within: 0 metal, 1 wax, 2 flame."""
    parts = [slab(-0.06, 0.06, -0.06, 0.06, 0, 0.014, 0.004), slab(-0.062, 0.062, -0.062, 0.062, 0.19, 0.2, 0.003)]
    parts += [
        slab(x - 0.005, x + 0.005, y - 0.005, y + 0.005, 0.01, 0.195) for x in (-0.052, 0.052) for y in (-0.052, 0.052)
    ]
    roof = lathe([(0.088, 0.198), (0.05, 0.225), (0.022, 0.25), (0.02, 0.262), (0.026, 0.266), (0, 0.275)], 4).at(rz=45)
    turn = np.linspace(0, 2 * math.pi, 40, endpoint=False)
    ring = tube(np.stack([0.022 * np.cos(turn), 0 * turn, 0.295 + 0.022 * np.sin(turn)], -1), 0.0022, 8, closed=True)
    wax = lathe([(0, 0.014), (0.026, 0.014), (0.026, 0.085), (0.022, 0.088), (0, 0.084)], 40, 0.003).slot(1)
    flame = lathe([(0, 0.088), (0.006, 0.094), (0.008, 0.104), (0.005, 0.12), (0, 0.134)], 16).slot(2)
    return join([*parts, roof, ring, wax, flame])


def build(view: str) -> Stage:
    """The garden."""
    chance = random.Random(11)
    stage = Stage("Lights")
    far = view == "far"
    # Of lamps: as bright as a whole, whatever their size.
    wide = {"points": 0.35, "wide": 0.6}.get(view, 1.0)
    bright = 1.0 / wide**2
    ground = bpy.data.materials.new("Gravel")
    ground.use_nodes = True
    ground.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.16, 0.14, 0.12, 1.0)
    ground.node_tree.nodes["Principled BSDF"].inputs["Roughness"].default_value = 0.9
    stage.put(slab(-14, 14, -12, 26, -0.1, 0.0), "Ground", [ground])

    # The subject: a table with a lantern, a jug and lemons.
    stage.put(house.table(0.9, 0.6, TABLE), "Table", ["walnut"], y=1.95)
    flame = bulb("Flame", (1.0, 0.6, 0.22), 12.0)
    stage.put(_lantern(), "Lantern", ["brass", "white", flame], x=-0.05, y=1.8, z=TABLE, rz=24)
    jug = lathe(
        [(0, 0), (0.05, 0), (0.062, 0.02), (0.07, 0.07), (0.055, 0.13), (0.04, 0.16), (0.046, 0.19), (0.042, 0.19), (0.036, 0.16), (0.05, 0.12), (0, 0.1)],
        72, 0.01, steps=4,
    )  # fmt: skip
    stage.put(jug, "Jug", ["terracotta"], x=0.19, y=1.88, z=TABLE)
    stage.put(
        props.plant(5, 9, 0.2, 0.09, 0.05, 0.12),
        "Plant",
        ["leaf", "stem", "terracotta", "soil"],
        x=-0.27,
        y=1.95,
        z=TABLE,
    )
    lemon = lathe(
        [(0, -0.039), (0.008, -0.036), (0.02, -0.024), (0.0265, 0), (0.02, 0.024), (0.008, 0.036), (0, 0.039)],
        40,
        0.008,
    )
    peel = bpy.data.materials.new("Lemon")
    peel.use_nodes = True
    peel.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.8, 0.52, 0.04, 1.0)
    peel.node_tree.nodes["Principled BSDF"].inputs["Roughness"].default_value = 0.4
    fruit = stage.mesh(lemon, "Lemon", [peel])
    for k, (x, y, yaw) in enumerate(((0.07, 1.70, 20.0), (0.125, 1.725, 100.0), (-0.16, 1.73, 60.0))):
        stage.again(fruit, f"Lemon {k}", turned((x, y, TABLE + 0.0265), yaw, 1.0, 90.0))

    # Lamps at many depths, larger when farther: each fills a like part of its blur.
    warm = bulb("Warm lamps", (1.0, 0.62, 0.28), 14.0 * bright)
    pale = bulb("Pale lamps", (1.0, 0.84, 0.62), 60.0 if far else 14.0 * bright)
    tints = [
        bulb(f"Tinted lamps {k}", c, 60.0 if far else 12.0 * bright)
        for k, c in enumerate(((1.0, 0.16, 0.06), (0.2, 0.75, 0.25), (0.16, 0.36, 1.0)))
    ]
    near_z = 1.62
    _string(stage, "String at 3 m", (-1.2, 3.2, near_z), (1.3, 3.8, near_z - 0.1), 0.22, 0.26, 0.010 * wide, warm)
    _string(stage, "String at 5 m", (-2.2, 5.4, 1.95), (2.0, 5.0, 1.7), 0.45, 0.27, 0.017 * wide, pale)
    _string(stage, "String at 7 m", (-2.6, 6.6, 1.6), (2.9, 7.4, 2.2), 0.5, 0.33, 0.023 * wide, warm)
    _string(stage, "String at 9 m", (-3.2, 9.5, 2.6), (3.1, 9.0, 2.3), 0.7, 0.38, 0.030 * wide, pale)
    _string(stage, "String at 12 m", (-4.2, 12.0, 2.4), (4.3, 12.6, 3.0), 0.6, 0.5, 0.038 * wide, warm)
    # Lamps in the hedge, every other one tinted; from far away they stand closer.
    for k in range(70 if far else 44):
        y = chance.uniform(7.0, 13.5) if far else chance.uniform(6.0, 13.5)
        x = chance.uniform(-0.75, 0.75) if far else chance.uniform(-0.3, 0.3) * y
        z = chance.uniform(0.45, 1.5) if far else chance.uniform(0.2, 1.7)
        radius = 0.006 if far else 0.0030 * y * wide
        tint = tints[k % 3] if k % 2 else pale
        stage.put(props.bulbs(np.zeros((1, 3)), np.array([radius])), f"Lamp in the hedge {k}", [tint], x=x, y=y, z=z)
    # Bare lamps glare.
    glare = bulb("Bare lamp", (1.0, 0.9, 0.76), 1800.0 if view == "wide" else 240.0)
    bare = {"points": (), "wide": ((0.56, 8.0, 1.12),)}.get(view, ((0.86, 8.2, 1.95), (-1.75, 11.0, 2.1)))
    for k, (x, y, z) in enumerate(bare):
        stage.put(tube([(0, 0, -z), (0, 0, -0.03)], 0.03, 10), f"Post {k}", ["black"], x=x, y=y, z=z)
        stage.put(props.bulbs(np.zeros((1, 3)), np.array([0.04])), f"Bare lamp {k}", [glare], x=x, y=y, z=z)

    bark = _green("Bark", (0.05, 0.035, 0.025), (0.10, 0.075, 0.05), 4.0, air=False)
    leaves = _green("Leaves", (0.03, 0.07, 0.018), (0.075, 0.13, 0.03), 1.4, air=False)
    tree = stage.mesh(_tree(1, 6000, 0.8), "Tree", [bark, leaves], False)
    for k in range(17):
        x = -8.0 + k
        spot = (x + chance.gauss(0, 0.3), 15.5 + chance.gauss(0, 0.8), -0.4)
        stage.again(tree, f"Tree {k}", turned(spot, chance.uniform(0, 360), chance.uniform(3.6, 5.5)))
    for k, (x, y, tall) in enumerate(((-3.3, 8.6, 4.0), (3.6, 10.4, 4.4), (2.6, 6.4, 3.2))):
        stage.again(tree, f"Garden tree {k}", turned((x, y, -0.1), 90.0 * k, tall))

    stage.lamp(
        "Festoon behind the camera",
        "AREA",
        (0.9, 0.3, 2.3),
        34.0,
        (1.0, 0.72, 0.45),
        aim=(0.0, 1.85, 0.8),
        shape="DISK",
        size=0.5,
    )
    stage.lamp("Moon", "AREA", (-3.0, 3.0, 4.0), 60.0, (0.5, 0.65, 1.0), aim=(0.0, 2.0, 0.8), shape="DISK", size=1.2)
    plain_world(stage, (0.010, 0.016, 0.038), 0.6)
    if far:
        stage.camera((0.0, -7.2, 1.08), (0.0, 1.8, 0.93), 500.0, (36.0, 24.0), 9.0, 8.0)
    elif view == "wide":
        stage.camera((0.0, -1.75, 1.07), (0.0, 1.8, 0.94), 100.0, (22.0, 18.6), 3.5, 2.0)
    else:
        stage.camera((0.0, 0.5, 1.0), (0.0, 1.8, 0.905), 100.0, (42.0, 28.0), 1.25, 3.4)
    stage.targets(lantern=(-0.05, 1.74, 0.84))
    return stage


if __name__ == "__main__":
    main(build, ("near", "points", "far", "wide"))
