# SPDX-License-Identifier: GPL-3.0-or-later
"""A matte, a metal and a glass ball in a row under a lamp, beside Cycles block by block. Imports what needs bpy when it is called."""

from __future__ import annotations

import numpy as np

from support.node_tree import Tree

SIDE, SAMPLES = 32, 1024
#: Pixels of a block's side.
BLOCK = 8
WHITE = (0.8, 0.8, 0.8, 1.0)


def set_up(blender):
    """A floor and three balls in a row: matte, rough metal and glass; a lamp above, and a dim sky."""
    from support import scenes as parts

    scene = parts.set_up(SIDE, SIDE, SAMPLES)
    scene.world = parts.grey_world(0.2)
    scene.camera.location, scene.camera.rotation_euler = (0.0, -7.0, 3.0), (1.25, 0.0, 0.0)
    scene.camera.data.lens = 45
    floor = parts.mesh_object(
        "Floor", [(-6, -6, 0), (6, -6, 0), (6, 6, 0), (-6, 6, 0)], [(0, 1, 2, 3)], shaded(parts, "BsdfDiffuse")
    )
    balls = {
        "Matte": shaded(parts, "BsdfDiffuse"),
        "Metal": shaded(parts, "BsdfAnisotropic", Roughness=0.3),
        "Glass": shaded(parts, "BsdfGlass", Roughness=0.0, IOR=1.4),
    }
    for place, (name, material) in enumerate(balls.items()):
        blender.ops.mesh.primitive_uv_sphere_add(
            segments=32, ring_count=16, radius=0.8, location=(1.9 * (place - 1), 0, 0.85)
        )
        blender.ops.object.shade_smooth()
        blender.context.object.name = name
        blender.context.object.data.materials.append(material)
    lamp = blender.data.objects.new("Lamp", blender.data.lights.new("Lamp", "AREA"))
    lamp.data.energy, lamp.data.size, lamp.location = 150.0, 1.0, (1.0, -1.5, 4.0)
    scene.collection.objects.link(lamp)
    parts.floor, parts.lamp = floor, lamp
    return parts


def shaded(parts, kind: str, **inputs):
    """A material of one node."""
    made, tree, surface = parts.material(kind)
    node = Tree(tree, surface).node(kind, None, **({"Color": WHITE} | inputs))
    tree.links.new(node.outputs[0], surface)
    return made


def add_panel(parts, colour=(0.9, 0.2, 0.1), strength: float = 4.0):
    """A square that glows, behind the balls."""
    panel = parts.square("Panel", (0.0, 2.2, 1.6), 3.0, parts.emitter(colour, strength))
    panel.rotation_euler = (-0.2, 0.0, 0.0)
    return panel


def alike(folder, mean: float = 0.01, block: float = 0.04, **cycles_settings) -> np.ndarray:
    """Petzval shows what Cycles does, in the mean and block by block: edges fall between the samples of 64 pixels, and what rays alone
    find is noisy in both: with 16 times the samples the worst block is 0.7 % apart. Gives Petzval's picture."""
    from support import beside_cycles

    return beside_cycles.alike(folder, SAMPLES, side=BLOCK, mean=mean, block=block, **cycles_settings)


def differs(first, second, part: float = 0.01) -> None:
    """The setting did something: no test passes because nothing happened."""
    assert np.abs(first - second).mean() > part * second.mean()
