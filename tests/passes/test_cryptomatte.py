# SPDX-License-Identifier: GPL-3.0-or-later
"""Cryptomatte against Cycles in the same Blender, and through a lens against the picture's own brightness."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from support.multilayer import mattes, photograph

LAYERS = ("Object", "Material", "Asset")


def metadata(data: bytes) -> dict[str, str]:
    """The file's attributes that are of Cryptomatte."""
    found, at = {}, 0
    while (at := data.find(b"cryptomatte/", at)) >= 0:
        end = data.index(0, at)
        start = data.index(0, end + 1) + 1
        size = int.from_bytes(data[start : start + 4], "little")
        found[data[at:end].decode()] = data[start + 4 : start + 4 + size].decode()
        at = start + 4 + size
    return found


def test_as_cycles_has_it(parts, blender, tmp_path):
    """The same ids bit for bit, the same coverage within noise, the same metadata."""
    scene = parts.set_up(width=48, height=32)
    wall = parts.square("Wall", (0.3, 5, 0.2), 1.5, parts.emitter(name="Glow"))
    parts.square("W\u00e4nd", (-1.0, 1.0, 0.1), 1.6, parts.emitter(name="Gl\u00fch")).parent = wall
    parts.square("Bare", (-1.4, 4, -0.6), 0.9)
    # Its hash is no ordinary float before the specification's repair.
    parts.square("Cube 137", (1.3, 4, -0.5), 0.8, parts.emitter(name="Glow 2"))
    part = parts.square("Part", (1.2, 4, 0.7), 0.7, scene_glass(parts))
    group = blender.data.collections.new("Group")
    group.objects.link(part)
    scene.collection.objects.unlink(part)
    scene.collection.children.link(group)
    placed = blender.data.objects.new("Placed", None)
    placed.instance_type, placed.instance_collection = "COLLECTION", group
    placed.location = (-2.0, 0.0, 0.0)
    scene.collection.objects.link(placed)
    layer = scene.view_layers[0]
    for name in LAYERS:
        setattr(layer, f"use_pass_cryptomatte_{name.lower()}", True)
    layer.pass_cryptomatte_depth = 4
    ours, our_file = photograph(parts, scene, tmp_path / "petzval.exr")
    theirs, their_file = photograph(parts, scene, tmp_path / "cycles.exr", "CYCLES")
    assert {name for name in theirs if "crypto" in name} == {name for name in ours if "crypto" in name}
    for name in LAYERS:
        expected, found = mattes(theirs, name), mattes(ours, name)
        assert expected.keys() == found.keys()
        for which in expected:
            error = found[which] - expected[which]
            # 64 samples of a half covered pixel: 0.06 each; their means over some hundred pixels.
            assert np.abs(error).max() < 0.35, (name, which)
            assert abs(error.mean()) < 0.002, (name, which)
    said, cycles_said = metadata(our_file), metadata(their_file)
    assert said.keys() == cycles_said.keys() and len(said) == 12
    for key, value in said.items():
        if key.endswith("manifest"):
            manifest, names = json.loads(value), json.loads(cycles_said[key])
            # Cycles writes hashes before their repair: theirs of "Cube 137" is 801c212a, which no pixel holds.
            assert manifest == {name: repaired(names[name]) for name in manifest}
            layer_name = said[key.removesuffix("manifest") + "name"].partition(".Crypto")[2]
            assert mattes(ours, layer_name).keys() <= {int(digits, 16) for digits in manifest.values()}
        else:
            assert value == cycles_said[key]


def repaired(digits: str) -> str:
    bits = int(digits, 16)
    return f"{bits ^ 1 << 23 if bits >> 23 & 255 in (0, 255) else bits:08x}"


def scene_glass(parts):
    """Half transparent."""
    made, tree, surface = parts.material("Half")
    node = tree.nodes.new("ShaderNodeBsdfPrincipled")
    node.inputs["Alpha"].default_value = 0.5
    tree.links.new(node.outputs[0], surface)
    return made


@pytest.mark.parametrize("pipeline", ["FILM", "HERO", "SCENE"])
def test_blurred_as_the_picture_is(parts, blender, tmp_path, pipeline):
    """A white square far out of focus before black: it covers of a pixel what it lights of it."""
    scene = parts.set_up(width=36, height=24, model="LENS")
    scene.world = parts.grey_world(0.0)
    own = scene.camera.data.petzval
    own.lens_file = "double-gauss-f2-tronnier.lens"
    own.film_mode, own.film_width, own.film_height = "SIZE", 36.0, 24.0
    own.focal_mode, own.focal_length = "LENGTH", 85.0
    scene.petzval.pipeline = pipeline
    scene.camera.data.dof.focus_distance = 1.0
    glow = parts.emitter()
    parts.square("White", (0.05, 2.0, 0.02), 0.25, glow)
    layer = scene.view_layers[0]
    layer.use_pass_cryptomatte_object = True
    ours, _ = photograph(parts, scene, tmp_path / "square.exr", samples=256)
    covered = mattes(ours, "Object")
    assert len(covered) == 1
    covered = next(iter(covered.values()))
    parts.square("All", (0.0, 2.01, 0.0), 9.0, glow)
    whole, _ = photograph(parts, scene, tmp_path / "whole.exr", samples=64)
    expected = ours["combined.g"] / whole["combined.g"]
    assert 0.1 < covered.mean() < 0.5 and (covered > 0.98).sum() > 20
    partly = (covered > 0.1) & (covered < 0.9)
    assert partly.sum() > 50
    # 256 rays of a half covered pixel: 0.03, more where each has one wavelength; and light counts by its slant, a few per
    # cent at f/2.
    assert np.abs(covered - expected).max() < 0.25
    assert math.sqrt(np.mean((covered - expected)[partly] ** 2)) < 0.06
    assert abs((covered - expected).mean()) < 0.005


def test_the_compositor_picks_by_name(parts, blender, tmp_path):
    """Blender's own node finds a matte of the render by its name."""
    scene = parts.set_up(width=24, height=16)
    parts.square("One", (-0.6, 5, 0), 1.0, parts.emitter())
    parts.square("Two", (0.6, 5, 0), 1.0, parts.emitter())
    scene.view_layers[0].use_pass_cryptomatte_object = True
    if blender.app.version >= (5, 0, 0):
        tree = scene.compositing_node_group = blender.data.node_groups.new("Compositing", "CompositorNodeTree")
        tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
        out = tree.nodes.new("NodeGroupOutput")
    else:
        scene.use_nodes = True
        tree = scene.node_tree
        tree.nodes.clear()
        out = tree.nodes.new("CompositorNodeComposite")
    node = tree.nodes.new("CompositorNodeCryptomatteV2")
    node.scene = scene
    node.matte_id = "Two"
    tree.links.new(node.outputs["Matte"], out.inputs[0])
    scene.render.use_compositing = True
    matte = parts.render(tmp_path)[..., 0]
    assert matte[8, 15] == 1.0 and matte[8, 8] == 0.0
    assert matte.sum() == pytest.approx((24 * 50 / 36 / 5) ** 2, rel=0.1)
