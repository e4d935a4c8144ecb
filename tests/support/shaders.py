# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes and materials in few words. Imports bpy when it is called."""

from __future__ import annotations

import numpy as np

from support.node_tree import Tree

RED, GOLD, GREEN = (0.9, 0.3, 0.2, 1.0), (0.9, 0.6, 0.2, 1.0), (0.3, 0.8, 0.4, 1.0)
WHITE = (1.0, 1.0, 1.0, 1.0)


def node(tree, kind: str, settings: dict | None = None, **inputs):
    """A shader node's output."""
    made = tree.nodes.new(f"ShaderNode{kind}")
    for name, value in (settings or {}).items():
        setattr(made, name, value)
    for name, value in inputs.items():
        made.inputs[name.replace("_", " ")].default_value = value
    return made.outputs[0]


def mix(tree, share, first, second):
    made = tree.nodes.new("ShaderNodeMixShader")
    made.inputs[0].default_value = share
    tree.links.new(first, made.inputs[1])
    tree.links.new(second, made.inputs[2])
    return made.outputs[0]


def add(tree, first, second):
    made = tree.nodes.new("ShaderNodeAddShader")
    tree.links.new(first, made.inputs[0])
    tree.links.new(second, made.inputs[1])
    return made.outputs[0]


def glossy(distribution: str, **inputs):
    return lambda tree: node(tree, "BsdfAnisotropic", {"distribution": distribution}, **inputs)


def metal(fresnel: str, **inputs):
    return lambda tree: node(tree, "BsdfMetallic", {"fresnel_type": fresnel}, **inputs)


def glass(distribution: str, **inputs):
    return lambda tree: node(tree, "BsdfGlass", {"distribution": distribution}, **inputs)


def refraction(distribution: str, **inputs):
    return lambda tree: node(tree, "BsdfRefraction", {"distribution": distribution}, **inputs)


def principled(**inputs):
    return lambda tree: node(tree, "BsdfPrincipled", None, **inputs)


def sheen(distribution: str, roughness: float):
    return lambda tree: node(tree, "BsdfSheen", {"distribution": distribution}, Color=GOLD, Roughness=roughness)


def diffuse(tree, colour=RED):
    return node(tree, "BsdfDiffuse", None, Color=colour)


def image(tree, low, high):
    """A picture of soft stripes between two colours: the output of its texture node."""
    import bpy

    made = bpy.data.images.new("stripes", 64, 32, float_buffer=True)
    made.colorspace_settings.name = "Non-Color"
    part = 0.5 + 0.5 * np.sin(np.arange(64) * 2.0 * np.pi * 3 / 64)[None, :, None]
    pixels = np.array(low) + (np.array(high) - np.array(low)) * part * np.ones((32, 1, 1))
    made.pixels.foreach_set(np.concatenate([pixels, np.ones((32, 64, 1))], 2).astype(np.float32).reshape(-1))
    made.pack()
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = made
    return texture.outputs["Color"]


def material_of(t: Tree):
    """The material that holds the tree."""
    import bpy

    return next(one for one in bpy.data.materials if one.node_tree == t.tree)
