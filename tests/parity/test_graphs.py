# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials whose nodes are computed at each point, against Cycles in the same Blender, block by block."""

from __future__ import annotations

import numpy as np
import pytest

from support.ball_in_sky import BLOCK, SAMPLES, alike
from support.node_tree import Tree
from support.shaders import material_of


def noise_ramp(t: Tree):
    """The commonest of all."""
    noise = t.node("TexNoise", Vector=t.coordinates("Object"), Scale=3.0)
    t.shows(t.node("BsdfPrincipled", Base_Color=t.ramp(noise.outputs[0])).outputs[0])


def generated_voronoi(t: Tree):
    """Coordinates in the box, where nothing is linked."""
    voronoi = t.node("TexVoronoi", Scale=4.0)
    t.shows(t.node("BsdfDiffuse", Color=voronoi.outputs["Color"]).outputs[0])


def bump(t: Tree):
    wave = t.node("TexWave", Vector=t.coordinates("Object"), Scale=1.5)
    bent = t.node("Bump", Strength=0.6, Distance=0.1, Height=wave.outputs["Fac"])
    t.shows(t.node("BsdfPrincipled", Roughness=0.4, Normal=bent.outputs[0]).outputs[0])


def bump_diffuse(t: Tree):
    wave = t.node("TexWave", Vector=t.coordinates("Object"), Scale=1.5)
    bent = t.node("Bump", Strength=0.6, Distance=0.1, Height=wave.outputs["Fac"])
    t.shows(t.node("BsdfDiffuse", Normal=bent.outputs[0]).outputs[0])


def bump_metal(t: Tree):
    wave = t.node("TexWave", Vector=t.coordinates("Object"), Scale=1.5)
    bent = t.node("Bump", Strength=0.6, Distance=0.1, Height=wave.outputs["Fac"])
    t.shows(t.node("BsdfAnisotropic", Roughness=0.4, Normal=bent.outputs[0]).outputs[0])


def bump_gentle(t: Tree):
    wave = t.node("TexWave", Vector=t.coordinates("Object"), Scale=1.5)
    bent = t.node("Bump", Strength=0.1, Distance=0.1, Height=wave.outputs["Fac"])
    t.shows(t.node("BsdfDiffuse", Normal=bent.outputs[0]).outputs[0])


def tangent_normals(t: Tree):
    noise = t.node("TexNoise", Vector=t.coordinates("UV"), Scale=5.0)
    bent = t.node("NormalMap", Strength=0.5, Color=noise.outputs["Color"])
    t.shows(t.node("BsdfDiffuse", Normal=bent.outputs[0]).outputs[0])


def tangent_normals_without_a_map(t: Tree):
    """Cycles maps the mesh as a sphere; it averages over the triangles that meet."""
    _without_maps()
    bent = t.node("NormalMap", Strength=0.7, Color=(0.8, 0.3, 0.9, 1.0))
    t.shows(t.node("BsdfDiffuse", Normal=bent.outputs[0]).outputs[0])


def _without_maps():
    import bpy

    maps = bpy.context.object.data.uv_layers
    while maps:
        maps.remove(maps[0])


def tangent_normals_of_a_flat_map(t: Tree):
    """A map in which no triangle takes any area."""
    import bpy

    maps = bpy.context.object.data.uv_layers
    maps[0].data.foreach_set("uv", np.zeros(2 * len(maps[0].data), np.float32))
    bent = t.node("NormalMap", Strength=0.7, Color=(0.8, 0.3, 0.9, 1.0))
    t.shows(t.node("BsdfDiffuse", Normal=bent.outputs[0]).outputs[0])


def object_normals(t: Tree):
    noise = t.node("TexNoise", Vector=t.coordinates("UV"), Scale=5.0)
    bent = t.node("NormalMap", {"space": "OBJECT"}, Strength=0.3, Color=noise.outputs["Color"])
    t.shows(t.node("BsdfDiffuse", Normal=bent.outputs[0]).outputs[0])


def displaced(t: Tree):
    """Displacement as a bump, under a shader that knows nothing of it."""
    t.shows(t.node("BsdfPrincipled", Roughness=0.4).outputs[0])
    noise = t.node("TexNoise", Vector=t.coordinates("Object"), Scale=4.0)
    lifted = t.node("Displacement", Height=noise.outputs[0], Scale=0.1)
    t.lifts(lifted.outputs[0])


def moved(t: Tree, method: str):
    """Displacement that moves the mesh: a waist and soft waves, as fine as the mesh."""
    t.shows(t.node("BsdfPrincipled", Roughness=0.4, Base_Color=(0.8, 0.3, 0.1, 1.0)).outputs[0])
    waves = t.node("TexWave", Vector=t.coordinates("Generated"), Scale=0.7)
    lifted = t.node("Displacement", Height=waves.outputs["Fac"], Midlevel=0.3, Scale=-0.3)
    t.lifts(lifted.outputs[0])
    material_of(t).displacement_method = method


def moved_only(t: Tree):
    moved(t, "DISPLACEMENT")


def moved_and_bumped(t: Tree):
    moved(t, "BOTH")


def moved_flat(t: Tree):
    """Along a vector, under flat faces."""
    import bpy

    bpy.ops.object.shade_flat()
    t.shows(t.node("BsdfDiffuse", Color=(0.5, 0.6, 0.7, 1.0)).outputs[0])
    noise = t.node("TexNoise", Vector=t.coordinates("Object"), Scale=1.0)
    lifted = t.node("VectorDisplacement", {"space": "OBJECT"}, Vector=noise.outputs["Color"], Midlevel=0.5, Scale=1.2)
    t.lifts(lifted.outputs[0])
    material_of(t).displacement_method = "DISPLACEMENT"


def camera_sees_red(t: Tree):
    path = t.node("LightPath")
    colour = t.node(
        "Mix",
        {"data_type": "RGBA"},
        Factor=path.outputs["Is Camera Ray"],
        _6=(0.1, 0.8, 0.1, 1.0),
        _7=(0.9, 0.1, 0.1, 1.0),
    )
    t.shows(t.node("BsdfDiffuse", Color=colour.outputs[2]).outputs[0])


def image_box(t: Tree):
    """An image from three sides."""
    import bpy

    pixels = np.ones((8, 8, 4), np.float32)
    pixels[..., 0], pixels[..., 1] = np.linspace(0, 1, 8)[None, :], np.linspace(0, 1, 8)[:, None]
    image = bpy.data.images.new("ramp", 8, 8, float_buffer=True)
    image.pixels.foreach_set(pixels.ravel())
    texture = t.node(
        "TexImage", {"image": image, "projection": "BOX", "projection_blend": 0.2}, Vector=t.coordinates("Object")
    )
    t.shows(t.node("BsdfDiffuse", Color=texture.outputs["Color"]).outputs[0])


def lost_image(t: Tree):
    """An image whose file is missing is magenta and opaque, whatever reads it; from 5.2 on beyond its edges, too."""
    import bpy

    image = bpy.data.images.new("lost", 4, 4)
    image.source, image.filepath = "FILE", "//lost.png"
    extension = "CLIP" if bpy.app.version >= (5, 2, 0) else "REPEAT"
    vector = t.node("VectorMath", {"operation": "SCALE"}, Vector=t.coordinates("Generated"), Scale=3.0)
    texture = t.node("TexImage", {"image": image, "extension": extension}, Vector=vector.outputs[0])
    mixed = t.node("MixRGB", Fac=texture.outputs["Alpha"], Color1=(0.0, 1.0, 0.0, 1.0), Color2=texture.outputs["Color"])
    bumped = t.node("Bump", Height=texture.outputs["Color"])
    t.shows(t.node("BsdfDiffuse", Color=mixed.outputs[0], Normal=bumped.outputs[0]).outputs[0])


def rough_by_checker(t: Tree):
    checker = t.node(
        "TexChecker", Vector=t.coordinates("UV"), Scale=8.0, Color1=(0.1,) * 3 + (1.0,), Color2=(0.6,) * 3 + (1.0,)
    )
    t.shows(t.node("BsdfPrincipled", Metallic=1.0, Roughness=checker.outputs["Color"]).outputs[0])


def facing_mix(t: Tree):
    weight = t.node("LayerWeight", Blend=0.4)
    red = t.node("BsdfDiffuse", Color=(0.8, 0.1, 0.1, 1.0))
    blue = t.node("BsdfAnisotropic", Color=(0.2, 0.3, 0.9, 1.0), Roughness=0.3)
    t.shows(t.node("MixShader", _0=weight.outputs["Facing"], _1=red.outputs[0], _2=blue.outputs[0]).outputs[0])


def fresnel_coat(t: Tree):
    fresnel = t.node("Fresnel", IOR=1.6)
    base = t.node("BsdfDiffuse", Color=(0.2, 0.6, 0.3, 1.0))
    gloss = t.node("BsdfAnisotropic", Roughness=0.2)
    t.shows(t.node("MixShader", _0=fresnel.outputs[0], _1=base.outputs[0], _2=gloss.outputs[0]).outputs[0])


def glowing_cracks(t: Tree):
    """Emission that varies."""
    voronoi = t.node("TexVoronoi", {"feature": "DISTANCE_TO_EDGE"}, Vector=t.coordinates("Object"), Scale=2.0)
    narrow = t.node("Math", {"operation": "LESS_THAN"}, _0=voronoi.outputs["Distance"], _1=0.1)
    glow = t.node("Emission", Color=(1.0, 0.4, 0.1, 1.0), Strength=3.0)
    rock = t.node("BsdfDiffuse", Color=(0.1, 0.1, 0.1, 1.0))
    t.shows(t.node("MixShader", _0=narrow.outputs[0], _1=rock.outputs[0], _2=glow.outputs[0]).outputs[0])


def holes(t: Tree):
    """Transparency by a texture."""
    checker = t.node("TexChecker", Vector=t.coordinates("Object"), Scale=3.0)
    t.shows(t.node("BsdfPrincipled", Alpha=checker.outputs["Fac"], Base_Color=(0.3, 0.7, 0.5, 1.0)).outputs[0])


def object_random(t: Tree):
    info = t.node("ObjectInfo")
    hue = t.node("HueSaturation", Hue=info.outputs["Random"], Color=(0.8, 0.2, 0.1, 1.0))
    t.shows(t.node("BsdfDiffuse", Color=hue.outputs[0]).outputs[0])


def colour_attribute(t: Tree):
    colour = t.node("VertexColor", {"layer_name": "Paint"})
    t.shows(t.node("BsdfDiffuse", Color=colour.outputs["Color"]).outputs[0])


def position_math(t: Tree):
    place = t.node("NewGeometry").outputs["Position"]
    parts = t.node("SeparateXYZ", Vector=place)
    sine = t.node(
        "Math",
        {"operation": "SINE"},
        _0=t.node("Math", {"operation": "MULTIPLY"}, _0=parts.outputs["Z"], _1=9.0).outputs[0],
    )
    value = t.node("MapRange", Value=sine.outputs[0], From_Min=-1.0, From_Max=1.0, To_Min=0.1, To_Max=0.9)
    t.shows(t.node("BsdfDiffuse", Color=value.outputs[0]).outputs[0])


# One block of sixteen, where the bump is steeper than the ball's own curve; the mean is within 0.2 %. Not understood.
# Without a map: Cycles averages the tangents of triangles that meet, we do not.
STEEP = {"moved_and_bumped": 0.045, "tangent_normals_without_a_map": 0.06}

GRAPHS = (
    noise_ramp, generated_voronoi, bump, bump_diffuse, bump_metal, bump_gentle, tangent_normals, tangent_normals_without_a_map, tangent_normals_of_a_flat_map,
    object_normals, displaced,
    moved_only, moved_and_bumped, moved_flat,
    camera_sees_red, image_box, lost_image, rough_by_checker, facing_mix, fresnel_coat, glowing_cracks, holes, object_random,
    colour_attribute, position_math,
)  # fmt: skip


#: Of nodes that are handed over as those of others are.
ALIKE = {bump_diffuse, bump_metal, bump_gentle, moved_and_bumped, tangent_normals_of_a_flat_map, fresnel_coat}


@pytest.mark.parametrize(
    "graph",
    [pytest.param(graph, marks=[pytest.mark.once] * (graph in ALIKE)) for graph in GRAPHS],
    ids=lambda graph: graph.__name__,
)
def test_graphs(stage, blender, tmp_path, graph):
    ball = blender.context.object
    paint = ball.data.color_attributes.new("Paint", "FLOAT_COLOR", "POINT")
    colours = np.ones((len(ball.data.vertices), 4), np.float32)
    colours[:, 0] = np.linspace(0.0, 1.0, len(colours))
    paint.data.foreach_set("color", colours.ravel())
    made, tree, surface = stage.material()
    ball.data.materials.append(made)
    graph(Tree(tree, surface))
    # 512 samples of 144 pixels: noise below 0.3 %. Edges of patterns fall between samples alike.
    is_lost = graph is lost_image
    # Magenta has no green.
    alike(tmp_path, STEEP.get(graph.__name__, 0.02), floor=0.1 * is_lost, warns="lost.png" * is_lost)


def _in_a_group(t: Tree, inside, is_hidden: bool):
    """A group node of the colour that `inside` makes of the group's own, unlinked vector."""
    import bpy

    group = bpy.data.node_groups.new("Group", "ShaderNodeTree")
    vector = group.interface.new_socket("Vector", in_out="INPUT", socket_type="NodeSocketVector")
    vector.default_value = (0.2, 0.4, 0.1)
    vector.hide_value = is_hidden
    group.interface.new_socket("Color", in_out="OUTPUT", socket_type="NodeSocketColor")
    made = Tree(group, group.nodes.new("NodeGroupOutput").inputs[0])
    made.shows(inside(made, group.nodes.new("NodeGroupInput").outputs["Vector"]))
    outside = t.node("Group", {"node_tree": group})
    outside.inputs["Vector"].default_value = (0.2, 0.4, 0.1)
    t.shows(t.node("Emission", Color=outside.outputs[0]).outputs[0])


def fresnel(t: Tree, vector):
    return t.node("Fresnel", IOR=1.6, Normal=vector).outputs[0]


def texture(t: Tree, vector):
    return t.node("TexVoronoi", Scale=4.0, Vector=vector).outputs["Color"]


def mapping(t: Tree, vector):
    """Takes nothing of the surface where nothing is linked."""
    return t.node("Mapping", Scale=(2.0, 1.0, 4.0), Vector=vector).outputs[0]


@pytest.mark.parametrize("is_hidden", [False, True], ids=["shown", "hidden"])
@pytest.mark.parametrize("inside", [fresnel, texture, mapping], ids=lambda inside: inside.__name__)
def test_the_own_vector_of_a_group(stage, blender, tmp_path, inside, is_hidden):
    """Where the group hides it, a node takes its normal of the surface, as without a link; coordinates take the value,
    from Blender 5.0 on."""
    made, tree, surface = stage.material()
    blender.context.object.data.materials.append(made)
    _in_a_group(Tree(tree, surface), inside, is_hidden)
    alike(tmp_path, 0.02, floor=0.0)


def ramp_behind(t: Tree, unknown):
    made = t.ramp(unknown)
    made.node.inputs["Fac"].default_value = 0.6
    t.shows(t.node("BsdfDiffuse", Color=made).outputs[0])


def glow_behind(t: Tree, unknown):
    t.shows(t.node("Emission", Color=unknown, Strength=0.7).outputs[0])


def reroute_behind(t: Tree, unknown):
    turn = t.tree.nodes.new("NodeReroute")
    t.tree.links.new(unknown, turn.inputs[0])
    colour = t.node("MixRGB", Fac=0.5, Color1=turn.outputs[0], Color2=(0.9, 0.6, 0.2, 1.0))
    t.shows(t.node("BsdfDiffuse", Color=colour.outputs[0]).outputs[0])


def group_behind(t: Tree, unknown):
    """What counts is the own value of the node in the group."""
    import bpy

    group = bpy.data.node_groups.new("Group", "ShaderNodeTree")
    group.interface.new_socket("Tint", in_out="INPUT", socket_type="NodeSocketColor")
    group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    inside = Tree(group, group.nodes.new("NodeGroupOutput").inputs[0])
    inside.shows(inside.node("BsdfDiffuse", Color=group.nodes.new("NodeGroupInput").outputs["Tint"]).outputs[0])
    outside = t.node("Group", {"node_tree": group})
    outside.inputs["Tint"].default_value = (0.2, 0.7, 0.4, 1.0)
    t.tree.links.new(unknown, outside.inputs["Tint"])
    t.shows(outside.outputs[0])


def normal_behind(t: Tree, unknown):
    t.shows(t.node("BsdfDiffuse", Color=(0.3, 0.7, 0.5, 1.0), Normal=unknown).outputs[0])


@pytest.mark.parametrize(
    "build", [ramp_behind, glow_behind, reroute_behind, group_behind, normal_behind], ids=lambda build: build.__name__
)
def test_a_node_that_cycles_does_not_know(stage, blender, tmp_path, build):
    """Its link does not count, and a warning names it."""
    from support import beside_cycles

    if blender.app.version < (5, 0, 0) and build in (reroute_behind, group_behind):
        pytest.skip("before Blender 5 the values of reroutes and groups count")
    made, tree, surface = stage.material()
    blender.context.object.data.materials.append(made)
    t = Tree(tree, surface)
    red = t.node("Emission", Color=(1.0, 0.1, 0.1, 1.0), Strength=3.0)
    unknown = t.node("ShaderToRGB", Shader=red.outputs[0]).outputs["Color"]
    build(t, unknown)
    beside_cycles.alike(tmp_path, SAMPLES, side=BLOCK, mean=0.01, block=0.02, bounces=48, warns="Shader to RGB")


def dead_reroute(t: Tree):
    return t.tree.nodes.new("NodeReroute").outputs[0]


def dead_muted(t: Tree):
    """A muted node that nothing is linked to, whose own value does not count."""
    made = t.node("Gamma", Color=(0.1, 0.2, 0.9, 1.0))
    made.mute = True
    return made.outputs[0]


def dead_without_inputs(t: Tree):
    made = t.node("RGB")
    made.mute = True
    return made.outputs[0]


@pytest.mark.parametrize("place", ["tree", "group", "before a group"])
@pytest.mark.parametrize("dead", [dead_reroute, dead_muted, dead_without_inputs], ids=lambda dead: dead.__name__)
def test_links_from_nowhere(stage, blender, tmp_path, dead, place):
    made, tree, surface = stage.material()
    blender.context.object.data.materials.append(made)
    t = Tree(tree, surface)
    if place == "tree":
        colour = dead(t)
    else:
        group = blender.data.node_groups.new("Group", "ShaderNodeTree")
        for way in ("INPUT", "OUTPUT"):
            group.interface.new_socket("Color", in_out=way, socket_type="NodeSocketColor")
        start, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
        end.inputs[0].default_value = (0.5, 0.9, 0.1, 1.0)
        outside = t.node("Group", {"node_tree": group})
        outside.inputs[0].default_value = (0.9, 0.1, 0.7, 1.0)
        if place == "group":
            group.links.new(dead(Tree(group, None)), end.inputs[0])
        else:
            group.links.new(start.outputs[0], end.inputs[0])
            tree.links.new(dead(t), outside.inputs[0])
        colour = outside.outputs[0]
    emission = t.node("Emission")
    emission.inputs["Color"].default_value = (0.8, 0.4, 0.3, 1.0)
    tree.links.new(colour, emission.inputs["Color"])
    t.shows(emission.outputs[0])
    alike(tmp_path, 0.02)
