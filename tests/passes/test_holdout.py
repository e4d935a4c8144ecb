# SPDX-License-Identifier: GPL-3.0-or-later
"""Holes: the Holdout shader, objects and collections that hold out, and what only bounces see; against Cycles."""

from __future__ import annotations

import numpy as np
import pytest


@pytest.fixture
def room(blender):
    import bpy

    from support import render_passes

    scene = render_passes.room()
    scene.render.film_transparent = True
    scene.view_layers[0].use_pass_z = False
    # Of what holds out nothing but what it reflects and shades is left.
    bpy.data.materials["Matte"].node_tree.nodes["Diffuse BSDF"].inputs["Color"].default_value = (0.8, 0.8, 0.8, 1.0)
    return render_passes


def by_shader(room):
    import bpy

    bpy.data.objects["Plastic"].data.materials[0] = room.surface("Hole", "Holdout")


def by_half_a_shader(room):
    import bpy

    hole = room.mixed("Hole", 0.4, "BsdfDiffuse", "Holdout", Color=(0.9, 0.5, 0.2, 1.0))
    bpy.data.objects["Plastic"].data.materials[0] = hole


def behind_a_pane(room):
    from support import scenes as parts

    by_object(room)
    parts.square("Air", (0.0, 1.5, 0.4), 1.0, room.mixed("Half", 0.5, "BsdfDiffuse", "BsdfTransparent"))


def by_object(room):
    import bpy

    bpy.data.objects["Plastic"].is_holdout = bpy.data.objects["Panel"].is_holdout = True


def by_collection(room, state="holdout"):
    import bpy

    scene = bpy.context.scene
    holes = bpy.data.collections.new("Holes")
    scene.collection.children.link(holes)
    for name in ("Metal", "Panel"):
        one = bpy.data.objects[name]
        holes.objects.link(one)
        scene.collection.objects.unlink(one)
    setattr(scene.view_layers[0].layer_collection.children["Holes"], state, True)


def by_instance(room):
    import bpy

    scene = bpy.context.scene
    source = bpy.data.collections.new("Source")
    one = bpy.data.objects["Metal"]
    source.objects.link(one)
    scene.collection.objects.unlink(one)
    holes = bpy.data.collections.new("Holes")
    scene.collection.children.link(holes)
    for place, parent in ((-0.2, holes), (1.2, scene.collection)):
        placed = bpy.data.objects.new("Placed", None)
        placed.instance_type, placed.instance_collection = "COLLECTION", source
        placed.location.x = place
        parent.objects.link(placed)
    scene.view_layers[0].layer_collection.children["Holes"].holdout = True


def seen_by_bounces_alone(room):
    by_collection(room, "indirect_only")


WAYS = [by_shader, by_half_a_shader, by_object, behind_a_pane, by_collection, by_instance, seen_by_bounces_alone]


@pytest.mark.parametrize("hold_out", WAYS)
def test_holes_are_as_cycles_has_them(room, tmp_path, hold_out):
    from support import scenes

    hold_out(room)
    ours = room.photograph(tmp_path / "petzval.exr", samples=128)
    theirs = room.photograph(tmp_path / "cycles.exr", "CYCLES", samples=128)
    a, b = ours["Combined"], theirs["Combined"]
    apart = np.abs(room.blocks(a) - room.blocks(b)) / (room.blocks(b) + 0.2)
    print(apart.max((0, 1)), np.abs(a[..., 3].mean() - b[..., 3].mean()))
    # 128 samples: 1 per cent of a block's light, less of its alpha.
    assert apart[..., :3].max() < 0.03 and apart[..., 3].max() < 0.005
    assert np.abs(a.mean((0, 1)) / b.mean((0, 1)) - 1.0).max() < 0.01
    assert not scenes.part("render.statistics").last("Scene").warnings


def test_without_a_transparent_film_holes_are_there_all_the_same(room, tmp_path):
    import bpy

    bpy.context.scene.render.film_transparent = False
    by_object(room)
    ours = room.photograph(tmp_path / "petzval.exr", samples=64)["Combined"]
    theirs = room.photograph(tmp_path / "cycles.exr", "CYCLES", samples=64)["Combined"]
    assert 0.8 < theirs[..., 3].mean() < 0.97
    assert np.abs(room.blocks(ours) - room.blocks(theirs)).max() < 0.02
