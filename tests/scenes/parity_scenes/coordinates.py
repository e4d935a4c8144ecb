# SPDX-License-Identifier: GPL-3.0-or-later
"""What nodes know of the place: coordinates, attributes, objects, normals, the path."""

from __future__ import annotations

import bpy
import numpy as np

from support.scenes import image

from . import scene
from .studio import (
    BLUE,
    CREAM,
    DARK,
    GOLD,
    GREEN,
    RED,
    WHITE,
    ball,
    cube,
    empty_studio,
    material,
    monkey,
    plain,
    plane,
    put,
)


def _pair(first, second, **studio) -> None:
    empty_studio(**studio)
    monkey(first, (-0.75, 0.0, 0.85), 1.7, turn=20)
    ball(second, (1.15, -0.3, 0.8), 0.8)


@scene("Generated, normal and reflected coordinates as colours")
def coordinates_as_colours():
    empty_studio()
    kinds = [("Generated", (-1.5, 0.0)), ("Normal", (-0.5, 0.4)), ("Object", (0.5, -0.3)), ("Reflection", (1.5, 0.2))]
    for kind, (x, y) in kinds:

        def build(t, kind=kind):
            halved = t.node(
                "VectorMath", {"operation": "MULTIPLY_ADD"}, _0=t.coordinates(kind), _1=(0.5,) * 3, _2=(0.5,) * 3
            )
            t.shows(t.diffuse(halved.outputs[0]))

        ball(material(build), (x, y, 0.5), 0.5)


@scene("Coordinates of another object, turned and mapped")
def mapping():
    empty_studio()
    guide = put(bpy.data.objects.new("Guide", None), (0.3, 0.2, 0.5), (20, 30, 40), 0.7)

    def build(t):
        where = t.node("TexCoord", {"object": guide}).outputs["Object"]
        turned = t.node("VectorRotate", {"rotation_type": "AXIS_ANGLE"}, Vector=where, Axis=(1.0, 1.0, 0.0), Angle=0.8)
        mapped = t.node(
            "Mapping",
            {"vector_type": "TEXTURE"},
            Vector=turned.outputs[0],
            Rotation=(0.3, 0.1, 0.7),
            Scale=(0.6, 1.2, 0.9),
        )
        t.shows(t.diffuse(t.node("TexChecker", Vector=mapped.outputs[0], Scale=3.1, Color1=GOLD, Color2=BLUE).outputs[0]))  # fmt: skip

    _built = material(build)
    monkey(_built, (-0.75, 0.0, 0.85), 1.7, turn=20)
    cube(_built, (1.15, -0.3, 0.6), 1.2)


@scene("Two UV maps")
def uv_maps():
    empty_studio()
    sheet = plane(None, (0.0, 0.0, 1.1), 2.6, (75, 0, 10))
    second = sheet.data.uv_layers.new(name="Turned")
    second.uv.foreach_set("vector", np.array([0, 0, 0, 2, -2, 2, -2, 0], np.float32))

    def build(t):
        first = t.node("TexChecker", Vector=t.coordinates("UV"), Scale=5.0, Color1=RED, Color2=CREAM).outputs[0]
        turned = t.node("UVMap", {"uv_map": "Turned"}).outputs[0]
        waves = t.node("TexWave", Vector=turned, Scale=2.0).outputs[1]
        t.shows(t.diffuse(t.mixed_colour(waves, first, BLUE)))

    sheet.data.materials.append(material(build))


@scene("A colour attribute and one by face")
def attributes():
    def painted(t):
        colour = t.node("VertexColor", {"layer_name": "Paint"}).outputs["Color"]
        t.shows(t.diffuse(colour))

    def by_face(t):
        value = t.node("Attribute", {"attribute_name": "share"}).outputs["Fac"]
        t.shows(t.diffuse(t.ramp(value, (0.0, DARK), (1.0, GOLD))))

    empty_studio()
    head = monkey(material(painted), (-0.75, 0.0, 0.85), 1.7, turn=20)
    mesh = head.data
    paint = mesh.color_attributes.new("Paint", "FLOAT_COLOR", "POINT")
    where = np.empty(len(mesh.vertices) * 3, np.float32)
    mesh.vertices.foreach_get("co", where)
    colours = np.concatenate(
        [0.5 + 0.45 * where.reshape(-1, 3) / np.abs(where).max(), np.ones((len(mesh.vertices), 1))], 1
    )
    paint.data.foreach_set("color", colours.astype(np.float32).reshape(-1))
    globe = ball(material(by_face), (1.15, -0.3, 0.8), 0.8)
    share = globe.data.attributes.new("share", "FLOAT", "FACE")
    share.data.foreach_set("value", np.linspace(0.0, 1.0, len(globe.data.polygons)).astype(np.float32))


@scene("Object Info over twenty objects of one mesh")
def object_info():
    empty_studio()

    def build(t):
        info = t.node("ObjectInfo")
        hue = t.node("HueSaturation", Hue=info.outputs["Random"], Color=(0.8, 0.15, 0.1, 1.0))
        t.shows(t.principled(Base_Color=t.mixed_colour(0.3, hue.outputs[0], info.outputs["Color"]), Roughness=0.4))

    first = ball(material(build), (-2.0, -0.8, 0.3), 0.3)
    for i in range(1, 20):
        other = bpy.data.objects.new("Ball", first.data)
        other.color = (0.1, (i % 5) / 5, 0.9, 1.0)
        put(other, (-2.0 + 1.0 * (i % 5), -0.8 + 0.9 * (i // 5), 0.3))


@scene("Layer Weight and Fresnel")
def layer_weight():
    def facing(t):
        share = t.node("LayerWeight", Blend=0.4).outputs["Facing"]
        t.shows(t.mix(share, t.diffuse(RED), t.diffuse(CREAM)))

    def fresnel(t):
        share = t.node("LayerWeight", Blend=0.6).outputs["Fresnel"]
        t.shows(t.diffuse(t.ramp(share, (0.0, BLUE), (0.5, GOLD))))

    _pair(material(facing), material(fresnel))


@scene("Geometry: place, normals, which side")
def geometry():
    def stripes(t):
        height = t.node("SeparateXYZ", Vector=t.node("NewGeometry").outputs["Position"]).outputs["Z"]
        t.shows(t.diffuse(t.ramp(t.math("FRACT", t.math("MULTIPLY", height, 4.0)), (0.45, GREEN), (0.55, CREAM))))

    def sides(t):
        place = t.node("NewGeometry")
        slope = t.node("SeparateXYZ", Vector=place.outputs["True Normal"]).outputs["Z"]
        t.shows(t.diffuse(t.mixed_colour(place.outputs["Backfacing"], t.ramp(slope, (0.3, BLUE), (0.7, WHITE)), RED)))

    empty_studio()
    monkey(material(stripes), (-0.75, 0.0, 0.85), 1.7, turn=20)
    bpy.ops.mesh.primitive_cone_add(
        radius1=0.9, depth=1.6, end_fill_type="NOTHING", location=(1.2, -0.2, 0.95), rotation=(2.4, 0.3, 0)
    )
    bpy.context.object.data.materials.append(material(sides))


@scene("Bump, on paint and on metal")
def bump():
    def bumped(t, **inputs):
        waves = t.node("TexNoise", Vector=t.coordinates("Object"), Scale=6.0, Detail=1.0)
        bent = t.node("Bump", Strength=0.5, Distance=0.08, Height=waves.outputs[0])
        t.shows(t.principled(Normal=bent.outputs[0], **inputs))

    _pair(
        material(lambda t: bumped(t, Base_Color=RED, Roughness=0.5)),
        material(lambda t: bumped(t, Base_Color=GOLD, Metallic=1.0, Roughness=0.3)),
    )


@scene("Normal map from an image")
def normal_map():
    empty_studio()
    y, x = np.mgrid[0:128, 0:128] / 128.0
    slope_x, slope_y = 0.5 * np.cos(40 * x), 0.5 * np.cos(40 * y)
    normals = np.stack([-slope_x, -slope_y, np.ones_like(x)], 2)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    pixels = np.concatenate([0.5 + 0.5 * normals, np.ones((128, 128, 1))], 2)
    bumps = image("bumps", pixels, space="Non-Color")

    def build(t):
        texture = t.node("TexImage", {"image": bumps})
        bent = t.node("NormalMap", Strength=0.8, Color=texture.outputs["Color"])
        t.shows(t.principled(Base_Color=CREAM, Roughness=0.35, Normal=bent.outputs[0]))

    cube(material(build), (-0.9, 0.2, 0.75), 1.5)
    ball(material(build), (1.1, -0.3, 0.8), 0.8)


def _lifted(t) -> None:
    t.shows(t.principled(Base_Color=GREEN, Roughness=0.4))
    cells = t.node("TexVoronoi", {"feature": "SMOOTH_F1"}, Vector=t.coordinates("Object"), Scale=4.0)
    t.lifts(t.node("Displacement", Height=cells.outputs["Distance"], Scale=0.15).outputs[0])


@scene("Displacement, as a bump")
def displacement_bump():
    surface = material(_lifted)
    surface.displacement_method = "BUMP"
    _pair(surface, plain(CREAM))


@scene("Displacement that moves the mesh")
def displacement_mesh():
    surface = material(_lifted)
    surface.displacement_method = "DISPLACEMENT"
    empty_studio()
    monkey(surface, (-0.75, 0.0, 0.85), 1.7, turn=20, levels=3)
    ball(plain(CREAM), (1.15, -0.3, 0.8), 0.8)


def diced(thing: bpy.types.Object, kind: str) -> None:
    """Adaptive subdivision of an object, where Blender has it."""
    made = thing.modifiers.new("Adaptive", "SUBSURF")
    made.subdivision_type, made.levels, made.render_levels = kind, 0, 0
    if hasattr(made, "use_adaptive_subdivision"):
        made.use_adaptive_subdivision = True
    else:
        bpy.context.scene.cycles.feature_set, thing.cycles.use_adaptive_subdivision = "EXPERIMENTAL", True


@scene("Displacement with adaptive subdivision: a square of one face, and a cube that becomes round")
def displacement_adaptive():
    surface = material(_lifted)
    surface.displacement_method = "DISPLACEMENT"
    empty_studio()
    # Fine enough that it does not matter where the vertices come to lie.
    bpy.context.scene.cycles.dicing_rate = 0.25
    diced(plane(surface, (-0.9, 0.6, 0.9), 1.5, (70, 0, 20)), "SIMPLE")
    bpy.ops.mesh.primitive_cube_add(size=1.7, location=(1.1, -0.2, 0.85))
    bpy.context.object.data.materials.append(surface)
    bpy.ops.object.shade_smooth()
    diced(bpy.context.object, "CATMULL_CLARK")


@scene("Another colour to the camera than to the light (Light Path)")
def light_path():
    def two_faced(t):
        seen = t.node("LightPath").outputs["Is Camera Ray"]
        t.shows(t.diffuse(t.mixed_colour(seen, RED, CREAM)))

    _pair(material(two_faced), plain(CREAM, Roughness=0.1))
    plane(material(two_faced), (0.0, 3.9, 1.0), 3.0, (90, 0, 0))


def _capped(surface, *more):
    """A smooth tube with a closed end, three times as long as it is wide by the object's scale: normals differ much over a face."""
    bpy.ops.mesh.primitive_cylinder_add(
        vertices=16, radius=0.8, depth=1.0, end_fill_type="NGON", location=(0.0, 0.0, 1.0)
    )
    thing = bpy.context.object
    bpy.ops.object.shade_smooth()
    for one in (surface, *more):
        thing.data.materials.append(one)
    thing.scale = (1.0, 1.0, 3.0)
    thing.rotation_euler = (0.5, 1.2, 0.3)
    return thing


@scene("Smooth normals and a normal map on a thing that is scaled along one axis")
def stretched_normals():
    empty_studio()
    mapped = material(lambda t: t.shows(t.diffuse(Normal=t.node("NormalMap", Color=(0.9, 0.2, 0.8, 1.0)).outputs[0])))
    _capped(mapped)


@scene("A thing of two materials, of which one is displaced: the other keeps its normals")
def displaced_in_part():
    def lifted(t) -> None:
        t.shows(t.diffuse(RED))
        t.lifts(t.node("Displacement", Height=0.7, Scale=0.3).outputs[0])

    empty_studio()
    moved = material(lifted)
    moved.displacement_method = "BOTH"
    thing = _capped(plain(CREAM), moved)
    for face in thing.data.polygons:
        face.material_index = int(len(face.vertices) > 4)
