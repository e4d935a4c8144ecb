# SPDX-License-Identifier: GPL-3.0-or-later
"""A smooth ball in a sky of many colours, beside Cycles block by block. Imports what needs bpy when it is called."""

from __future__ import annotations

import numpy as np

SIDE, SAMPLES = 48, 512
#: Pixels of a block's side.
BLOCK = 12


def sky(parts, bpy):
    """Smooth in all directions, so that what a lobe's width and tilt do shows, and one bright patch."""
    y, x = np.mgrid[0:64, 0:128]
    turn, height = 2.0 * np.pi * x / 128, np.pi * (y / 64 - 0.5)
    pixels = np.ones((64, 128, 4), np.float32)
    pixels[..., 0] = 0.6 + 0.5 * np.cos(turn)
    pixels[..., 1] = 0.6 + 0.5 * np.sin(turn + 1.0) * np.cos(height)
    pixels[..., 2] = 0.7 + 0.6 * np.sin(height)
    pixels[..., :3] += 6.0 * np.exp(-8.0 * ((turn - 4.0) ** 2 + (height - 0.7) ** 2))[..., None]
    world = parts.grey_world(1.0)
    tree = world.node_tree
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = parts.image("sky", pixels, is_float=True, space="Non-Color")
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    return world


def set_up(blender):
    """A smooth ball seen from the side, in that sky."""
    from support import scenes as parts

    scene = parts.set_up(SIDE, SIDE, SAMPLES)
    scene.world = sky(parts, blender)
    blender.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=1.0, location=(0, 0, 0))
    blender.ops.object.shade_smooth()
    scene.camera.location = (0.0, -5.0, 0.0)
    scene.camera.rotation_euler = (np.pi / 2, 0.0, 0.0)
    scene.camera.data.lens = 80
    return parts


def alike(folder, block: float, floor: float = 0.1, warns: str = "") -> None:
    """Petzval shows what Cycles does, in the mean and block by block; it warns of nothing but what `warns` names."""
    from support import beside_cycles

    beside_cycles.alike(folder, SAMPLES, side=BLOCK, mean=0.01, block=block, floor=floor, bounces=48, warns=warns)
