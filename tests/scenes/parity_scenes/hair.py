# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair and other curves: of hair curves objects, of particles, of geometry nodes."""

from __future__ import annotations

import bpy
import numpy as np

from . import scene
from .studio import BLUE, CREAM, GOLD, GREEN, RED, WHITE, Tree, ball, empty_studio, lamp, material, plain, put


def _drawn_as(shape: str, subdivisions: int = 2) -> None:
    settings = bpy.context.scene.cycles_curves
    # Before Blender 5 there were no straight ones.
    known = {item.identifier for item in settings.bl_rna.properties["shape"].enum_items}
    settings.shape = shape if shape in known else "THICK"
    settings.subdivisions = subdivisions


def grown(strands: int, keys: int, length: float, radius: float, surface, seed: int = 1, bend: float = 0.5):
    """A tuft about the origin, as a hair curves object."""
    dice = np.random.default_rng(seed)
    out = dice.normal(size=(strands, 3))
    out[:, 2] = np.abs(out[:, 2]) + 0.2
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    side = dice.normal(size=(strands, 3)) * bend
    share = np.linspace(0.0, 1.0, keys)[None, :, None]
    places = out[:, None] * (0.75 + length * share) + side[:, None] * share**2 * length
    places[:, :, 2] -= 0.5 * bend * length * share[:, :, 0] ** 2
    data = bpy.data.hair_curves.new("Hair")
    data.add_curves([keys] * strands)
    data.attributes["position"].data.foreach_set("vector", places.astype(np.float32).ravel())
    width = data.attributes.new("radius", "FLOAT", "POINT")
    taper = np.broadcast_to(radius * (1.0 - 0.8 * share[:, :, 0]), (strands, keys))
    width.data.foreach_set("value", taper.astype(np.float32).ravel())
    uv = data.attributes.new("surface_uv_coordinate", "FLOAT2", "CURVE")
    uv.data.foreach_set("vector", dice.random((strands, 2)).astype(np.float32).ravel())
    wet = data.attributes.new("wet", "FLOAT", "POINT")
    wet.data.foreach_set("value", np.broadcast_to(share[:, :, 0], (strands, keys)).astype(np.float32).ravel())
    data.materials.append(surface)
    return put(bpy.data.objects.new("Hair", data), (0.0, 0.0, 0.9))


def _principled_hair(**inputs):
    return material(lambda t: t.shows(t.node("BsdfHairPrincipled", {"model": "CHIANG"}, **inputs).outputs[0]))


@scene("Hair curves: Principled Hair under lamps")
def hair_curves():
    empty_studio()
    lamp("POINT", 200.0, (2.5, -3.0, 3.5), shadow_soft_size=0.2)
    ball(plain((0.3, 0.2, 0.15, 1.0)), (0.0, 0.0, 0.9), 0.75)
    grown(1500, 6, 0.7, 0.012, _principled_hair(Color=(0.45, 0.2, 0.08, 1.0), Roughness=0.35, Radial_Roughness=0.4))


def _huang(aspect=1.0, **inputs):
    """Fibres by facets."""
    return material(
        lambda t: t.shows(t.node("BsdfHairPrincipled", {"model": "HUANG"}, Aspect_Ratio=aspect, **inputs).outputs[0])
    )


@scene("Principled Hair by Huang under lamps: thin hair, and thick that the camera sees in parts", noise=0.015)
def hair_huang():
    empty_studio()
    lamp("POINT", 200.0, (2.5, -3.0, 3.5), shadow_soft_size=0.2)
    ball(plain((0.3, 0.2, 0.15, 1.0)), (-0.7, 0.0, 0.9), 0.6)
    thin = grown(1000, 6, 0.6, 0.012, _huang(Color=(0.6, 0.3, 0.12, 1.0), Roughness=0.35, Offset=0.05))
    thin.location.x = -0.7
    _drawn_as("THICK")
    thick = grown(8, 5, 1.2, 0.16, _huang(Color=(0.8, 0.6, 0.3, 1.0), Roughness=0.4, Reflection=0.8), seed=3)
    thick.location.x = 1.3


@scene("Principled Hair by Huang, of an elliptical cross-section, thin and thick", noise=0.015)
def hair_huang_flat():
    """Cycles takes shadows of transparent hair from the middle of each strand, which is never beside the fibre: both have opaque shadows
    here."""
    empty_studio()
    lamp("POINT", 200.0, (2.5, -3.0, 3.5), shadow_soft_size=0.2)
    colours = {"Color": (0.7, 0.4, 0.15, 1.0), "Roughness": 0.4}
    thin, thick = _huang(0.6, **colours, Offset=0.05), _huang(0.5, **colours)
    thin.use_transparent_shadow = thick.use_transparent_shadow = False
    grown(60, 6, 0.6, 0.03, thin).location.x = -0.9
    _drawn_as("THICK")
    grown(8, 5, 1.2, 0.16, thick, seed=3).location.x = 1.1


@scene("Principled Hair by Huang on a mesh, by melanin and factors, under an even sky", noise=0.012)
def hair_huang_mesh():
    """Of a mesh Cycles' light samples go where its own directions do not, as with the Hair shader."""
    empty_studio(lit=False)
    ball(_huang(Roughness=0.3, Color=(0.7, 0.4, 0.2, 1.0)), (-1.3, 0.0, 0.8), 0.8)
    ball(_huang(Roughness=0.5, Transmission=0.4, Secondary_Reflection=1.5), (1.3, 0.0, 0.8), 0.8)


@scene("Ribbons: diffuse, under lamps", noise=0.012)
def hair_ribbons():
    empty_studio(strength=0.1)
    _drawn_as("RIBBONS", 3)
    grown(300, 5, 0.8, 0.03, material(lambda t: t.shows(t.diffuse(GOLD))), bend=1.0)


@scene("Thick curves: gloss, and one that is seen through")
def hair_thick():
    empty_studio()
    _drawn_as("THICK")
    grown(60, 5, 0.9, 0.06, plain(RED, Roughness=0.25), bend=0.8)
    seen_through = material(lambda t: t.shows(t.mix(0.5, t.node("BsdfTransparent").outputs[0], t.diffuse(BLUE))))
    put(grown(40, 5, 0.8, 0.05, seen_through, seed=2), (-1.9, 0.3, 0.5), scale=0.6)
    put(grown(40, 5, 0.8, 0.05, plain(CREAM), seed=3), (1.9, 0.3, 0.5), (20, 30, 0), 0.6)


@scene("Curves that are straight between their points")
def hair_straight():
    empty_studio()
    _drawn_as("THICK_LINEAR")
    grown(60, 4, 0.9, 0.06, plain(GREEN, Roughness=0.3), bend=1.5)


def haired(count: int, surface, location=(0.0, 0.0, 0.9), radius: float = 0.75, **settings):
    """A ball with hair of particles."""
    head = ball(plain((0.35, 0.25, 0.2, 1.0)), location, radius)
    head.data.materials.append(surface)
    head.modifiers.new("Hair", "PARTICLE_SYSTEM")
    system = head.particle_systems[0]
    made = system.settings
    made.type, made.count, made.hair_length, made.material = "HAIR", count, 0.6, 2
    made.render_step, made.radius_scale, made.root_radius = 3, 0.02, 1.0
    for name, value in settings.items():
        setattr(made, name, value)
    return head


# Seeds of either program differ by 2 % in one block with 600 samples, and Blender grows other children in each process.
@scene("Hair of particles with children", noise=0.02, times=4)
def hair_particles():
    empty_studio()
    haired(
        150,
        _principled_hair(Color=(0.7, 0.5, 0.25, 1.0), Roughness=0.4),
        child_type="INTERPOLATED",
        rendered_child_count=12,
        roughness_1=0.05,
        tip_radius=0.2,
        shape=0.3,
        brownian_factor=0.03,
    )


@scene("What Hair Info tells: intercept, length, thickness, random, tangent normal", noise=0.012)
def hair_info():
    empty_studio()

    def along(t: Tree) -> None:
        info = t.node("HairInfo")
        colour = t.node(
            "CombineColor", Red=info.outputs["Intercept"], Green=info.outputs["Random"], Blue=info.outputs["Is Strand"]
        ).outputs[0]
        t.shows(t.diffuse(colour))

    def size(t: Tree) -> None:
        info = t.node("HairInfo")
        thick = t.math("MULTIPLY", info.outputs["Thickness"], 20.0)
        facing = t.node(
            "VectorMath", {"operation": "DOT_PRODUCT"}, _0=info.outputs["Tangent Normal"], _1=(0.0, -1.0, 0.3)
        )
        colour = t.node("CombineColor", Red=info.outputs["Length"], Green=thick, Blue=facing.outputs["Value"]).outputs[
            0
        ]
        t.shows(t.diffuse(colour))

    def known(t: Tree) -> None:
        place = t.node("UVMap").outputs[0]
        wet = t.node("Attribute", {"attribute_name": "wet"}).outputs["Fac"]
        t.shows(t.diffuse(t.mixed_colour(wet, place, WHITE)))

    for i, build in enumerate((along, size, known)):
        put(grown(250, 6, 0.8, 0.03, material(build), seed=4 + i), (1.9 * i - 1.9, 0.0, 0.5), scale=0.6)


@scene("Hair shader on curves, under an even sky")
def hair_shader():
    """Where lamps light it, Cycles evaluates it where its own directions do not go; docs/design/closures.md."""
    empty_studio(lit=False, strength=1.0)
    kinds = (
        lambda t: t.node("BsdfHair", Color=GOLD, RoughnessU=0.4, RoughnessV=0.7),
        lambda t: t.node(
            "BsdfHair", {"component": "Transmission"}, Color=WHITE, RoughnessU=0.5, RoughnessV=0.5, Offset=0.1
        ),
    )
    for i, kind in enumerate(kinds):
        surface = material(lambda t, kind=kind: t.shows(kind(t).outputs[0]))
        put(grown(500, 5, 0.8, 0.02, surface, seed=8 + i), (2.0 * i - 1.0, 0.0, 0.6), scale=0.8)


@scene("Curves of geometry nodes: straight ones, and instances of hair")
def hair_nodes():
    """Both of hair curves objects: what nodes make of other objects, neither program draws unless it is made a mesh."""
    empty_studio()
    tuft = grown(120, 5, 0.8, 0.03, plain(GOLD, Roughness=0.4), seed=12)
    put(tuft, (0.0, 0.0, -5.0))
    for count, build in ((9, _planted), (1, _spiral)):
        data = bpy.data.hair_curves.new("Nodes")
        data.add_curves([2])
        holder = put(bpy.data.objects.new(f"Nodes {count}", data), (0.0, 0.0, 0.1))
        tree = bpy.data.node_groups.new("Nodes", "GeometryNodeTree")
        tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
        tree.links.new(build(tree, tuft), tree.nodes.new("NodeGroupOutput").inputs[0])
        holder.modifiers.new("Nodes", "NODES").node_group = tree


def _planted(tree, tuft):
    """Tufts on a grid, turned each its own way."""
    points = tree.nodes.new("GeometryNodeMeshGrid")
    points.inputs["Size X"].default_value = points.inputs["Size Y"].default_value = 2.8
    for name in ("Vertices X", "Vertices Y"):
        points.inputs[name].default_value = 3
    source = tree.nodes.new("GeometryNodeObjectInfo")
    source.inputs["Object"].default_value = tuft
    source.inputs["As Instance"].default_value = True
    place = tree.nodes.new("GeometryNodeInstanceOnPoints")
    place.inputs["Scale"].default_value = (0.35, 0.35, 0.35)
    tree.links.new(points.outputs[0], place.inputs["Points"])
    tree.links.new(source.outputs["Geometry"], place.inputs["Instance"])
    return place.outputs[0]


def _spiral(tree, _):
    spiral = tree.nodes.new("GeometryNodeCurveSpiral")
    spiral.inputs["Height"].default_value = 1.6
    thick = tree.nodes.new("GeometryNodeSetCurveRadius")
    thick.inputs["Radius"].default_value = 0.06
    shown = tree.nodes.new("GeometryNodeSetMaterial")
    shown.inputs["Material"].default_value = plain(RED)
    tree.links.new(spiral.outputs[0], thick.inputs["Curve"])
    tree.links.new(thick.outputs[0], shown.inputs["Geometry"])
    return shown.outputs[0]
