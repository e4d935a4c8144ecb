# SPDX-License-Identifier: GPL-3.0-or-later
"""What is handed over means what it means in Blender: the same picture as Cycles takes with a pinhole, within noise."""

from __future__ import annotations

import math
from math import radians

import numpy as np
import pytest

WIDTH, HEIGHT, SAMPLES = 24, 16, 256


@pytest.fixture
def stage(blender):
    """A floor seen from above, without any light."""
    from support import scenes as parts

    scene = parts.set_up(WIDTH, HEIGHT, SAMPLES)
    scene.world = parts.grey_world(0.0)
    scene.camera.location = (0.0, 0.0, 6.0)
    scene.camera.rotation_euler = (0.0, 0.0, 0.0)
    floor, tree, surface = parts.material("Floor")
    diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (0.7, 0.5, 0.3, 1.0)
    tree.links.new(diffuse.outputs[0], surface)
    corners = [(-4, -4, 0), (4, -4, 0), (4, 4, 0), (-4, 4, 0)]
    parts.mesh_object("Floor", corners, [(0, 1, 2, 3)], floor, uv=[(0, 0), (1, 0), (1, 1), (0, 1)])
    return parts


def alike(folder, *, mean: float = 0.01, block: float = 0.06) -> None:
    """Petzval shows what Cycles does, in the mean and in blocks of 4 x 4 pixels."""
    from support import beside_cycles

    beside_cycles.alike(folder, SAMPLES, side=4, mean=mean, block=block, bounces=12)


def lamp(blender, kind: str, **settings):
    light = blender.data.lights.new(kind.title(), kind)
    light.energy = 3.0 if kind == "SUN" else 200.0
    light.color = (1.0, 0.8, 0.6)
    holder = blender.data.objects.new(kind.title(), light)
    holder.location = (0.8, 0.5, 3.0)
    holder.rotation_euler = (radians(7.0), radians(5.0), radians(30.0))
    for name, value in settings.items():
        setattr(holder if name == "scale" else light, name, value)
    blender.context.scene.collection.objects.link(holder)
    return light


LAMPS = [
    ("POINT", {"shadow_soft_size": 0.3}),
    ("POINT", {"shadow_soft_size": 0.0}),
    ("POINT", {"shadow_soft_size": 0.3, "normalize": False}),
    ("SPOT", {"shadow_soft_size": 0.1, "spot_size": radians(50.0), "spot_blend": 0.3}),
    ("SPOT", {"shadow_soft_size": 0.2, "spot_size": radians(70.0), "spot_blend": 0.7, "scale": (1.0, 1.0, 2.0)}),
    ("SUN", {"angle": 0.0}),
    ("SUN", {"angle": radians(4.0)}),
    ("SUN", {"angle": radians(20.0), "normalize": False}),
    ("AREA", {"shape": "SQUARE", "size": 1.0}),
    ("AREA", {"shape": "RECTANGLE", "size": 2.0, "size_y": 0.4}),
    ("AREA", {"shape": "DISK", "size": 1.2}),
    ("AREA", {"shape": "ELLIPSE", "size": 2.0, "size_y": 0.5, "scale": (0.5, 1.5, 1.0)}),
    ("AREA", {"shape": "RECTANGLE", "size": 0.6, "size_y": 0.4, "spread": radians(60.0)}),
    ("AREA", {"shape": "RECTANGLE", "size": 0.6, "size_y": 0.4, "scale": (2.0, 1.0, 1.0), "normalize": False}),
    ("AREA", {"shape": "DISK", "size": 0.6, "normalize": False, "exposure": 1.5}),
    ("POINT", {"exposure": -1.0, "use_temperature": True, "temperature": 2800.0}),
]


@pytest.mark.parametrize(("kind", "settings"), LAMPS)
def test_lamps(stage, blender, tmp_path, kind, settings):
    known = blender.types.PointLight.bl_rna.properties.keys()
    if not ({"normalize", "exposure", "use_temperature"} & settings.keys()) <= set(known):
        pytest.skip("this Blender's lamps have no such setting")
    lamp(blender, kind, **settings)
    # The blend of a stretched cone is met at its ends, not between.
    stretched = kind == "SPOT" and "scale" in settings
    alike(tmp_path, mean=0.05 if stretched else 0.01, block=0.2 if stretched else 0.06)


def test_nodes_of_a_lamp(stage, blender, tmp_path):
    light = lamp(blender, "AREA", size=1.0)
    light.use_nodes = True
    emission = light.node_tree.nodes["Emission"]
    emission.inputs["Color"].default_value = (0.2, 0.5, 1.0, 1.0)
    emission.inputs["Strength"].default_value = 3.0
    alike(tmp_path)


def four_colours(parts, **more):
    """A smooth image without symmetry, its edges aside."""
    x, y = np.meshgrid(np.linspace(0.0, 1.0, 128), np.linspace(0.0, 1.0, 64))
    pixels = np.stack([x, y, 0.2 + 0.6 * x * y, np.clip(x + y, 0.2, 1.0)], -1)
    return parts.image("Colours", pixels, **more)


@pytest.mark.parametrize("kind", ["POINT", "TEXTURE"])
@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.0), (0.0, 0.0, 110.0), (20.0, -35.0, 70.0)])
def test_a_world_image(stage, blender, tmp_path, kind, turn):
    scene = blender.context.scene
    tree = scene.world.node_tree
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = four_colours(stage, is_float=True)
    mapping = tree.nodes.new("ShaderNodeMapping")
    mapping.vector_type = kind
    mapping.inputs["Rotation"].default_value = [radians(angle) for angle in turn]
    place = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(place.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs[0], texture.inputs["Vector"])
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    background.inputs["Strength"].default_value = 0.8
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    # Half of the picture sees the sky, half the floor in its light.
    scene.camera.location = (0.0, -6.0, 1.0)
    scene.camera.rotation_euler = (radians(80.0), 0.0, radians(5.0))
    alike(tmp_path, block=0.1)


@pytest.mark.parametrize("slot", ["empty", "without nodes"])
def test_what_nodes_do_not_say(stage, blender, tmp_path, slot):
    """An empty slot is Principled since Blender 5.0 and Diffuse before, a material without nodes Diffuse in its viewport colour."""
    material = None
    if slot == "without nodes":
        material = blender.data.materials.new("Plain")
        material.diffuse_color, material.roughness, material.metallic = (0.7, 0.5, 0.3, 1.0), 0.1, 0.5
        if blender.app.version < (5, 0, 0):
            material.use_nodes = False
    blender.data.objects["Floor"].data.materials[0] = material
    # Where the camera sees a highlight.
    lamp(blender, "POINT", shadow_soft_size=1.0)
    alike(tmp_path)


MAPPINGS = [
    {},
    {"Scale": (2.0, 3.0, 1.0), "Location": (0.1, 0.3, 0.0), "Rotation": (0.0, 0.0, 0.6)},
    {"Scale": (2.0, 3.0, 1.0), "Location": (0.1, 0.3, 0.0), "Rotation": (0.0, 0.0, 0.6), "kind": "TEXTURE"},
    {"Scale": (0.4, 0.4, 1.0), "Location": (0.4, 0.2, 0.0), "extension": "CLIP"},
    {"Scale": (2.0, 2.0, 1.0), "Location": (-0.4, -0.2, 0.0), "extension": "EXTEND"},
    {"Scale": (3.0, 2.0, 1.0), "interpolation": "Closest", "extension": "MIRROR"},
]


@pytest.mark.parametrize("given", MAPPINGS)
@pytest.mark.parametrize("image", [{}, {"space": "Non-Color"}, {"is_float": True}])
def test_an_image_on_a_surface(stage, blender, tmp_path, given, image):
    tree = blender.data.materials["Floor"].node_tree
    given = dict(given)
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = four_colours(stage, **image)
    texture.extension = given.pop("extension", "REPEAT")
    texture.interpolation = given.pop("interpolation", "Linear")
    mapping = tree.nodes.new("ShaderNodeMapping")
    mapping.vector_type = given.pop("kind", "POINT")
    for name, value in given.items():
        mapping.inputs[name].default_value = value
    place = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(place.outputs["UV"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs[0], texture.inputs["Vector"])
    diffuse = next(node for node in tree.nodes if node.type == "BSDF_DIFFUSE")
    tree.links.new(texture.outputs["Color"], diffuse.inputs["Color"])
    blender.context.scene.world = stage.grey_world(1.0, "Bright")
    alike(tmp_path, mean=0.01, block=0.06)


def shader(tree, kind: str, **inputs):
    node = tree.nodes.new(f"ShaderNode{kind}")
    for name, value in inputs.items():
        node.inputs[name.replace("_", " ")].default_value = value
    return node


def red(tree):
    return shader(tree, "BsdfDiffuse", Color=(0.9, 0.1, 0.1, 1.0))


def clear_share(tree):
    """A quarter clear."""
    mix = shader(tree, "MixShader")
    mix.inputs[0].default_value = 0.75
    tree.links.new(tree.nodes.new("ShaderNodeBsdfTransparent").outputs[0], mix.inputs[1])
    tree.links.new(red(tree).outputs[0], mix.inputs[2])
    return mix


def clear_after(tree):
    mix = shader(tree, "MixShader")
    mix.inputs[0].default_value = 0.25
    tree.links.new(red(tree).outputs[0], mix.inputs[1])
    tree.links.new(tree.nodes.new("ShaderNodeBsdfTransparent").outputs[0], mix.inputs[2])
    return mix


def glow_on_red(tree):
    add = tree.nodes.new("ShaderNodeAddShader")
    tree.links.new(red(tree).outputs[0], add.inputs[0])
    tree.links.new(shader(tree, "Emission", Color=(0.1, 0.3, 1.0, 1.0), Strength=0.5).outputs[0], add.inputs[1])
    return add


def folded_colour(tree):
    """Constant colours through several nodes, a reroute and a muted node."""
    mix = tree.nodes.new("ShaderNodeMix")
    mix.data_type, mix.blend_type = "RGBA", "MULTIPLY"
    factor, first, second = (socket for socket in mix.inputs if socket.enabled)
    factor.default_value, second.default_value = 0.6, (0.5, 0.9, 0.2, 1.0)
    ramp = tree.nodes.new("ShaderNodeValToRGB")
    ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (1, 0.2, 0, 1), (0.1, 0.3, 1, 1)
    math_node = shader(tree, "Math")
    math_node.inputs[0].default_value, math_node.inputs[1].default_value = 0.1, 0.25
    muted = shader(tree, "Invert")
    muted.mute = True
    reroute = tree.nodes.new("NodeReroute")
    diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
    tree.links.new(math_node.outputs[0], ramp.inputs[0])
    tree.links.new(ramp.outputs[0], first)
    tree.links.new(next(socket for socket in mix.outputs if socket.enabled), muted.inputs["Color"])
    tree.links.new(muted.outputs[0], reroute.inputs[0])
    tree.links.new(reroute.outputs[0], diffuse.inputs["Color"])
    return diffuse


def blackbody(tree):
    emission = shader(tree, "Emission", Strength=0.7)
    tree.links.new(shader(tree, "Blackbody", Temperature=2100.0).outputs[0], emission.inputs["Color"])
    return emission


SURFACES = {
    "diffuse": red,
    "emission": lambda tree: shader(tree, "Emission", Color=(0.3, 0.6, 0.9, 1.0), Strength=2.0),
    "blackbody": blackbody,
    "clear share": clear_share,
    "clear after": clear_after,
    "emission added": glow_on_red,
    "folded": folded_colour,
    "principled": lambda tree: shader(tree, "BsdfPrincipled", Base_Color=(0.2, 0.5, 0.8, 1.0), Roughness=0.4),
    "half transparent": lambda tree: shader(tree, "BsdfPrincipled", Base_Color=(0.2, 0.5, 0.8, 1.0), Alpha=0.5),
    "metal": lambda tree: shader(tree, "BsdfPrincipled", Base_Color=(0.9, 0.6, 0.2, 1.0), Metallic=1.0, Roughness=0.5),
    "glossy": lambda tree: shader(tree, "BsdfGlossy", Color=(1.0, 1.0, 1.0, 1.0), Roughness=0.5),
    "glass": lambda tree: shader(tree, "BsdfGlass", Color=(1.0, 1.0, 1.0, 1.0), Roughness=0.2, IOR=1.3),
}


@pytest.mark.parametrize("name", SURFACES)
def test_surfaces(stage, blender, tmp_path, name):
    made, tree, surface = stage.material(name)
    tree.links.new(SURFACES[name](tree).outputs[0], surface)
    blender.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=1.2, location=(0.0, 0.0, 1.5))
    ball = blender.context.object
    ball.data.materials.append(made)
    ball.data.shade_smooth()
    blender.context.scene.world = stage.grey_world(0.7, "Bright")
    alike(tmp_path, mean=0.01, block=0.08)


def test_a_shader_inside_of_groups(stage, blender, tmp_path):
    inner = blender.data.node_groups.new("Inner", "ShaderNodeTree")
    inner.interface.new_socket("Tint", in_out="INPUT", socket_type="NodeSocketColor")
    inner.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    start, end = inner.nodes.new("NodeGroupInput"), inner.nodes.new("NodeGroupOutput")
    diffuse = inner.nodes.new("ShaderNodeBsdfDiffuse")
    inner.links.new(start.outputs["Tint"], diffuse.inputs["Color"])
    inner.links.new(diffuse.outputs[0], end.inputs["Shader"])

    outer = blender.data.node_groups.new("Outer", "ShaderNodeTree")
    outer.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    group, end = outer.nodes.new("ShaderNodeGroup"), outer.nodes.new("NodeGroupOutput")
    group.node_tree = inner
    group.inputs["Tint"].default_value = (0.1, 0.7, 0.2, 1.0)
    outer.links.new(group.outputs[0], end.inputs[0])

    floor = blender.data.materials["Floor"].node_tree
    group = floor.nodes.new("ShaderNodeGroup")
    group.node_tree = outer
    out = next(node for node in floor.nodes if node.type == "OUTPUT_MATERIAL")
    floor.links.new(group.outputs[0], out.inputs["Surface"])
    blender.context.scene.world = stage.grey_world(1.0, "Bright")
    alike(tmp_path)


@pytest.mark.parametrize("fit", ["AUTO", "HORIZONTAL", "VERTICAL"])
@pytest.mark.parametrize("upright", [False, True])
def test_the_pinhole_frames_as_blender_does(stage, blender, tmp_path, fit, upright):
    from support import beside_cycles

    scene = blender.context.scene
    if upright:
        scene.render.resolution_x, scene.render.resolution_y = HEIGHT, WIDTH
    camera = scene.camera.data
    camera.sensor_fit, camera.sensor_width, camera.sensor_height, camera.lens = fit, 30.0, 20.0, 40.0
    camera.shift_x, camera.shift_y = 0.12, -0.07
    tree = blender.data.materials["Floor"].node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = four_colours(stage, is_float=True)
    emission = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(texture.outputs["Color"], emission.inputs["Color"])
    out = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    tree.links.new(emission.outputs[0], out.inputs["Surface"])
    ours, theirs = beside_cycles.both(tmp_path, SAMPLES, 12)
    # The ramps of red and green are places.
    assert np.abs(ours - theirs)[..., :2].max() < 0.01 * math.sqrt(theirs.max())
