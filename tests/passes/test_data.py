# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes of data, of shaders' own outputs and for a denoiser, against Cycles in the same Blender."""

from __future__ import annotations

import numpy as np
import pytest


@pytest.fixture
def room(blender):
    import bpy

    from support import render_passes

    scene = render_passes.room()
    layer = scene.view_layers[0]
    layer.use_pass_mist = layer.use_pass_uv = layer.use_pass_object_index = layer.use_pass_material_index = True
    layer.use_pass_ambient_occlusion = True
    layer.cycles.denoising_store_passes = True
    mist = scene.world.mist_settings
    mist.start, mist.depth = 1.5, 6.0
    # What a denoiser is told is behind the glass.
    bpy.data.materials["Glass"].node_tree.nodes["Glass BSDF"].inputs["Roughness"].default_value = 0.0
    bpy.data.objects["Metal"].pass_index, bpy.data.objects["Floor"].pass_index = 7, 300
    bpy.data.materials["Plastic"].pass_index, bpy.data.materials["Matte"].pass_index = 5, 2
    return render_passes


def name_outputs(room, layer):
    """A colour of coordinates, a value through a group, and one that no material gives."""
    import bpy

    for name, kind in (("Tint", "COLOR"), ("Height", "VALUE"), ("Nobody's", "VALUE")):
        one = layer.aovs.add()
        one.name, one.type = name, kind
    tree = bpy.data.materials["Matte"].node_tree
    coordinates, own = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeOutputAOV")
    own.aov_name = "Tint"
    tree.links.new(coordinates.outputs["UV"], own.inputs["Color"])
    inner = bpy.data.node_groups.new("Inner", "ShaderNodeTree")
    inner.interface.new_socket("In", in_out="INPUT", socket_type="NodeSocketVector")
    start, end = inner.nodes.new("NodeGroupInput"), inner.nodes.new("ShaderNodeOutputAOV")
    end.aov_name = "Height"
    inner.links.new(start.outputs[0], end.inputs["Value"])
    tree = bpy.data.materials["Plastic"].node_tree
    group, place = tree.nodes.new("ShaderNodeGroup"), tree.nodes.new("ShaderNodeNewGeometry")
    group.node_tree = inner
    tree.links.new(place.outputs["Position"], group.inputs[0])
    still = bpy.data.materials["Glow"].node_tree.nodes.new("ShaderNodeOutputAOV")
    still.aov_name = "Tint"
    still.inputs["Color"].default_value = (0.25, 4.0, 0.5, 1.0)


def close(room, ours, theirs, name, tolerance) -> None:
    a, b = room.blocks(ours[name]), room.blocks(theirs[name])
    print(name, ours[name].shape, abs(a - b).max(), a.max(), ours[name].mean((0, 1)), theirs[name].mean((0, 1)))
    assert ours[name].shape == theirs[name].shape, name
    assert np.abs(a - b).max() < tolerance * max(1.0, np.abs(b).max()), name


@pytest.mark.parametrize("falloff", ["LINEAR", "QUADRATIC", "INVERSE_QUADRATIC"])
def test_mist_places_and_indices(room, tmp_path, falloff):
    import bpy

    scene = bpy.context.scene
    scene.world.mist_settings.falloff = falloff
    name_outputs(room, scene.view_layers[0])
    ours = room.photograph(tmp_path / "petzval.exr", samples=64)
    theirs = room.photograph(tmp_path / "cycles.exr", "CYCLES", samples=64)
    # Blender 5.2's Denoise node does not ask for these two.
    assert ours.keys() == theirs.keys() - {"Denoising Specular Albedo", "Denoising Roughness"}
    for name in ("Mist", "UV", "Tint", "Height", "Nobody's", "Ambient Occlusion"):
        # 64 samples a pixel at edges, 256 pixels a block.
        close(room, ours, theirs, name, 0.01)
    for name in ("Denoising Albedo", "Denoising Normal"):
        close(room, ours, theirs, name, 0.02)
    # Where there is nothing Cycles has a number that no mean survives.
    depth = {"Denoising Depth": np.where(theirs["Denoising Depth"] < 1e6, theirs["Denoising Depth"], 0.0)}
    depths = {"Denoising Depth": np.where(depth["Denoising Depth"] > 0.0, ours["Denoising Depth"], 0.0)}
    close(room, depths, depth, "Denoising Depth", 0.02)
    for name in ("Object Index", "Material Index"):
        a, b = ours[name], theirs[name]
        # Cycles takes a pixel's first sample, we what most of them met: edges differ.
        assert (a == b).mean() > 0.93 and set(np.unique(a)) == set(np.unique(b)), name
    assert not scene_warnings(), scene_warnings()


def scene_warnings():
    from support import scenes

    return scenes.part("render.statistics").last("Scene").warnings


@pytest.mark.parametrize("what", ["seen", "hidden from the camera", "behind a transparent film"])
def test_world_aovs(blender, parts, tmp_path, what):
    """Where a camera ray ends in the sky, transparent surfaces passed: what Cycles writes, which runs the world's nodes where their colour varies."""
    import bpy

    from support import render_passes

    scene = parts.set_up(render_passes.WIDTH, render_passes.HEIGHT)
    scene.world = bpy.data.worlds.new("Sky")
    scene.world.use_nodes = True
    tree = scene.world.node_tree
    place, split = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(place.outputs["Generated"], split.inputs[0])
    tree.links.new(place.outputs["Generated"], tree.nodes["Background"].inputs["Color"])
    for name, kind, socket, source in (
        ("Way", "COLOR", "Color", place.outputs["Generated"]),
        ("Height", "VALUE", "Value", split.outputs["Z"]),
    ):
        made, node = scene.view_layers[0].aovs.add(), tree.nodes.new("ShaderNodeOutputAOV")
        made.name, made.type, node.aov_name = name, kind, name
        tree.links.new(source, node.inputs[socket])
    for x, is_clear in ((-1.0, True), (1.0, False)):
        bpy.ops.mesh.primitive_cube_add(size=1.2, location=(x, 5.0, 0.0))
        material, nodes, surface = parts.material(f"At {x}")
        if is_clear:
            nodes.links.new(nodes.nodes.new("ShaderNodeBsdfTransparent").outputs[0], surface)
        bpy.context.object.data.materials.append(material)
    scene.world.cycles_visibility.camera = what != "hidden from the camera"
    scene.render.film_transparent = what == "behind a transparent film"
    ours = render_passes.photograph(tmp_path / "petzval.exr", samples=16)
    theirs = render_passes.photograph(tmp_path / "cycles.exr", "CYCLES", samples=16)
    if what == "seen":
        assert theirs["Way"][..., 1].max() > 0.9
        assert np.ptp(theirs["Height"]) > 0.3
    for name in ("Way", "Height"):
        # 16 samples a pixel at the edges of one cube, 256 pixels a block.
        close(render_passes, ours, theirs, name, 0.01)
    assert not scene_warnings()
