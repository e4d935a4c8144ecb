# SPDX-License-Identifier: GPL-3.0-or-later
"""A floor, a wall and a ball in a dim sky, lit by lamps with nodes of their own. Imports what needs bpy when it is called."""

from __future__ import annotations

from support.ball_row import shaded
from support.node_tree import Tree

SIDE, SAMPLES = 32, 1024
KINDS = {
    "POINT": {"shadow_soft_size": 0.3},
    "SPOT": {"shadow_soft_size": 0.1, "spot_size": 1.4, "spot_blend": 0.4},
    "SUN": {"angle": 0.2},
    "AREA": {"shape": "RECTANGLE", "size": 1.5, "size_y": 0.8, "spread": 2.4},
    "POINT without size": {"shadow_soft_size": 0.0},
    "POINT, soft": {"shadow_soft_size": 0.4, "use_soft_falloff": True},
    "AREA, round": {"shape": "DISK", "size": 1.0},
}


def set_up(blender):
    """A matte floor, a wall and a ball, in a dim sky: what no lamp reaches is not dark."""
    from support import scenes as parts

    scene = parts.set_up(SIDE, SIDE, SAMPLES)
    scene.world = parts.grey_world(0.3)
    scene.camera.location, scene.camera.rotation_euler = (0.0, -8.0, 3.5), (1.2, 0.0, 0.0)
    scene.camera.data.lens = 45
    matte = shaded(parts, "BsdfDiffuse")
    parts.mesh_object("Floor", [(-6, -6, 0), (6, -6, 0), (6, 6, 0), (-6, 6, 0)], [(0, 1, 2, 3)], matte)
    parts.mesh_object("Wall", [(-6, 3, 0), (6, 3, 0), (6, 3, 8), (-6, 3, 8)], [(0, 1, 2, 3)], matte)
    blender.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, radius=0.8, location=(-1.5, 0, 0.85))
    blender.ops.object.shade_smooth()
    blender.context.object.data.materials.append(shaded(parts, "BsdfAnisotropic", Roughness=0.4))
    return parts


def lamp(blender, kind: str, build=None):
    """A lamp before the camera, turned, with nodes that `build` makes."""
    light = blender.data.lights.new("Lamp", kind.split()[0].strip(","))
    for name, value in KINDS[kind].items():
        setattr(light, name, value)
    light.energy = 4.0 if light.type == "SUN" else 300.0
    light.color = (1.0, 0.9, 0.7)
    holder = blender.data.objects.new("Lamp", light)
    holder.location, holder.rotation_euler = (0.6, 0.4, 2.6), (0.5, 0.3, 0.6)
    blender.context.scene.collection.objects.link(holder)
    if build is not None:
        light.use_nodes = True
        tree = light.node_tree
        tree.nodes.clear()
        build(Tree(tree, tree.nodes.new("ShaderNodeOutputLight").inputs["Surface"]))
    return holder


def panel(studio):
    """An emitter that is a mesh."""
    made = studio.square("Panel", (1.6, -0.8, 2.2), 1.5, studio.emitter((0.4, 0.7, 1.0), 60.0))
    made.rotation_euler = (0.8, 0.0, 0.5)
    return made
