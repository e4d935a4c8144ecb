# SPDX-License-Identifier: GPL-3.0-or-later
"""Adaptive subdivision, as the engine is told of it: the cage of a Subdivision Surface, and how finely it is to be divided."""

from __future__ import annotations

import numpy as np
import pytest


def raised(blender) -> object:
    """A material that moves vertices."""
    surface = blender.data.materials.new("Raised")
    surface.use_nodes, surface.displacement_method = True, "DISPLACEMENT"
    nodes, links = surface.node_tree.nodes, surface.node_tree.links
    end = nodes.new("ShaderNodeDisplacement")
    end.inputs["Height"].default_value = 1.5
    links.new(end.outputs[0], nodes["Material Output"].inputs["Displacement"])
    return surface


@pytest.fixture
def square(parts, blender):
    """A square of one face with a Subdivision Surface that is adaptive."""
    scene = parts.set_up(32, 32, samples=1)
    blender.ops.mesh.primitive_plane_add(size=2.0)
    made = blender.context.object
    made.data.materials.append(raised(blender))
    modifier = made.modifiers.new("Adaptive", "SUBSURF")
    modifier.subdivision_type, modifier.levels, modifier.render_levels = "SIMPLE", 2, 5
    if hasattr(modifier, "use_adaptive_subdivision"):
        modifier.use_adaptive_subdivision = True
    else:
        scene.cycles.feature_set, made.cycles.use_adaptive_subdivision = "EXPERIMENTAL", True
    scene.cycles.dicing_rate, scene.cycles.offscreen_dicing_scale, scene.cycles.max_subdivisions = 2.0, 3.0, 9
    return made


def sent(parts) -> dict:
    recorder, warnings, _ = parts.sent()
    assert not warnings
    (mesh,) = recorder.meshes
    return mesh


def test_the_cage_is_sent_with_its_dicing(parts, square):
    mesh = sent(parts)
    assert len(mesh["triangles"]) == 2 and len(mesh["uv_maps"]["UVMap"][1]) == 4
    assert mesh["dicing"][:4] == (True, 2.0, 3.0, 9)
    # More than a megabyte of memory has room for, and no more than a limit has.
    assert mesh["dicing"][4] > 4000
    parts_of = parts.part("export.memory")
    room = parts_of.Room(1e-3)
    room.take("Square", 1000)
    assert room.left_triangles() == 3000
    modifier = square.modifiers[-1]
    assert (modifier.levels, modifier.render_levels) == (2, 5)


def test_what_is_rounded_is_sent_round(parts, blender, square):
    blender.data.objects.remove(square)
    blender.ops.mesh.primitive_cube_add(size=2.0)
    blender.context.object.data.materials.append(raised(blender))
    modifier = blender.context.object.modifiers.new("Adaptive", "SUBSURF")
    if hasattr(modifier, "use_adaptive_subdivision"):
        modifier.use_adaptive_subdivision = True
    else:
        blender.context.object.cycles.use_adaptive_subdivision = True
    mesh = sent(parts)
    assert len(mesh["triangles"]) == 2 * 6 * 4**5
    # The limit surface of a cube is nearly a ball.
    assert np.ptp(np.linalg.norm(mesh["positions"], axis=1)) < 0.15


def test_other_modifiers_and_settings_stay_as_they_are(parts, square):
    modifier = square.modifiers[-1]
    square.modifiers.new("Edges", "TRIANGULATE")
    assert sent(parts)["dicing"] is None
    square.modifiers.remove(square.modifiers[-1])
    modifier.show_render = False
    mesh = sent(parts)
    assert mesh["dicing"] is None and len(mesh["triangles"]) == 2
    modifier.show_render = True
    if hasattr(modifier, "adaptive_space"):
        modifier.adaptive_pixel_size = 3.0
        assert sent(parts)["dicing"][:4] == (True, 6.0, 3.0, 9)
        modifier.adaptive_space, modifier.adaptive_object_edge_length = "OBJECT", 0.25
        assert sent(parts)["dicing"][:4] == (False, 0.25, 3.0, 9)
        modifier.use_adaptive_subdivision = False
    else:
        square.cycles.dicing_rate = 3.0
        assert sent(parts)["dicing"][:4] == (True, 6.0, 3.0, 9)
        square.cycles.use_adaptive_subdivision = False
    mesh = sent(parts)
    assert mesh["dicing"] is None and len(mesh["triangles"]) == 2 * 4**5


def test_what_moves_is_divided_and_displaced(parts, blender, square, tmp_path):
    """Its shapes at other times are those of the whole modifier, and so is the one that is divided."""
    scene = blender.context.scene
    scene.render.use_motion_blur, scene.world = True, parts.grey_world(1.0)
    square.rotation_euler = (np.pi / 2, 0.0, 0.0)
    for frame, x in ((0, -0.5), (2, 0.5)):
        square.location = (x, 5.0, 0.0)
        square.keyframe_insert("location", frame=frame)
    assert np.isfinite(parts.render(tmp_path, "moving.exr")).all()
    assert not parts.part("render.statistics").last(scene.name).warnings


def test_without_displacement_the_modifier_counts(parts, square):
    square.material_slots[0].material.displacement_method = "BUMP"
    mesh = sent(parts)
    assert mesh["dicing"] is None and len(mesh["triangles"]) == 2 * 4**5
    square.modifiers[-1].subdivision_type = "CATMULL_CLARK"
    _, warnings, _ = parts.sent()
    assert any("without displacement" in line for line in warnings)


def test_the_dicing_camera_is_sent(parts, blender, square):
    """Where it is another than the scene's; nothing is named."""
    scene = blender.context.scene
    other = blender.data.objects.new("Above", blender.data.cameras.new("Above"))
    scene.collection.objects.link(other)
    of = parts.part("export.dicing").camera
    found = []
    for holder in (None, scene.camera, other):
        scene.cycles.dicing_camera = holder
        scene.update_tag()
        chosen = of(blender.context.evaluated_depsgraph_get())
        found.append(chosen and chosen.name)
    assert found == [None, None, "Above"]
    _, warnings, _ = parts.sent()
    assert not any("'Above'" in line for line in warnings)
