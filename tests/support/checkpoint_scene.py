# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene for renders that are killed: passes of data, of light, of a shader's own outputs, mattes and light groups, through a
lens; and materials that ask for several attributes. Imported inside of tests: it needs bpy."""

from __future__ import annotations

import bpy
import numpy as np

from support import render_passes, scenes

ATTRIBUTES = ("wet", "dusty", "old", "far")


def build(width: int, height: int, samples: int) -> bpy.types.Scene:
    """Fills an empty file with it."""
    scene = render_passes.room()
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.petzval.samples = samples
    scenes.exr(scene, "OPEN_EXR_MULTILAYER")
    scene.render.image_settings.exr_codec = "NONE"
    own = scene.camera.data.petzval
    own.model, own.lens_file = "LENS", "cooke-triplet-50mm.lens"
    layer = scene.view_layers[0]
    render_passes.ask_for_light(layer)
    layer.use_pass_z = layer.use_pass_position = layer.use_pass_normal = layer.use_pass_vector = True
    layer.use_pass_mist = layer.use_pass_uv = layer.use_pass_object_index = True
    layer.use_pass_cryptomatte_object = layer.use_pass_cryptomatte_material = True
    layer.cycles.denoising_store_passes = True
    for name in ("Key", "Sky"):
        layer.lightgroups.add(name=name)
    bpy.data.objects["Lamp"].lightgroup = bpy.data.objects["Panel"].lightgroup = "Key"
    scene.world.lightgroup = "Sky"
    _paint(bpy.data.objects["Floor"], layer)
    return scene


def _paint(floor: bpy.types.Object, layer: bpy.types.ViewLayer) -> None:
    """A mesh whose material asks for attributes, whose order no render may depend on, and shows them as AOVs."""
    tree = floor.data.materials[0].node_tree
    for number, name in enumerate(ATTRIBUTES):
        values = np.full(len(floor.data.vertices), 0.2 * number, np.float32)
        floor.data.attributes.new(name, "FLOAT", "POINT").data.foreach_set("value", values)
        one = layer.aovs.add()
        one.name, one.type = name.title(), "VALUE"
        read, shown = tree.nodes.new("ShaderNodeAttribute"), tree.nodes.new("ShaderNodeOutputAOV")
        read.attribute_name, shown.aov_name = name, name.title()
        tree.links.new(read.outputs["Fac"], shown.inputs["Value"])
