# SPDX-License-Identifier: GPL-3.0-or-later
"""What materials and worlds ask of the camera, of tangents and of a mesh's edges, against Cycles in the same Blender."""

from __future__ import annotations

import numpy as np
import pytest

from support.ball_in_sky import SIDE, alike
from support.node_tree import Tree
from support.shaders import material_of


def _noise(t: Tree, place, scale: float = 3.0):
    """Colours by a place."""
    return t.ramp(t.node("TexNoise", Vector=place, Scale=scale).outputs[0])


def _diffuse(t: Tree, colour):
    t.shows(t.node("BsdfDiffuse", Color=colour).outputs[0])


def _shift_camera():
    """So that neither its axes nor its picture's middle are the world's."""
    import bpy

    camera = bpy.context.scene.camera
    camera.data.shift_x, camera.data.shift_y = 0.1, -0.05
    camera.rotation_euler[1] = 0.3
    # Blender's own rule: neither scale matters.
    camera.scale = (2.0, 2.0, 2.0)
    bpy.context.scene.render.resolution_x = SIDE
    bpy.context.view_layer.update()


def camera_coordinates(t: Tree):
    _shift_camera()
    _diffuse(t, _noise(t, t.coordinates("Camera")))


def window_coordinates(t: Tree):
    _shift_camera()
    _diffuse(t, _noise(t, t.coordinates("Window"), 8.0))


def view_vector(t: Tree):
    _shift_camera()
    _diffuse(t, _noise(t, t.node("CameraData").outputs["View Vector"], 20.0))


def view_depth_and_distance(t: Tree):
    _shift_camera()
    data = t.node("CameraData")
    # The ball is 4 to 5 units away.
    depth = t.node("MapRange", Value=data.outputs["View Z Depth"], From_Min=4.0, From_Max=5.0, To_Min=0.1, To_Max=0.9)
    far = t.node("MapRange", Value=data.outputs["View Distance"], From_Min=4.0, From_Max=5.0, To_Min=0.1, To_Max=0.9)
    _diffuse(t, t.node("CombineXYZ", X=depth.outputs[0], Y=far.outputs[0], Z=0.3).outputs[0])


def into_the_camera(t: Tree):
    """A normal and a point of the object in the camera's space."""
    _shift_camera()
    normal = t.node(
        "VectorTransform",
        {"vector_type": "NORMAL", "convert_from": "WORLD", "convert_to": "CAMERA"},
        Vector=t.node("NewGeometry").outputs["Normal"],
    )
    point = t.node(
        "VectorTransform",
        {"vector_type": "POINT", "convert_from": "OBJECT", "convert_to": "CAMERA"},
        Vector=t.coordinates("Object"),
    )
    both_ways = t.node("VectorMath", {"operation": "ADD"}, _0=normal.outputs[0], _1=point.outputs[0])
    _diffuse(t, _noise(t, both_ways.outputs[0], 2.0))


def _waves(t: Tree, strength: float = 0.6):
    wave = t.node("TexWave", Vector=t.coordinates("Object"), Scale=1.5)
    return t.node("Bump", Strength=strength, Distance=0.1, Height=wave.outputs["Fac"]).outputs[0]


def coat_over_bumps(t: Tree):
    """The coat is smooth where the rest is not."""
    t.shows(t.node("BsdfPrincipled", Coat_Weight=1.0, Coat_Roughness=0.1, Normal=_waves(t)).outputs[0])


def bumped_coat(t: Tree):
    coat = t.node("BsdfPrincipled", Coat_Weight=1.0, Coat_Roughness=0.2, Coat_Normal=_waves(t, 0.3))
    coat.inputs["Base Color"].default_value = (0.05, 0.05, 0.05, 1.0)
    t.shows(coat.outputs[0])


def _turned(t: Tree, settings: dict):
    return t.node("Tangent", settings).outputs[0]


def brushed_by_uv(t: Tree):
    tangent = _turned(t, {"direction_type": "UV_MAP"})
    t.shows(t.node("BsdfAnisotropic", Roughness=0.4, Anisotropy=0.8, Tangent=tangent).outputs[0])


def brushed_about_x(t: Tree):
    tangent = _turned(t, {"direction_type": "RADIAL", "axis": "X"})
    metal = t.node("BsdfPrincipled", Metallic=1.0, Roughness=0.4, Anisotropic=0.9, Tangent=tangent)
    metal.inputs["Anisotropic Rotation"].default_value = 0.1
    t.shows(metal.outputs[0])


def brushed_metallic(t: Tree):
    tangent = _turned(t, {"direction_type": "RADIAL", "axis": "Y"})
    t.shows(t.node("BsdfMetallic", Roughness=0.4, Anisotropy=0.8, Tangent=tangent).outputs[0])


def _stretch_space():
    """Generated coordinates that are not the bounds'."""
    import bpy

    mesh = bpy.context.object.data
    mesh.use_auto_texspace = False
    mesh.texspace_location, mesh.texspace_size = (0.3, 0.0, 0.0), (1.0, 3.0, 1.0)


def brushed_in_its_space(t: Tree):
    """Nothing is linked: around the z axis of generated coordinates."""
    _stretch_space()
    t.shows(t.node("BsdfMetallic", Roughness=0.4, Anisotropy=0.9).outputs[0])


def brushed_in_its_space_by_nodes(t: Tree):
    _stretch_space()
    checker = t.node("TexNoise", Vector=t.coordinates("Object"), Scale=3.0)
    metal = t.node("BsdfMetallic", Roughness=0.4, Anisotropy=0.9, Base_Color=t.ramp(checker.outputs[0]))
    t.shows(metal.outputs[0])


def _wire(t: Tree, size: float, in_pixels: bool):
    wire = t.node("Wireframe", {"use_pixel_size": in_pixels}, Size=size)
    paint = t.node("Mix", {"data_type": "RGBA"}, Factor=wire.outputs[0], _6=(0.8, 0.6, 0.1, 1.0), _7=(0.05,) * 3 + (1,))
    _diffuse(t, paint.outputs[2])


def wires(t: Tree):
    _wire(t, 0.03, False)


def wires_in_pixels(t: Tree):
    _wire(t, 1.5, True)


def wires_behind_a_clip(t: Tree):
    """Where the picture begins does not change how wide a pixel is."""
    import bpy

    bpy.context.scene.camera.data.clip_start = 2.0
    wires_in_pixels(t)


def wires_in_a_mirror(t: Tree):
    """A pixel grows over the whole path: the ball stands behind the camera, and a mirror before it."""
    import bpy

    wires_in_pixels(t)
    ball, scene = bpy.context.object, bpy.context.scene
    ball.location = (0.0, -7.0, 0.0)
    mirror = bpy.data.materials.new("Mirror")
    mirror.use_nodes = True
    mirror.node_tree.nodes["Principled BSDF"].inputs["Metallic"].default_value = 1.0
    mirror.node_tree.nodes["Principled BSDF"].inputs["Roughness"].default_value = 0.0
    bpy.ops.mesh.primitive_plane_add(size=6.0, location=(0.0, -2.0, 0.0), rotation=(np.pi / 2, 0.0, 0.0))
    bpy.context.object.data.materials.append(mirror)
    scene.camera.data.lens = 120
    bpy.context.view_layer.objects.active = ball


def _parallel(t: Tree):
    """An orthographic camera, shifted."""
    import bpy

    camera = bpy.context.scene.camera.data
    camera.type, camera.ortho_scale, camera.shift_x = "ORTHO", 2.2, 0.05


def parallel_wires(t: Tree):
    _parallel(t)
    wires_in_pixels(t)


def parallel_bump(t: Tree):
    """Finer than a pixel: as steep as the pixel is narrow."""
    _parallel(t)
    noise = t.node("TexNoise", Vector=t.coordinates("Object"), Scale=500.0, Detail=0.0)
    bump = t.node("Bump", Strength=1.0, Distance=0.02, Height=noise.outputs[0])
    t.shows(t.node("BsdfDiffuse", Normal=bump.outputs[0]).outputs[0])


def _displaced(t: Tree, method: str, place, scale: float):
    """By a noise, all of it or what the mesh is too coarse for seen as a bump: fine enough for the part of a pixel to matter between which
    the bump's heights are."""
    from support.shaders import material_of

    material_of(t).displacement_method = method
    noise = t.node("TexNoise", Vector=place, Scale=scale, Detail=0.0)
    moved = t.node("Displacement", Height=noise.outputs[0], Midlevel=0.5, Scale=0.06)
    output = next(node for node in t.tree.nodes if node.type == "OUTPUT_MATERIAL")
    t.tree.links.new(moved.outputs[0], output.inputs["Displacement"])
    _diffuse(t, (0.8, 0.8, 0.8, 1.0))


def displaced_as_a_bump(t: Tree):
    _displaced(t, "BUMP", t.coordinates("Generated"), 50.0)


def displaced_and_bumped(t: Tree):
    _displaced(t, "BOTH", t.coordinates("Generated"), 50.0)


def displaced_and_bumped_by_place(t: Tree):
    """The places are those of the mesh before it was displaced."""
    _displaced(t, "BOTH", t.coordinates("Object"), 25.0)


def parallel_window(t: Tree):
    _parallel(t)
    _diffuse(t, _noise(t, t.coordinates("Window"), 8.0))


def islands(t: Tree):
    """The ball in pieces, cut along circles and meridians."""
    import bmesh
    import bpy

    mesh = bpy.context.object.data
    ball = bmesh.new()
    ball.from_mesh(mesh)

    def is_cut(edge) -> bool:
        a, b = (vertex.co for vertex in edge.verts)
        circles = abs(a.z - b.z) < 1e-4 and any(abs(a.z - height) < 0.05 for height in (-0.5, 0.0, 0.5))
        return circles or max(abs(a.x), abs(b.x)) < 1e-4 or max(abs(a.x - a.y), abs(b.x - b.y)) < 1e-4

    bmesh.ops.split_edges(ball, edges=[edge for edge in ball.edges if is_cut(edge)])
    ball.to_mesh(mesh)
    _diffuse(t, t.ramp(t.node("NewGeometry").outputs["Random Per Island"]))


def hollows(t: Tree):
    """Pointiness of a ball with waves, cut open in places: vertices at one place count as one."""
    import bpy

    islands(t)
    mesh = bpy.context.object.data
    places = np.empty((len(mesh.vertices), 3), np.float32)
    mesh.vertices.foreach_get("co", places.reshape(-1))
    places *= (1.0 + 0.05 * np.sin(9.0 * places[:, 2]) * np.cos(7.0 * places[:, 0]))[:, None]
    mesh.vertices.foreach_set("co", places.reshape(-1))
    mesh.update()
    pointed = t.node("NewGeometry").outputs["Pointiness"]
    value = t.node("MapRange", Value=pointed, From_Min=0.45, From_Max=0.6, To_Min=0.05, To_Max=0.95)
    _diffuse(t, value.outputs[0])


def _beside_a_wall(t: Tree):
    """A floor under the ball and a wall behind it, of the same material."""
    import bpy

    ball = bpy.context.object
    for place, turn in (((0.0, 0.0, -1.0), 0.0), ((0.0, 1.3, 0.0), np.pi / 2)):
        bpy.ops.mesh.primitive_plane_add(size=8.0, location=place, rotation=(turn, 0.0, 0.0))
        bpy.context.object.data.materials.append(material_of(t))
    bpy.context.view_layer.objects.active = ball


def _occluded(t: Tree, settings: dict | None = None, **inputs):
    _beside_a_wall(t)
    return t.node("AmbientOcclusion", {"samples": 8, **(settings or {})}, **inputs)


def glowing_where_open(t: Tree):
    made = _occluded(t, Distance=1.5, Color=(0.9, 0.5, 0.2, 1.0))
    t.shows(t.node("Emission", Color=made.outputs["Color"]).outputs[0])


def dirty_corners(t: Tree):
    """Under a shader, by a normal that is bent."""
    made = _occluded(t, Distance=0.8, Normal=_waves(t, 0.3))
    _diffuse(t, t.ramp(made.outputs["AO"]))


def thin_places(t: Tree):
    made = _occluded(t, {"inside": True}, Distance=2.5)
    t.shows(t.node("Emission", Color=t.ramp(made.outputs["AO"])).outputs[0])


def own_hollows(t: Tree):
    made = _occluded(t, {"only_local": True, "inside": True}, Distance=1.5)
    t.shows(t.node("Emission", Color=made.outputs["AO"]).outputs[0])


def transparent_corners(t: Tree):
    """What paths pass and shadows do not depends on how lights are sampled; what glows is only looked at."""
    made = _occluded(t, Distance=1.0)
    clear, glow = t.node("BsdfTransparent"), t.node("Emission", Color=(0.3, 0.7, 0.5, 1.0))
    t.shows(t.node("MixShader", _0=made.outputs["AO"], _1=clear.outputs[0], _2=glow.outputs[0]).outputs[0])


def _as_block(t: Tree):
    """A turned block in place of the ball."""
    import bpy

    bpy.context.object.hide_render = True
    bpy.ops.mesh.primitive_cube_add(size=1.3, rotation=(0.6, 0.3, 0.5), scale=(1.0, 1.2, 0.8))
    bpy.context.object.data.materials.append(material_of(t))


def _half(t: Tree, normal):
    """Components of a normal as a colour."""
    return t.node(
        "VectorMath", {"operation": "MULTIPLY_ADD"}, _0=normal, _1=(0.4, 0.4, 0.4), _2=(0.5, 0.5, 0.5)
    ).outputs[0]


def bevelled_edges(t: Tree):
    _as_block(t)
    normal = t.node("Bevel", {"samples": 16}, Radius=0.3).outputs[0]
    t.shows(t.node("Emission", Color=_half(t, normal)).outputs[0])


def bevelled_ball(t: Tree):
    """What is smooth already; the radius reaches through it."""
    normal = t.node("Bevel", {"samples": 16}, Radius=0.9).outputs[0]
    t.shows(t.node("Emission", Color=_half(t, normal)).outputs[0])


def bevelled_and_bumped(t: Tree):
    _as_block(t)
    normal = t.node("Bevel", {"samples": 8}, Radius=0.2, Normal=_waves(t, 0.3)).outputs[0]
    t.shows(t.node("BsdfGlossy", Color=(0.8, 0.7, 0.6, 1.0), Roughness=0.3, Normal=normal).outputs[0])


def bevelled_in_a_mirror(t: Tree):
    """A cube in a polished floor, where its edges are bevelled, and in a rough wall, where they are not."""
    import bpy

    _beside_a_wall(t)
    _as_block(t)
    for name, roughness in (("Plane", 0.02), ("Plane.001", 0.5)):
        made = bpy.data.materials.new(name)
        made.use_nodes = True
        shader = made.node_tree.nodes.new("ShaderNodeBsdfGlossy")
        shader.inputs["Roughness"].default_value = roughness
        made.node_tree.links.new(shader.outputs[0], made.node_tree.nodes["Material Output"].inputs["Surface"])
        bpy.data.objects[name].data.materials[0] = made
    normal = t.node("Bevel", {"samples": 8}, Radius=0.4).outputs[0]
    t.shows(t.node("Emission", Color=_half(t, normal)).outputs[0])


def random_instances(t: Tree):
    """Blocks at the vertices of a mesh, coloured by what numbers them and by where they stand."""
    import bpy

    bpy.context.object.hide_render = True
    bpy.ops.mesh.primitive_cube_add(size=0.32, rotation=(0.4, 0.2, 0.1))
    block = bpy.context.object
    block.data.materials.append(material_of(t))
    points = bpy.data.meshes.new("Points")
    points.from_pydata([(0.5 * x, 0.3 * (x - z), 0.5 * z) for x in range(-2, 3) for z in range(-2, 3)], [], [])
    parent = bpy.data.objects.new("Points", points)
    bpy.context.scene.collection.objects.link(parent)
    parent.instance_type, block.parent = "VERTS", parent
    info = t.node("ObjectInfo")
    place = t.node("SeparateXYZ", Vector=info.outputs["Location"])
    height = t.node("MapRange", Value=place.outputs["Z"], From_Min=-1.0, From_Max=1.0, To_Min=0.1, To_Max=0.9)
    colour = t.node("CombineXYZ", X=info.outputs["Random"], Y=height.outputs[0], Z=0.2)
    t.shows(t.node("Emission", Color=colour.outputs[0]).outputs[0])


def smooth_noise(t: Tree):
    """Every way to sum octaves, of which with a roughness of 0 the first counts alone."""

    def summed(kind: str):
        noise = t.node(
            "TexNoise",
            {"noise_type": kind, "normalize": False},
            Vector=t.coordinates("Object"),
            Scale=2.0,
            Detail=3.5,
            Roughness=0.0,
        )
        for socket in noise.inputs:
            if socket.name in {"Offset", "Gain"}:
                socket.default_value = 0.7
        return noise.outputs[0]

    first = t.node("CombineXYZ", X=summed("FBM"), Y=summed("MULTIFRACTAL"), Z=summed("HYBRID_MULTIFRACTAL")).outputs[0]
    second = t.node("CombineXYZ", X=summed("RIDGED_MULTIFRACTAL"), Y=summed("HETERO_TERRAIN")).outputs[0]
    both = t.node("VectorMath", {"operation": "ADD"}, _0=first, _1=second).outputs[0]
    t.shows(t.node("Emission", Color=t.node("VectorMath", {"operation": "ABSOLUTE"}, _0=both).outputs[0]).outputs[0])


MATERIALS = (
    camera_coordinates, window_coordinates, view_vector, view_depth_and_distance, into_the_camera, coat_over_bumps,
    bumped_coat, brushed_by_uv, brushed_about_x, brushed_metallic, brushed_in_its_space, brushed_in_its_space_by_nodes,
    wires, wires_in_pixels, wires_behind_a_clip, wires_in_a_mirror, parallel_wires, parallel_bump, parallel_window,
    displaced_as_a_bump, displaced_and_bumped, displaced_and_bumped_by_place, islands, hollows, glowing_where_open, dirty_corners, thin_places, own_hollows,
    transparent_corners, bevelled_edges, bevelled_ball, bevelled_and_bumped, bevelled_in_a_mirror,
    random_instances, smooth_noise,
)  # fmt: skip


#: Of nodes that are handed over as those of others are.
ALIKE = {
    view_vector, into_the_camera, brushed_about_x, brushed_metallic, brushed_in_its_space_by_nodes, wires, wires_behind_a_clip, parallel_window, dirty_corners, thin_places,
    own_hollows, transparent_corners, bevelled_ball, bevelled_and_bumped,
}  # fmt: skip


@pytest.mark.parametrize(
    "graph",
    [pytest.param(graph, marks=[pytest.mark.once] * (graph in ALIKE)) for graph in MATERIALS],
    ids=lambda graph: graph.__name__,
)
def test_materials(stage, blender, tmp_path, graph):
    made, tree, surface = stage.material()
    blender.context.object.data.materials.append(made)
    graph(Tree(tree, surface))
    # 512 samples of 144 pixels: noise below 0.3 %. Edges of patterns fall between samples alike.
    alike(tmp_path, 0.02, floor=0.0)


def world_in_the_window(t: Tree):
    """A gradient that stands still on the picture, whatever the camera looks at."""
    parts = t.node("SeparateXYZ", Vector=t.coordinates("Window"))
    t.shows(t.node("Background", Color=t.ramp(parts.outputs["X"])).outputs[0])


def world_in_the_camera(t: Tree):
    t.shows(t.node("Background", Color=_noise(t, t.coordinates("Camera"))).outputs[0])


def world_by_camera_data(t: Tree):
    """Blender takes the direction for a place."""
    data = t.node("CameraData")
    far = t.node("MapRange", Value=data.outputs["View Distance"], From_Min=4.0, From_Max=6.0, To_Min=0.1, To_Max=0.9)
    deep = t.node("MapRange", Value=data.outputs["View Z Depth"], From_Min=4.0, From_Max=6.0, To_Min=0.1, To_Max=0.9)
    across = _noise(t, data.outputs["View Vector"], 9.0)
    both_ways = t.node("CombineXYZ", X=far.outputs[0], Y=deep.outputs[0], Z=0.2)
    t.shows(
        t.node(
            "Background",
            Color=t.node("VectorMath", {"operation": "ADD"}, _0=across, _1=both_ways.outputs[0]).outputs[0],
        ).outputs[0]
    )


WORLDS = (world_in_the_window, world_in_the_camera, world_by_camera_data)


@pytest.mark.first_only("build")
@pytest.mark.parametrize("build", WORLDS, ids=lambda one: one.__name__)
def test_worlds(stage, blender, tmp_path, build):
    _shift_camera()
    scene = blender.context.scene
    tree = stage.with_nodes(scene.world)
    output = tree.nodes.new("ShaderNodeOutputWorld")
    build(Tree(tree, output.inputs["Surface"]))
    made, nodes, surface = stage.material()
    shader = nodes.nodes.new("ShaderNodeBsdfPrincipled")
    nodes.links.new(shader.outputs[0], surface)
    blender.context.object.data.materials.append(made)
    alike(tmp_path, 0.02, floor=0.0)
