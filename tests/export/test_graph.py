# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees as the engine's shader graphs: groups, reroutes, muted nodes, defaults, and what the engine makes of them."""

from __future__ import annotations

import importlib
import json

import numpy as np
import pytest


@pytest.fixture
def tree(blender):
    """An empty node tree of a material with its output node: `tree.nodes["out"]`."""
    material = blender.data.materials.new("material")
    if blender.app.version < (5, 0, 0):
        material.use_nodes = True
    material.node_tree.nodes.clear()
    material.node_tree.nodes.new("ShaderNodeOutputMaterial").name = "out"
    return material.node_tree


@pytest.fixture
def describe(blender):
    """The add-on's description of a tree; images are numbered 0."""
    import petzval

    graph = importlib.import_module(f"{petzval.load_addon().__name__}.export.graph")
    return lambda tree: graph.describe(tree, lambda node: 0)


def add(tree, kind, **inputs):
    """A node with some inputs set by name."""
    node = tree.nodes.new(f"ShaderNode{kind}")
    for name, value in inputs.items():
        node.inputs[name].default_value = value
    return node


def show(tree, output):
    """Makes the surface glow with an output."""
    glow = add(tree, "Emission", Strength=1.0)
    tree.links.new(output, glow.inputs["Color"])
    tree.links.new(glow.outputs[0], tree.nodes["out"].inputs["Surface"])


def glow(description):
    """The emission colour of a described surface at position (2, 3, 5)."""
    from petzval import _native

    points = {"position": np.array([[2.0, 3.0, 5.0]], np.float32)}
    answer = _native.evaluate_graph(json.dumps(description), points)
    assert answer["reports"] == []
    (layer,) = answer["surface"]
    return layer["inputs"]["Color"][0].tolist()


def test_a_tree_without_an_output_is_empty(tree, describe):
    tree.nodes.clear()
    assert describe(tree) == {"nodes": [], "surface": None, "volume": None, "displacement": None}


def test_a_node_read_twice_is_described_once(tree, describe):
    geometry = add(tree, "NewGeometry")
    both = add(tree, "VectorMath")
    for socket in both.inputs[:2]:
        tree.links.new(geometry.outputs["Position"], socket)
    show(tree, both.outputs[0])
    description = describe(tree)
    assert sorted(node["type"] for node in description["nodes"]) == [
        "ShaderNodeEmission",
        "ShaderNodeNewGeometry",
        "ShaderNodeVectorMath",
    ]
    assert glow(description) == [4.0, 6.0, 10.0]


def test_what_does_not_reach_the_output_is_left_out(tree, describe):
    add(tree, "TexNoise")
    show(tree, add(tree, "RGB").outputs[0])
    assert {node["type"] for node in describe(tree)["nodes"]} == {"ShaderNodeEmission", "ShaderNodeRGB"}


def scaling_group(bpy):
    """A group that multiplies a vector by a number."""
    group = bpy.data.node_groups.new("scale", "ShaderNodeTree")
    group.interface.new_socket("Vector", in_out="INPUT", socket_type="NodeSocketVector")
    group.interface.new_socket("By", in_out="INPUT", socket_type="NodeSocketFloat")
    group.interface.new_socket("Result", in_out="OUTPUT", socket_type="NodeSocketVector")
    start, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    scale = group.nodes.new("ShaderNodeVectorMath")
    scale.operation = "SCALE"
    group.links.new(start.outputs["Vector"], scale.inputs["Vector"])
    group.links.new(start.outputs["By"], scale.inputs["Scale"])
    group.links.new(scale.outputs[0], end.inputs["Result"])
    return group


def test_a_group_used_twice_is_two_nodes(blender, tree, describe):
    group = scaling_group(blender)
    before = add(tree, "NewGeometry").outputs["Position"]
    for factor in (2.0, 10.0):
        use = add(tree, "Group")
        use.node_tree = group
        use.inputs["By"].default_value = factor
        tree.links.new(before, use.inputs["Vector"])
        before = use.outputs["Result"]
    show(tree, before)
    description = describe(tree)
    assert [node["type"] for node in description["nodes"]].count("ShaderNodeVectorMath") == 2
    assert glow(description) == [40.0, 60.0, 100.0]


def test_reroutes_and_muted_nodes_are_passed(tree, describe):
    geometry, reroute, scale = add(tree, "NewGeometry"), tree.nodes.new("NodeReroute"), add(tree, "VectorMath")
    scale.operation, scale.mute = "SCALE", True
    tree.links.new(geometry.outputs["Position"], reroute.inputs[0])
    tree.links.new(reroute.outputs[0], scale.inputs["Vector"])
    show(tree, scale.outputs[0])
    description = describe(tree)
    assert "ShaderNodeVectorMath" not in {node["type"] for node in description["nodes"]}
    assert glow(description) == [2.0, 3.0, 5.0]


def test_empty_normals_and_coordinates_are_left_to_the_engine(tree, describe):
    diffuse, noise = add(tree, "BsdfDiffuse"), add(tree, "TexNoise")
    tree.links.new(noise.outputs["Color"], diffuse.inputs["Color"])
    tree.links.new(diffuse.outputs[0], tree.nodes["out"].inputs["Surface"])
    inputs = {node["type"]: node["inputs"] for node in describe(tree)["nodes"]}
    assert "Normal" not in inputs["ShaderNodeBsdfDiffuse"]
    assert "Vector" not in inputs["ShaderNodeTexNoise"]
    assert inputs["ShaderNodeTexNoise"]["Scale"] == 5.0


def test_inputs_that_the_options_hide_are_left_out(tree, describe):
    mix = add(tree, "Mix")
    mix.data_type = "RGBA"
    show(tree, next(one for one in mix.outputs if one.identifier == "Result_Color"))
    (described,) = (node for node in describe(tree)["nodes"] if node["type"] == "ShaderNodeMix")
    assert described["inputs"].keys() == {"Factor_Float", "A_Color", "B_Color"}


def test_displacement_and_volume_are_ends_too(tree, describe):
    moved, fog = add(tree, "Displacement", Height=1.0, Scale=1.0), add(tree, "VolumeScatter", Density=0.5)
    tree.links.new(moved.outputs[0], tree.nodes["out"].inputs["Displacement"])
    tree.links.new(fog.outputs[0], tree.nodes["out"].inputs["Volume"])
    description = describe(tree)
    from petzval import _native

    answer = _native.evaluate_graph(json.dumps(description), {"normal": np.array([[0.0, 0.0, 1.0]], np.float32)})
    # Half of the height is its middle.
    assert answer["displacement"].tolist() == [[0.0, 0.0, 0.5]]
    (layer,) = answer["volume"]
    assert layer["kind"] == "VolumeScatter" and layer["inputs"]["Density"].tolist() == [[0.5, 0.5, 0.5]]
    assert answer["surface"] == []


def test_what_the_engine_does_not_know_is_named(tree, describe):
    from petzval import _native

    node = add(tree, "TexIES")
    node.name = "my lamp"
    show(tree, node.outputs[0])
    answer = _native.evaluate_graph(json.dumps(describe(tree)), {"position": np.zeros((1, 3), np.float32)})
    (report,) = answer["reports"]
    assert "my lamp" in report and "ShaderNodeTexIES" in report
    assert answer["surface"][0]["inputs"]["Color"].tolist() == [[0.0, 0.0, 0.0]]


def test_every_shader_node_can_be_described(blender, tree, describe):
    """The options of every node are plain data."""
    made = 0
    for kind in dir(blender.types):
        if not kind.startswith("ShaderNode") or kind.startswith("ShaderNodeOutput"):
            continue
        try:
            node = tree.nodes.new(kind)
        except RuntimeError:
            # A base class.
            continue
        shader = next((socket for socket in node.outputs if socket.enabled), None)
        if shader is None:
            continue
        tree.links.new(shader, tree.nodes["out"].inputs["Surface"])
        json.dumps(describe(tree))
        made += 1
    # Blender 4.5 has 86 with an output.
    assert made > 80
