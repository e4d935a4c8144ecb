# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of objects, materials and layers that few scenes change, against Cycles in the same Blender."""

from __future__ import annotations

import pytest

from support.ball_row import alike, differs, shaded
from support.node_tree import Tree


@pytest.mark.once
@pytest.mark.parametrize("is_uneven", [False, True])
def test_fog_that_throws_no_shadow(room, blender, tmp_path, is_uneven):
    """Neither on itself nor on what stands in it."""
    blender.ops.mesh.primitive_cube_add(size=2.4, location=(0.0, -0.4, 1.2))
    fog, tree, surface = room.material("Fog")
    nodes = Tree(tree, surface)
    # Cycles looks for the largest density on a grid of its own: even fog is exact.
    density = nodes.math("ADD", nodes.node("SeparateXYZ", Vector=nodes.coordinates("Generated")).outputs["X"], 0.5)
    shader = nodes.node("VolumeScatter", None, Density=density if is_uneven else 1.0, Color=(0.9, 0.9, 0.9, 1.0))
    tree.links.new(shader.outputs[0], surface.node.inputs["Volume"])
    holder = blender.context.object
    holder.data.materials.append(fog)
    blender.context.scene.cycles.volume_bounces = 1
    holder.visible_shadow = False
    # Noise of fog.
    ours = alike(tmp_path, mean=0.015, block=0.06)
    holder.visible_shadow = True
    differs(ours, room.render(tmp_path, "shadows.exr")[..., :3])


@pytest.mark.once
@pytest.mark.parametrize("shader", ["BsdfDiffuse", "BsdfAnisotropic"])
@pytest.mark.parametrize("shape", ["THICK", "RIBBONS"])
def test_light_at_a_slant_is_dimmed_on_hair(room, blender, tmp_path, shape, shader):
    """Shading Offset is of faces and of strands."""
    from parity_scenes.hair import grown

    scene = blender.context.scene
    scene.cycles_curves.shape = shape
    hair = grown(60, 4, 0.9, 0.1, shaded(room, shader), bend=1.0)
    hair.location = (0.0, -1.6, 0.4)
    hair.shadow_terminator_shading_offset = 0.6
    ours = alike(tmp_path, mean=0.015, block=0.05)
    hair.shadow_terminator_shading_offset = 0.0
    differs(ours, room.render(tmp_path, "plain.exr")[..., :3])


@pytest.mark.once
def test_what_is_transparent_throws_a_full_shadow(room, blender, tmp_path):
    """Where its material says so: light samples stop there, and what the camera sees goes on through it."""
    clear = shaded(room, "BsdfTransparent", Color=(0.9, 0.6, 0.4, 1.0))
    room.mesh_object("Roof", [(-2, -3, 2), (2, -3, 2), (2, 1, 2), (-2, 1, 2)], [(0, 1, 2, 3)], clear)
    clear.use_transparent_shadow = False
    # Directions that find the lamp are through the pane in both programs: noise.
    ours = alike(tmp_path, mean=0.015, block=0.06)
    clear.use_transparent_shadow = True
    differs(ours, room.render(tmp_path, "clear.exr")[..., :3], 0.05)


@pytest.mark.once
def test_a_layer_without_motion_blur(room, blender, tmp_path):
    """It is sharp, and as the frame has it, not the middle of the exposure."""
    scene, ball = blender.context.scene, blender.data.objects["Matte"]
    for frame, x in ((1, -2.9), (2, -1.4)):
        ball.location.x = x
        ball.keyframe_insert("location", frame=frame)
    scene.frame_set(1)
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    scene.render.motion_blur_position = "START"
    blurred = room.render(tmp_path, "blurred.exr")[..., :3]
    blender.context.view_layer.use_motion_blur = False
    differs(alike(tmp_path), blurred, 0.05)


@pytest.mark.once
def test_the_bump_of_a_steep_displacement_in_a_coarse_picture(room, blender, tmp_path):
    """Its slopes are of a point, not of a pixel: hills here are four pixels wide."""
    hills, tree, surface = room.material("Hills")
    hills.displacement_method = "BUMP"
    nodes = Tree(tree, surface)
    height = nodes.node("TexNoise", Vector=nodes.coordinates("Object"), Scale=2.0).outputs[0]
    nodes.lifts(nodes.node("Displacement", Height=height, Midlevel=0.5, Scale=1.0).outputs[0])
    nodes.shows(nodes.node("BsdfDiffuse", Color=(0.8, 0.8, 0.8, 1.0)).outputs[0])
    room.floor.data.materials[0] = hills
    ours = alike(tmp_path)
    hills.node_tree.nodes["Displacement"].inputs["Scale"].default_value = 0.0
    differs(ours, room.render(tmp_path, "flat.exr")[..., :3], 0.05)
