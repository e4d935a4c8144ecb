# SPDX-License-Identifier: GPL-3.0-or-later
"""Kinds of rays against Cycles in the same Blender: who sees what, what lights reach, and how often light bounces."""

from __future__ import annotations

import pytest

from support.ball_row import add_panel, alike, differs, shaded
from support.node_tree import Tree


@pytest.mark.parametrize("kind", ["camera", "diffuse", "glossy", "transmission", "shadow"])
def test_objects_hide(room, blender, tmp_path, kind):
    panel = add_panel(room)
    # Between the lamp and the floor, for its shadow; and not seen from below, so that its glow is.
    screen = room.mesh_object(
        "Screen", [(-0.6, -2.5, 2), (1.4, -2.5, 2), (1.4, -0.6, 2), (-0.6, -0.6, 2)], [(0, 1, 2, 3)],
        shaded(room, "BsdfDiffuse"),
    )  # fmt: skip
    for one in (panel, screen):
        setattr(one, f"visible_{kind}", False)
    ours = alike(tmp_path)
    for one in (panel, screen):
        setattr(one, f"visible_{kind}", True)
    # Little of the panel is seen through the glass.
    differs(ours, room.render(tmp_path, "all.exr")[..., :3], 0.002)


@pytest.mark.first_only("kind")
@pytest.mark.parametrize("kind", ["camera", "diffuse", "glossy", "shadow"])
@pytest.mark.parametrize("instance", ["MESH", "LIGHT"])
def test_instancers_hide(room, blender, tmp_path, kind, instance):
    """What an instance and its instancer both allow."""
    one = add_panel(room) if instance == "MESH" else room.lamp
    if instance == "MESH":
        one.location = (0.0, -0.4, 2.4)
    setattr(instanced(blender, one), f"visible_{kind}", False)
    alike(tmp_path)


@pytest.mark.parametrize("is_instancer", [False, True])
def test_instancers_hold_out(room, blender, tmp_path, is_instancer):
    """The instancer says whether its instances hold out; they themselves do not."""
    panel = add_panel(room)
    instancer = instanced(blender, panel)
    (instancer if is_instancer else panel).is_holdout = True
    alike(tmp_path)


def instanced(blender, one):
    """An object that shows another, which is seen nowhere else."""
    shown = blender.data.collections.new("Shown")
    blender.context.scene.collection.objects.unlink(one)
    shown.objects.link(one)
    instancer = blender.data.objects.new("Instancer", None)
    instancer.instance_type, instancer.instance_collection = "COLLECTION", shown
    blender.context.scene.collection.objects.link(instancer)
    return instancer


@pytest.mark.first_only("kind")
@pytest.mark.parametrize("kind", ["camera", "diffuse", "glossy", "transmission"])
@pytest.mark.first_only("lamp")
@pytest.mark.parametrize("lamp", ["AREA", "SUN", "POINT"])
def test_lamps_reach(room, blender, tmp_path, kind, lamp):
    room.lamp.data.type = lamp
    if lamp == "SUN":
        room.lamp.data.energy, room.lamp.data.angle = 2.0, 0.3
        room.lamp.rotation_euler = (0.6, 0.3, 0.0)
    elif lamp == "POINT":
        room.lamp.data.shadow_soft_size = 0.4
        room.lamp.location = (1.0, 0.5, 3.2)
    setattr(room.lamp, f"visible_{kind}", False)
    alike(tmp_path)


@pytest.mark.first_only("kind")
@pytest.mark.parametrize("kind", ["camera", "diffuse", "glossy", "transmission"])
def test_worlds_show(room, blender, tmp_path, kind):
    room.lamp.data.energy = 20.0
    blender.context.scene.world = room.grey_world(0.8)
    setattr(blender.context.scene.world.cycles_visibility, kind, False)
    alike(tmp_path)


OUTPUTS = (
    "Is Camera Ray", "Is Shadow Ray", "Is Diffuse Ray", "Is Glossy Ray", "Is Singular Ray", "Is Reflection Ray",
    "Is Transmission Ray", "Ray Length", "Ray Depth", "Diffuse Depth", "Glossy Depth", "Transparent Depth",
    "Transmission Depth",
)  # fmt: skip


@pytest.mark.first_only("output")
@pytest.mark.parametrize("output", OUTPUTS)
def test_light_path(room, blender, tmp_path, output):
    """A panel whose colour tells of the path, before the balls' mirrors; and one that lets light through by it."""
    panel = add_panel(room)
    made, tree, surface = room.material("told")
    t = Tree(tree, surface)
    told = t.node("Math", {"operation": "MULTIPLY"}, _0=t.node("LightPath").outputs[output], _1=0.3)
    told = t.node("Math", {"operation": "MINIMUM"}, _0=told.outputs[0], _1=0.9)
    colour = t.node("CombineColor", Red=told.outputs[0], Green=0.5, Blue=0.3)
    matte = t.node("BsdfDiffuse", Color=colour.outputs[0])
    clear = t.node("BsdfTransparent")
    t.shows(t.node("MixShader", _0=told.outputs[0], _1=clear.outputs[0], _2=matte.outputs[0]).outputs[0])
    panel.data.materials[0] = made
    # So that light comes through it, and what is behind it is seen.
    panel.location = (0.4, -0.9, 2.2)
    panel.rotation_euler = (1.2, 0.0, 0.0)
    panel.scale = (0.5, 0.5, 0.5)
    room.lamp.location = (0.4, -1.0, 4.0)
    alike(tmp_path)


@pytest.mark.once
@pytest.mark.parametrize("output", ["Is Glossy Ray", "Is Singular Ray", "Is Transmission Ray", "Ray Depth"])
def test_light_path_in_a_world(room, blender, tmp_path, output):
    world = blender.data.worlds.new("told")
    tree = room.with_nodes(world)
    t = Tree(tree, tree.nodes.new("ShaderNodeOutputWorld").inputs["Surface"])
    told = t.node("LightPath").outputs[output]
    one = t.node("Background", Color=(0.2, 0.3, 0.9, 1.0), Strength=0.7)
    other = t.node("Background", Color=(0.9, 0.4, 0.1, 1.0), Strength=1.5)
    t.shows(t.node("MixShader", _0=told, _1=one.outputs[0], _2=other.outputs[0]).outputs[0])
    blender.context.scene.world = world
    # What light samples find of a world is counted otherwise than what rays find, in Cycles as well.
    world.cycles.sampling_method = "NONE"
    room.lamp.data.energy = 20.0
    blender.data.objects["Metal"].data.materials[0] = shaded(room, "BsdfAnisotropic", Roughness=0.0)
    alike(tmp_path)


@pytest.mark.first_only("limits")
@pytest.mark.parametrize(
    "limits",
    [
        {"diffuse_bounces": 0},
        {"glossy_bounces": 0},
        {"transmission_bounces": 1},
        {"max_bounces": 1},
        {"caustics_reflective": False},
        {"caustics_refractive": False},
        {"caustics_reflective": False, "caustics_refractive": False},
    ],
    ids=lambda limits: " ".join(limits),
)
def test_bounces(room, blender, tmp_path, limits):
    """As many of each kind as Cycles's settings say."""
    add_panel(room)
    for name in ("Glass", "Metal"):
        ball = blender.data.objects[name]
        # Rough, so that light samples find their caustics.
        ball.data.materials[0].node_tree.nodes[1].inputs["Roughness"].default_value = 0.4
    # Light through rough glass: see docs/design/closures.md.
    alike(tmp_path, **limits, mean=0.015, block=0.05)


@pytest.mark.parametrize("limit", [1, 2, 3])
def test_transparent_bounces(room, blender, tmp_path, limit):
    """Leaves that light shines through, one behind the other."""
    clear = shaded(room, "BsdfTransparent", Color=(0.9, 0.7, 0.6, 1.0))
    for place in range(3):
        room.square(f"Leaf {place}", (0.0, -1.2 - 0.4 * place, 1.2), 1.6 - 0.4 * place, clear)
    shade = room.mesh_object("Roof", [(-2, -3, 2), (2, -3, 2), (2, 1, 2), (-2, 1, 2)], [(0, 1, 2, 3)], clear)
    shade.visible_camera = False
    alike(tmp_path, transparent_max_bounces=limit)


@pytest.mark.first_only("bounces")
@pytest.mark.parametrize("bounces", [0, 1])
def test_lamps_of_few_bounces(room, blender, tmp_path, bounces):
    room.lamp.data.cycles.max_bounces = bounces
    ours = alike(tmp_path)
    room.lamp.data.cycles.max_bounces = 1024
    differs(ours, room.render(tmp_path, "all.exr")[..., :3])
