# SPDX-License-Identifier: GPL-3.0-or-later
"""A portrait bust of stone on a pedestal, by a window. The head is a signed distance; made of numbers, CC0.

python tests/scenes/gallery/bust.py bust.blend [plain|lamps]

lamps: small lamps in the dark behind it.
"""

from __future__ import annotations

import random

import bpy
import numpy as np
from parts import Stage, bulb, main, math_node, mix_node, noise_node, plain_world, ramp_node
from solid import ball, cut, ellipsoid, join, limb, surface, within

import demo_props as props
from demo_mesh import box, lathe
from demo_mesh import join as joined
from demo_room import slab

# The chin's lowest point above the floor.
CHIN = 1.42


def _sided(p):
    """The right half stands for the left one."""
    q = p.copy()
    q[:, 0] = np.abs(q[:, 0])
    return q


def _curls(p):
    """The height of locks of hair."""
    turn = np.arctan2(p[:, 1] - 0.015, p[:, 0])
    away = p[:, 2] * 38.0
    flow = 2.2 * np.sin(away * 0.55 + 2.0 * np.sin(2.0 * turn)) + 1.1 * np.sin(5.0 * turn + 0.3 * away)
    lock = np.abs(np.sin(8.0 * turn + flow + 0.35 * away))
    strand = np.sin(26.0 * turn + 4.0 * flow + 1.2 * away)
    return 0.0105 * lock**0.7 + 0.0011 * strand * lock


def head(p):
    """The signed distance of the bust; the face looks along -Y, the chin is the origin's height."""
    s = _sided(p)
    d = join(
        ellipsoid(p, (0, 0.014, 0.152), (0.073, 0.096, 0.083)),
        ellipsoid(p, (0, -0.028, 0.095), (0.060, 0.066, 0.088)),
        0.03,
    )
    # Jaw and chin.
    d = join(d, limb(s, (0.050, 0.000, 0.055), (0.020, -0.062, 0.020), 0.022, 0.018), 0.03)
    d = join(d, ellipsoid(p, (0, -0.079, 0.019), (0.020, 0.017, 0.017)), 0.02)
    # Cheekbones, temples, mouth.
    d = join(d, ellipsoid(s, (0.043, -0.058, 0.086), (0.020, 0.024, 0.016)), 0.025)
    d = join(d, ellipsoid(p, (0, -0.074, 0.048), (0.029, 0.026, 0.024)), 0.02)
    # Sockets under the brow.
    d = join(d, limb(s, (0.010, -0.090, 0.1235), (0.040, -0.080, 0.1285), 0.0085, 0.007), 0.016)
    d = cut(d, ellipsoid(s, (0.0325, -0.101, 0.1095), (0.0185, 0.0170, 0.0115)), 0.012)
    d = cut(d, ellipsoid(s, (0.015, -0.108, 0.1085), (0.008, 0.014, 0.010)), 0.010)
    # Nose: bridge, tip, wings, nostrils.
    d = join(d, limb(p, (0, -0.090, 0.121), (0, -0.1125, 0.080), 0.0065, 0.0085), 0.010)
    d = join(d, ellipsoid(p, (0, -0.1135, 0.0755), (0.0095, 0.0095, 0.0082)), 0.007)
    d = join(d, ellipsoid(s, (0.0115, -0.1010, 0.0725), (0.0065, 0.0105, 0.0072)), 0.005)
    d = cut(d, ellipsoid(s, (0.0062, -0.1060, 0.0655), (0.0030, 0.0055, 0.0045)), 0.003)
    # Lips: the upper one bowed, a line between them, the hollow under the nose.
    d = join(d, limb(s, (0.0050, -0.0985, 0.0527), (0.0250, -0.0865, 0.0488), 0.0052, 0.0030), 0.008)
    d = join(d, limb(s, (0.0, -0.0975, 0.0425), (0.0220, -0.0870, 0.0460), 0.0064, 0.0034), 0.008)
    d = cut(d, limb(s, (0.0, -0.1055, 0.0476), (0.0262, -0.0895, 0.0474), 0.0012, 0.0010), 0.004)
    d = cut(d, limb(p, (0, -0.1060, 0.0600), (0, -0.1045, 0.0655), 0.0028), 0.006)
    d = cut(d, ellipsoid(p, (0, -0.1050, 0.0325), (0.016, 0.0080, 0.0040)), 0.012)
    # Eyes between their lids.
    eye = np.array([0.0315, -0.0775, 0.1090])
    d = join(d, ball(s, eye, 0.0128), 0.002)
    lid = ball(s, eye, 0.0144)
    rise = (s - eye) @ np.array([0.0, -0.35, 0.94])
    bow = 0.0040 - 20.0 * (s[:, 0] - eye[0]) ** 2
    d = join(d, within(lid, bow + 0.0045 - rise, 0.0012), 0.0022)
    d = join(d, within(lid, rise + 0.0022 - 8.0 * (s[:, 0] - eye[0]) ** 2 + 0.0016, 0.0012), 0.0022)
    d = cut(d, ball(s, eye + (0, -0.0136, 0.0008), 0.0026), 0.0012)
    # Ears.
    ear = join(
        ellipsoid(s, (0.0755, 0.008, 0.108), (0.0075, 0.018, 0.027)),
        ellipsoid(s, (0.0735, -0.001, 0.083), (0.006, 0.009, 0.011)),
        0.01,
    )
    ear = cut(ear, ellipsoid(s, (0.083, 0.004, 0.109), (0.0075, 0.0105, 0.0175)), 0.005)
    ear = cut(ear, ellipsoid(s, (0.080, -0.005, 0.097), (0.006, 0.005, 0.008)), 0.004)
    # Neck, with the two muscles that cross it, and shoulders.
    neck = limb(p, (0, 0.022, 0.045), (0, 0.034, -0.110), 0.049, 0.056)
    neck = join(neck, limb(s, (0.052, 0.018, 0.055), (0.013, -0.030, -0.104), 0.013, 0.010), 0.022)
    neck = join(neck, ellipsoid(p, (0, -0.026, -0.022), (0.011, 0.010, 0.015)), 0.02)
    d = join(d, neck, 0.018)
    chest = ellipsoid(p, (0, 0.030, -0.195), (0.165, 0.088, 0.105))
    chest = join(chest, limb(s, (0.02, 0.050, -0.055), (0.150, 0.045, -0.135), 0.036, 0.045), 0.05)
    chest = join(chest, ellipsoid(s, (0.165, 0.030, -0.165), (0.055, 0.058, 0.065)), 0.04)
    chest = join(chest, limb(s, (0.014, -0.048, -0.118), (0.130, -0.010, -0.108), 0.0075, 0.0065), 0.022)
    chest = join(chest, ellipsoid(s, (0.066, -0.034, -0.205), (0.074, 0.040, 0.055)), 0.05)
    d = join(d, chest, 0.035)
    # Cut as sculptors cut it: a curve below, smooth ends of the arms.
    d = within(d, ellipsoid(p, (0, 0.02, -0.035), (0.205, 0.30, 0.222)), 0.008)
    d = join(d, limb(p, (0, 0.03, -0.23), (0, 0.03, -0.275), 0.056, 0.048), 0.03)
    # Hair over the skull, back from the forehead, in front of the ears' tops, to the nape.
    skull = ellipsoid(p, (0, 0.021, 0.152), (0.0765, 0.0985, 0.0865))
    line = 0.092 - p[:, 1] - p[:, 2] + 0.006 * np.cos(p[:, 0] * 70.0) + 0.25 * np.maximum(np.abs(p[:, 0]) - 0.05, 0)
    nape = within(limb(p, (0, 0.055, 0.095), (0, 0.062, 0.028), 0.05, 0.036), 0.018 - p[:, 2], 0.01)
    hair = within(join(skull, nape, 0.03), line * 0.7, 0.012) - _curls(p)
    return join(join(d, hair, 0.004), ear, 0.005)


def _marble():
    made = bpy.data.materials.new("Marble")
    made.use_nodes = True
    tree = made.node_tree
    place = tree.nodes.new("ShaderNodeTexCoord").outputs["Object"]
    vein = noise_node(tree, place, 7.0, 8.0, 0.62)
    thin = ramp_node(tree, vein, [(0.47, (0, 0, 0)), (0.5, (1, 1, 1)), (0.53, (0, 0, 0))])
    cloud = ramp_node(
        tree, noise_node(tree, place, 14.0, 5.0, 0.6), [(0.3, (0.66, 0.63, 0.58)), (0.7, (0.80, 0.78, 0.74))]
    )
    shader = tree.nodes["Principled BSDF"]
    tree.links.new(
        mix_node(tree, math_node(tree, "MULTIPLY", thin, 0.28), cloud, (0.38, 0.36, 0.35)), shader.inputs["Base Color"]
    )
    grain = noise_node(tree, place, 900.0, 2.0, 0.6)
    bump = tree.nodes.new("ShaderNodeBump")
    bump.inputs["Strength"].default_value, bump.inputs["Distance"].default_value = 0.12, 0.0006
    tree.links.new(grain, bump.inputs["Height"])
    tree.links.new(bump.outputs[0], shader.inputs["Normal"])
    shader.inputs["Roughness"].default_value = 0.42
    return made


def build(view: str) -> Stage:
    """The bust, and the background."""
    stage = Stage("Bust")
    stone = _marble()
    body = surface(head, (-0.24, -0.14, -0.29), (0.24, 0.20, 0.27), 0.0016)
    made = stage.put(body, "Bust", [stone], z=CHIN, rz=24)
    made.data.polygons.foreach_set("use_smooth", [True] * len(made.data.polygons))
    for edge in made.data.edges:
        edge.use_edge_sharp = False
    foot = CHIN - 0.275
    socle = lathe(
        [(0, -0.12), (0.10, -0.12), (0.10, -0.095), (0.088, -0.085), (0.06, -0.06), (0.052, -0.03), (0.062, -0.008), (0.066, 0.0), (0.0, 0.012)],
        96, 0.006, steps=4,
    )  # fmt: skip
    stage.put(socle, "Socle", [stone], z=foot, y=0.027, x=-0.012)
    base = foot - 0.12
    column = [
        box(0.34, 0.34, 0.05, 0.008, 3).at(z=base - 0.025),
        box(0.28, 0.28, base - 0.12, 0.006, 3).at(z=(base - 0.12) / 2 + 0.07),
    ]
    stage.put(joined([*column, box(0.36, 0.36, 0.07, 0.01, 3).at(z=0.035)]), "Pedestal", ["dark wood"], rz=12)
    stage.put(slab(-4, 4, -4, 4, -0.05, 0), "Floor", ["floor"])
    if view == "plain":
        stage.put(slab(-4, 4, 1.6, 1.8, 0, 3.4), "Wall", ["felt"])
        stage.put(props.curtain(1.3, 3.2, 9, 0.09, 4), "Curtain", ["curtain"], x=0.25, y=1.3, z=0.05)
    else:
        chance, tints = random.Random(3), ((1.0, 0.62, 0.28), (1.0, 0.82, 0.6), (0.5, 0.66, 1.0))
        lamps = [bulb(f"Lamps {k}", c, 7.0) for k, c in enumerate(tints)]
        for k in range(110):
            y = chance.uniform(2.2, 8.0)
            x, z = chance.uniform(-0.28, 0.28) * (y + 2.2), CHIN + chance.uniform(-0.2, 0.24) * (y + 2.2)
            shape = props.bulbs(np.zeros((1, 3)), np.array([0.0045 * (y + 0.5)]))
            stage.put(shape, f"Lamp {k}", [lamps[k % 3]], x=x, y=y, z=z)
    stage.lamp(
        "Window",
        "AREA",
        (-1.7, -1.3, 2.35),
        66.0,
        (0.93, 0.96, 1.0),
        aim=(0, 0, CHIN + 0.05),
        shape="RECTANGLE",
        size=1.0,
        size_y=1.5,
    )
    stage.lamp("Rim", "AREA", (1.4, 0.9, 2.0), 20.0, (1.0, 0.78, 0.55), aim=(0, 0, CHIN + 0.05), shape="DISK", size=0.4)
    plain_world(stage, (0.05, 0.06, 0.085), 0.35)
    distance = 1.75
    stage.camera((0.0, -distance, CHIN + 0.12), (0.0, 0.0, CHIN - 0.005), 85.0, (24.0, 32.0), distance - 0.09, 2.0)
    stage.scene.render.resolution_x, stage.scene.render.resolution_y = 900, 1200
    stage.targets(eye=(0.05, -0.085, CHIN + 0.109))
    return stage


if __name__ == "__main__":
    main(build, ("plain", "lamps"))
