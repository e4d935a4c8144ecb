# SPDX-License-Identifier: GPL-3.0-or-later
"""What is sent of objects and their places, against Blender's own evaluated data."""

from __future__ import annotations

import math

import numpy as np
import pytest


def evaluated_corners(bpy, name: str) -> np.ndarray:
    """World positions of an object's triangles as Blender has them, one vertex at a time."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    holder = bpy.data.objects[name].evaluated_get(depsgraph)
    mesh = holder.to_mesh()
    mesh.calc_loop_triangles()
    corners = [[holder.matrix_world @ mesh.vertices[v].co for v in one.vertices] for one in mesh.loop_triangles]
    holder.to_mesh_clear()
    return np.array(corners, float).reshape(-1, 3, 3)


def by_place(corners: np.ndarray) -> np.ndarray:
    """Triangles in an order of their own, so that two lists can be compared."""
    flat = np.round(corners, 4).reshape(len(corners), 3, 3)
    flat = np.array([sorted(map(tuple, one)) for one in flat]).reshape(len(corners), 9)
    return flat[np.lexsort(flat.T[::-1])]


def same_triangles(found: np.ndarray, wanted: np.ndarray) -> None:
    assert len(wanted) > 0
    assert found.shape == wanted.shape
    assert np.allclose(by_place(found), by_place(wanted), atol=2e-3)


MAKERS = {
    "cube": lambda ops: ops.mesh.primitive_cube_add(location=(1, 2, 3), rotation=(0.3, 0.5, 0.7), scale=(1, 2, -3)),
    "ngon": lambda ops: ops.mesh.primitive_circle_add(vertices=9, fill_type="NGON"),
    "monkey": lambda ops: ops.mesh.primitive_monkey_add(),
    "curve": lambda ops: ops.curve.primitive_bezier_circle_add(),
    "surface": lambda ops: ops.surface.primitive_nurbs_surface_sphere_add(),
    "text": lambda ops: ops.object.text_add(),
    "metaball": lambda ops: ops.object.metaball_add(radius=1.0),
}


@pytest.mark.parametrize("kind", MAKERS)
def test_triangles(parts, blender, kind):
    MAKERS[kind](blender.ops)
    made = blender.context.object
    made.name = "Made"
    if kind == "curve":
        made.data.bevel_depth = 0.2
    if kind == "metaball":
        # Otherwise a render is finer than the view.
        made.data.resolution = made.data.render_resolution
    recorder, warnings, _ = parts.sent()
    (instance,) = recorder.of(made.name)
    same_triangles(recorder.corners(instance), evaluated_corners(blender, made.name))
    assert not warnings
    scene = recorder.build()
    # Blender makes a few triangles without area itself, at poles and in letters.
    sent = len(recorder.meshes[instance["mesh"]]["triangles"])
    assert 0.95 * sent < scene.triangle_count <= sent


def test_a_curve_without_thickness_has_nothing(parts, blender):
    blender.ops.curve.primitive_bezier_curve_add()
    recorder, warnings, _ = parts.sent()
    assert not recorder.instances and not warnings


def test_modifiers_are_applied(parts, blender):
    blender.ops.mesh.primitive_cube_add()
    made = blender.context.object
    made.modifiers.new("Subdivide", "SUBSURF").render_levels = 3
    made.modifiers["Subdivide"].levels = 1
    array = made.modifiers.new("Array", "ARRAY")
    array.count = 2
    recorder, _, _ = parts.sent()
    (instance,) = recorder.of("Cube")
    # Renders take the render levels: 6 * 4^3 quads, two of each.
    assert len(recorder.meshes[instance["mesh"]]["triangles"]) == 6 * 4**3 * 2 * 2


def wanted_normals(bpy, name: str) -> np.ndarray:
    """By triangle and corner, as Blender has them."""
    holder = bpy.data.objects[name].evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = holder.data
    mesh.calc_loop_triangles()
    return np.array([[mesh.corner_normals[loop].vector for loop in one.loops] for one in mesh.loop_triangles])


def test_a_mesh_that_is_being_edited(parts, blender):
    """A file may be saved, and rendered, in edit mode; then Blender's evaluated mesh is empty."""
    blender.ops.mesh.primitive_cube_add(size=2.0, location=(1.0, 2.0, 3.0))
    cube = blender.context.object
    cube.modifiers.new("Subdivision", "SUBSURF").render_levels = 1
    blender.ops.object.mode_set(mode="EDIT")
    recorder, warnings, _ = parts.sent()
    assert not warnings
    (instance,) = recorder.of(cube.name)
    same_triangles(recorder.corners(instance), evaluated_corners(blender, cube.name))
    blender.ops.object.mode_set(mode="OBJECT")


@pytest.mark.parametrize("shade", ["smooth", "some sharp edges", "some flat faces", "custom"])
def test_smooth_normals(parts, blender, shade):
    blender.ops.mesh.primitive_uv_sphere_add(segments=8, ring_count=6)
    mesh = blender.context.object.data
    for index, face in enumerate(mesh.polygons):
        face.use_smooth = shade != "some flat faces" or index % 3 != 0
    if shade == "some sharp edges":
        for index, edge in enumerate(mesh.edges):
            edge.use_edge_sharp = index % 4 == 0
    if shade == "custom":
        mesh.normals_split_custom_set([(0.0, 0.6, 0.8)] * len(mesh.loops))
    recorder, _, _ = parts.sent()
    (sent,) = recorder.meshes
    # No more of them than the mesh has.
    assert len(sent["corner_normals"][1]) == (len(mesh.vertices) if shade == "smooth" else len(mesh.loops))
    assert np.allclose(parts.at_corners(sent, sent["corner_normals"]), wanted_normals(blender, "Sphere"), atol=1e-4)


def test_flat_faces_have_no_normals(parts, blender):
    blender.ops.mesh.primitive_uv_sphere_add(segments=8, ring_count=6)
    blender.context.object.data.shade_flat()
    recorder, _, _ = parts.sent()
    assert recorder.meshes[0]["corner_normals"] is None


def test_uv_maps_by_name_the_rendered_one_first(parts, blender):
    blender.ops.mesh.primitive_cube_add()
    mesh = blender.context.object.data
    second = mesh.uv_layers.new(name="Second")
    for index, point in enumerate(second.uv):
        point.vector = (index * 0.1, -index * 0.2)
    second.active_render = True
    recorder, _, _ = parts.sent()
    maps = recorder.meshes[0]["uv_maps"]
    assert list(maps) == ["Second", "UVMap"]
    mesh = blender.context.object.evaluated_get(blender.context.evaluated_depsgraph_get()).data
    mesh.calc_loop_triangles()
    for name, sent in maps.items():
        layer = mesh.uv_layers[name]
        wanted = [[layer.uv[loop].vector for loop in one.loops] for one in mesh.loop_triangles]
        assert np.allclose(parts.at_corners(recorder.meshes[0], sent), wanted, atol=1e-6)


def test_material_slots(parts, blender):
    colours = [(1, 0, 0), (0, 1, 0), (0, 0, 1)]
    materials = [parts.emitter(colour, name=f"Colour {index}") for index, colour in enumerate(colours)]
    blender.ops.mesh.primitive_cube_add()
    made = blender.context.object
    for one in materials:
        made.data.materials.append(one)
    for index, face in enumerate(made.data.polygons):
        face.material_index = index % 3
    # One slot belongs to the object instead of the mesh.
    made.material_slots[1].link = "OBJECT"
    made.material_slots[1].material = materials[0]
    recorder, _, _ = parts.sent()
    (instance,) = recorder.instances
    names = [recorder.materials[index].name for index in instance["materials"]]
    assert names == ["Colour 0", "Colour 0", "Colour 2"]
    assert len(recorder.materials) == 2
    mesh = made.data
    mesh.calc_loop_triangles()
    assert recorder.meshes[0]["material_slots"].tolist() == [one.material_index for one in mesh.loop_triangles]


def test_shared_data_is_sent_once(parts, blender):
    blender.ops.mesh.primitive_monkey_add()
    mesh = blender.context.object.data
    for index in range(5):
        twin = blender.data.objects.new(f"Twin {index}", mesh)
        twin.location.x = index
        blender.context.scene.collection.objects.link(twin)
    # With a modifier of its own it is a mesh of its own.
    other = blender.data.objects.new("Other", mesh)
    other.modifiers.new("Subdivide", "SUBSURF")
    blender.context.scene.collection.objects.link(other)
    recorder, _, _ = parts.sent()
    assert len(recorder.instances) == 7
    assert len(recorder.meshes) == 2
    assert len({one["mesh"] for one in recorder.instances if one["name"].startswith("Twin")}) == 1


def test_a_lights_nodes_are_read_once(parts, blender, monkeypatch):
    from support.node_tree import Tree

    light = blender.data.lights.new("Lamp", "POINT")
    light.use_nodes = True
    tree = parts.with_nodes(light)
    t = Tree(tree, tree.nodes.new("ShaderNodeOutputLight").inputs["Surface"])
    t.shows(t.node("Emission", Color=t.ramp(t.node("TexNoise").outputs[0])).outputs[0])
    for index in range(5):
        holder = blender.data.objects.new(f"Lamp {index}", light)
        holder.location.x = index
        blender.context.scene.collection.objects.link(holder)
    graph, read = parts.part("export.graph"), []
    describe = graph.describe
    monkeypatch.setattr(
        graph, "describe", lambda tree, of: read.append("Color Ramp" in tree.nodes) or describe(tree, of)
    )
    recorder, _, _ = parts.sent()
    # The world's has no ramp.
    assert read.count(True) == 1
    assert len(recorder.lights) == 5 and len({one.graph for one in recorder.lights}) == 1
    assert recorder.lights[0].graph and len({one.matrix_world for one in recorder.lights}) == 5


def test_a_plain_world_is_a_colour_or_an_image(parts, blender):
    """All others are their nodes."""
    world = blender.context.scene.world = parts.grey_world(0.5)
    tree = world.node_tree
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    background.inputs["Strength"].default_value = 2.0

    def sent():
        return parts.sent()[0].world

    assert (sent().color, sent().image, sent().graph) == ((1.0, 1.0, 1.0), None, None)
    image = tree.nodes.new("ShaderNodeTexEnvironment")
    image.image = blender.data.images.new("sky", 8, 4)
    mapping = tree.nodes.new("ShaderNodeMapping")
    mapping.inputs["Rotation"].default_value = (0.0, 0.0, math.pi / 2.0)
    place = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(place.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs[0], image.inputs["Vector"])
    tree.links.new(image.outputs["Color"], background.inputs["Color"])
    assert sent().color == (2.0, 2.0, 2.0) and sent().image is not None and sent().graph is None
    assert np.allclose(sent().rotation, [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], atol=1e-6)
    mapping.inputs["Scale"].default_value[0] = 2.0
    assert sent().graph is not None
    tree.links.remove(background.outputs[0].links[0])
    assert (sent().color, sent().image, sent().graph) == ((0.0, 0.0, 0.0), None, None)


def test_texts_with_one_font_are_not_mixed_up(parts, blender):
    for words in ("first", "the second"):
        blender.ops.object.text_add()
        blender.context.object.name = words
        blender.context.object.data.body = words
    twin = blender.data.objects.new("twin", blender.data.objects["first"].data)
    twin.modifiers.new("Solid", "SOLIDIFY").thickness = 0.1
    blender.context.scene.collection.objects.link(twin)
    recorder, _, _ = parts.sent()
    for name in ("first", "the second", "twin"):
        (instance,) = recorder.of(name)
        same_triangles(recorder.corners(instance), evaluated_corners(blender, name))


def test_collection_instances(parts, blender):
    shelf = blender.data.collections.new("Shelf")
    cube = parts.square("Inside", (1, 0, 0), 1.0)
    blender.context.scene.collection.objects.unlink(cube)
    shelf.objects.link(cube)
    lamp = blender.data.objects.new("Lamp", blender.data.lights.new("Lamp", "POINT"))
    shelf.objects.link(lamp)
    for index in range(3):
        empty = blender.data.objects.new(f"Empty {index}", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", shelf
        empty.location = (0, 0, 2 * index)
        empty.scale = (1, 1, -2)
        blender.context.scene.collection.objects.link(empty)
    recorder, warnings, _ = parts.sent()
    places = recorder.of("Inside")
    assert len(places) == 3 and len(recorder.meshes) == 1
    assert sorted(round(one["matrix"][2, 3], 5) for one in places) == [0, 2, 4]
    for one in places:
        assert np.linalg.det(one["matrix"][:3, :3]) == pytest.approx(-2.0)
    assert len(recorder.lights) == 3
    assert not warnings


def test_geometry_nodes_instances(parts, blender):
    """A grid of 3 x 4 points with a cube on each, never made real."""
    base = parts.square("Base", (0, 0, 0), 1.0)
    tree = blender.data.node_groups.new("Points", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    grid = tree.nodes.new("GeometryNodeMeshGrid")
    grid.inputs["Vertices X"].default_value, grid.inputs["Vertices Y"].default_value = 3, 4
    cube = tree.nodes.new("GeometryNodeMeshCube")
    cube.inputs["Size"].default_value = (0.1, 0.1, 0.1)
    place = tree.nodes.new("GeometryNodeInstanceOnPoints")
    out = tree.nodes.new("NodeGroupOutput")
    tree.links.new(grid.outputs["Mesh"], place.inputs["Points"])
    tree.links.new(cube.outputs["Mesh"], place.inputs["Instance"])
    tree.links.new(place.outputs[0], out.inputs[0])
    base.modifiers.new("Nodes", "NODES").node_group = tree
    base.location = (5, 0, 0)
    recorder, _, _ = parts.sent()
    places = [one for one in recorder.instances if len(recorder.meshes[one["mesh"]]["triangles"]) == 12]
    assert len(places) == 12
    assert len(recorder.meshes) == 1
    xs = sorted({round(float(one["matrix"][0, 3]), 4) for one in places})
    assert xs == [4.5, 5.0, 5.5]
    # All by one call, each with its own place and number: a meadow has a million.
    assert recorder.calls["add_instance"] == 1
    graph = blender.context.evaluated_depsgraph_get()
    stand = [(np.array(one.matrix_world), one.random_id) for one in graph.object_instances if one.is_instance]
    for one, (matrix, number) in zip(places, stand, strict=True):
        assert np.array_equal(one["matrix"], matrix)
        assert one["info"][2] == pytest.approx((number & 0xFFFFFFFF) / 0xFFFFFFFF)
    assert len({one["info"][2] for one in places}) == 12


def test_materials_that_geometry_nodes_set(parts, blender):
    """On the object's own mesh and on the mesh of its instances."""
    colours = {"Own": (1.0, 0.0, 0.0), "Instance": (0.0, 1.0, 0.0)}
    materials = {name: parts.emitter(colour, name=name) for name, colour in colours.items()}
    base = parts.square("Base", (0, 0, 0), 1.0)
    tree = blender.data.node_groups.new("Paint", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    start, out = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    cube, place = tree.nodes.new("GeometryNodeMeshCube"), tree.nodes.new("GeometryNodeInstanceOnPoints")
    join = tree.nodes.new("GeometryNodeJoinGeometry")
    paint = {}
    for name, material in materials.items():
        paint[name] = tree.nodes.new("GeometryNodeSetMaterial")
        paint[name].inputs["Material"].default_value = material
    tree.links.new(start.outputs[0], paint["Own"].inputs["Geometry"])
    tree.links.new(cube.outputs["Mesh"], paint["Instance"].inputs["Geometry"])
    tree.links.new(start.outputs[0], place.inputs["Points"])
    tree.links.new(paint["Instance"].outputs[0], place.inputs["Instance"])
    tree.links.new(paint["Own"].outputs[0], join.inputs[0])
    tree.links.new(place.outputs[0], join.inputs[0])
    tree.links.new(join.outputs[0], out.inputs[0])
    base.modifiers.new("Nodes", "NODES").node_group = tree
    recorder, _, _ = parts.sent()
    seen = {}
    for one in recorder.instances:
        sent = recorder.meshes[one["mesh"]]
        slots = sent["material_slots"] if sent["material_slots"] is not None else [0]
        names = {recorder.materials[one["materials"][slot]].name for slot in slots}
        seen.setdefault(len(sent["triangles"]), []).append(names)
    assert seen == {2: [{"Own"}], 12: [{"Instance"}] * 4}


def test_particles_as_objects(parts, blender):
    blender.ops.mesh.primitive_ico_sphere_add(radius=0.05)
    seed = blender.context.object
    blender.ops.mesh.primitive_grid_add(x_subdivisions=4, y_subdivisions=4)
    emitter = blender.context.object
    emitter.modifiers.new("Hair", "PARTICLE_SYSTEM")
    settings = emitter.particle_systems[0].settings
    settings.type, settings.count = "HAIR", 25
    settings.render_type, settings.instance_object = "OBJECT", seed
    seed.hide_render = True
    recorder, warnings, _ = parts.sent()
    places = [one for one in recorder.instances if one["name"].startswith("Icosphere")]
    assert len(places) == 25
    assert len(recorder.meshes) == 2
    assert len({tuple(one["matrix"][:3, 3].round(4)) for one in places}) == 25
    assert not warnings


def test_what_is_hidden_is_not_sent(parts, blender):
    names = ("Seen", "Hidden render", "Hidden collection", "Excluded", "Hidden camera", "Hidden shadow")
    squares = {name: parts.square(name, (0, 5, 0), 1.0) for name in names}
    squares["Hidden render"].hide_render = True
    for name in ("Hidden collection", "Excluded"):
        shelf = blender.data.collections.new(name)
        blender.context.scene.collection.children.link(shelf)
        blender.context.scene.collection.objects.unlink(squares[name])
        shelf.objects.link(squares[name])
    blender.data.collections["Hidden collection"].hide_render = True
    blender.context.view_layer.layer_collection.children["Excluded"].exclude = True
    squares["Hidden camera"].visible_camera = False
    squares["Hidden shadow"].visible_shadow = False
    # Hidden in the view alone: rendered.
    squares["Seen"].hide_viewport = False
    squares["Seen"].hide_set(True)
    recorder, _, _ = parts.sent()
    assert {one["name"] for one in recorder.instances} == {"Seen", "Hidden camera", "Hidden shadow"}
    assert recorder.of("Hidden camera")[0]["hidden_from"] == ("CAMERA",)
    assert recorder.of("Hidden shadow")[0]["hidden_from"] == ("SHADOW",)


def test_a_camera_ray_passes_what_the_camera_must_not_see(parts, tmp_path):
    glow = parts.square("Glow", (0, 5, 0), 1.0, parts.emitter(strength=5.0))
    assert parts.render(tmp_path)[16, 24, 0] == pytest.approx(5.0, rel=1e-3)
    glow.visible_camera = False
    assert parts.render(tmp_path)[16, 24, 0] == pytest.approx(0.5, rel=1e-3)


def test_linked_data(parts, blender, tmp_path):
    parts.square("From elsewhere", (0, 5, 0), 1.0, parts.emitter((0.0, 1.0, 0.0)))
    blender.data.images.new("Unused", 8, 8)
    library = tmp_path / "library.blend"
    blender.ops.wm.save_as_mainfile(filepath=str(library))
    blender.ops.wm.read_factory_settings(use_empty=True)
    scene = parts.set_up()
    with blender.data.libraries.load(str(library), link=True) as (_, linked):
        linked.objects = ["From elsewhere", "Camera"]
    square, camera = linked.objects
    scene.collection.objects.link(square)
    # A camera of another file, its lens as that file has it.
    scene.collection.objects.link(camera)
    scene.camera = camera
    picture = parts.render(tmp_path)
    assert picture[16, 24, :3] == pytest.approx([0.0, 1.0, 0.0], abs=1e-3)


def test_hostile_meshes_are_rendered_around(parts, blender, tmp_path):
    nan = float("nan")
    parts.square("Behind", (0, 5, 0), 1.0, parts.emitter())
    parts.mesh_object("Nan", [(nan, 0, 0), (1, 2, 0), (0, 2, 1)], [(0, 1, 2)])
    parts.mesh_object("Flat", [(0, 2, 0), (0, 2, 0), (0, 2, 1)], [(0, 1, 2)])
    parts.mesh_object("Lone vertices", [(0, 2, 0)] * 3, [])
    parts.square("No size", (0, 4, 0), 1.0).scale = (0.0, 1.0, 0.0)
    parts.square("Far", (1e6, 6, 0), 1.0)
    picture = parts.render(tmp_path)
    assert np.isfinite(picture).all()
    assert picture[16, 24, :3] == pytest.approx([1.0] * 3, abs=1e-3)
    assert parts.part("render.statistics").last("Scene").stats["non_finite_samples"] == 0


def test_a_volume_without_its_file_is_said(parts, blender, tmp_path):
    data = blender.data.volumes.new("Fog")
    data.filepath = str(tmp_path / "none.vdb")
    blender.context.scene.collection.objects.link(blender.data.objects.new("Fog", data))
    # An empty one is nothing to speak of.
    blender.context.scene.collection.objects.link(blender.data.objects.new("Empty", blender.data.volumes.new("Empty")))
    _, warnings, _ = parts.sent()
    assert len(warnings) == 1 and warnings[0].startswith("Object 'Fog': its volume file is left out: "), warnings
