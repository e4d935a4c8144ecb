# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion blur: what moves, what turns, what changes its shape, and when the shutter is open."""

from __future__ import annotations

import math
from collections.abc import Callable

import bpy
import numpy as np

from . import hair, points, scene, volumes
from .studio import BLUE, CREAM, GOLD, GREEN, RED, ball, cube, empty_studio, lamp, material, monkey, plain, put

FRAME = 10


def _opened(shutter: float = 1.0) -> None:
    """The shutter, so many frames long, about the frame in which all is seen."""
    here = bpy.context.scene
    here.render.use_motion_blur, here.render.motion_blur_shutter = True, shutter
    here.frame_set(FRAME)


def animate(holder, path: str, value: Callable[[float], object]) -> None:
    """Gives a property `value(t)`, t frames after the one in which all is seen; between the keys it goes straight."""
    for t in range(-3, 4):
        setattr(holder, path, value(float(t)))
        holder.keyframe_insert(path, frame=FRAME + t)
    action = holder.id_data.animation_data.action
    for curve in _curves(action):
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"


def _curves(action: bpy.types.Action):
    if not hasattr(action, "layers"):
        return list(action.fcurves)
    strips = (strip for layer in action.layers for strip in layer.strips)
    return [curve for strip in strips for bag in strip.channelbags for curve in bag.fcurves]


@scene("A ball slides and throws a blurred shadow")
def slides():
    empty_studio()
    thing = ball(plain(RED), (0.0, 0.0, 0.8), 0.8)
    animate(thing, "location", lambda t: (1.6 * t, 0.3 * t, 0.8))
    cube(plain(BLUE), (1.6, 1.2, 0.6), 1.2)
    _opened()


@scene("Cubes spin: many keys and few")
def spins():
    empty_studio()
    for x, steps in ((-1.3, 3), (1.3, 1)):
        thing = cube(plain(CREAM), (x, 0.0, 0.9), 1.3, 0.0)
        thing.cycles.motion_steps = steps
        animate(thing, "rotation_euler", lambda t: (0.3, 0.0, 0.4 + 1.2 * t))
    _opened()


@scene("Growing, mirrored and sheared")
def scaled():
    empty_studio()
    grows = ball(plain(GREEN), (-1.4, 0.0, 0.8), 0.7)
    animate(grows, "scale", lambda t: (1.0 + 0.5 * t, 1.0, 1.0 - 0.4 * t))
    mirrored = monkey(plain(CREAM), (1.3, 0.0, 0.9), 1.4, levels=0)
    animate(mirrored, "location", lambda t: (1.3 + 0.5 * t, 0.0, 0.9))
    mirrored.scale.x = -1.0
    holder = put(bpy.data.objects.new("Holder", None), (0.0, -1.5, 0.4), scale=(1.0, 1.0, 0.4))
    animate(holder, "rotation_euler", lambda t: (0.0, 0.5 * t, 0.0))
    sheared = cube(plain(BLUE), (0.0, 0.0, 0.0), 0.8)
    sheared.parent = holder
    _opened()


@scene("Instances of a collection, and children of a parent that turns")
def instanced():
    empty_studio()
    part = ball(plain(GOLD), (0.4, 0.0, 0.0), 0.35)
    second = cube(plain(RED), (-0.4, 0.0, 0.1), 0.5)
    group = bpy.data.collections.new("Group")
    for one in (part, second):
        bpy.context.scene.collection.objects.unlink(one)
        group.objects.link(one)
    for number in range(3):
        placed = put(bpy.data.objects.new(f"Placed {number}", None), (1.6 * number - 1.6, 0.0, 0.6))
        placed.instance_type, placed.instance_collection = "COLLECTION", group
        animate(placed, "rotation_euler", lambda t, n=number: (0.0, 0.4 * n * t, 0.7 * t))
    holder = put(bpy.data.objects.new("Holder", None), (0.0, 1.0, 2.0))
    animate(holder, "rotation_euler", lambda t: (0.0, 0.6 * t, 0.0))
    child = cube(plain(BLUE), (1.5, 0.0, 0.0), 0.7)
    child.parent = holder
    _opened()


def _row() -> bpy.types.Object:
    empty_studio()
    monkey(plain(CREAM), (0.0, 0.0, 0.9), 1.7)
    ball(plain(RED), (-1.5, -1.5, 0.6), 0.6)
    cube(plain(BLUE), (1.6, 1.2, 0.6), 1.2)
    return bpy.context.scene.camera


@scene("The camera pans")
def camera_pans():
    camera = _row()
    turn = camera.rotation_euler.copy()
    animate(camera, "rotation_euler", lambda t: (turn.x, turn.y, 0.15 * t))
    _opened()


@scene("The camera walks forwards and rolls, a ball goes with it")
def camera_walks():
    camera = _row()
    place, turn = camera.location.copy(), camera.rotation_euler.copy()
    animate(camera, "location", lambda t: (place.x + 0.3 * t, place.y + 1.2 * t, place.z))
    animate(camera, "rotation_euler", lambda t: (turn.x, 0.1 * t, 0.0))
    thing = ball(plain(GREEN), (1.2, -2.2, 0.9), 0.4)
    animate(thing, "location", lambda t: (1.2 + 0.3 * t, -2.2 + 1.2 * t, 0.9))
    _opened()


@scene("Shape keys, smooth and flat")
def shape_keys():
    empty_studio()
    for x, make in ((-1.3, ball), (1.3, cube)):
        thing = make(plain(RED if x < 0 else BLUE), (x, 0.0, 0.9))
        thing.shape_key_add(name="Basis")
        bent = thing.shape_key_add(name="Bent")
        for point in bent.data:
            point.co.x += 0.9 * point.co.z * abs(point.co.z)
        bent.slider_min = -2.0
        animate(bent, "value", lambda t: 0.9 * t)
    _opened()


@scene("A skeleton bends a mesh that moves, too")
def armature():
    empty_studio()
    bpy.ops.object.armature_add(location=(0.0, 0.0, 0.2))
    holder = bpy.context.object
    bpy.ops.object.mode_set(mode="EDIT")
    first = holder.data.edit_bones[0]
    first.tail = (0.0, 0.0, 1.0)
    second = holder.data.edit_bones.new("Second")
    second.head, second.tail, second.parent = (0.0, 0.0, 1.0), (0.0, 0.0, 2.0), first
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.mesh.primitive_cylinder_add(vertices=32, radius=0.35, depth=2.0, location=(0.0, 0.0, 1.2))
    thing = bpy.context.object
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide(number_cuts=8)
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.object.shade_smooth()
    thing.data.materials.append(plain(GREEN))
    upper = [min(max((vertex.co.z + 0.4) / 0.8, 0.0), 1.0) for vertex in thing.data.vertices]
    for name, shares in (("Bone", [1.0 - share for share in upper]), ("Second", upper)):
        group = thing.vertex_groups.new(name=name)
        for number, share in enumerate(shares):
            group.add([number], share, "REPLACE")
    thing.modifiers.new("Armature", "ARMATURE").object = holder
    thing.cycles.motion_steps = 2
    bone = holder.pose.bones["Second"]
    bone.rotation_mode = "XYZ"
    animate(bone, "rotation_euler", lambda t: (0.0, 0.0, 1.2 * t))
    animate(thing, "location", lambda t: (0.4 * t, 0.0, 1.2))
    _opened()


@scene("The shutter opens at the frame, on a pan and a slide")
def shutter_start():
    slides()
    camera = bpy.context.scene.camera
    turn = camera.rotation_euler.copy()
    animate(camera, "rotation_euler", lambda t: (turn.x, turn.y, 0.1 * t))
    bpy.context.scene.render.motion_blur_position = "START"
    _opened(0.8)


@scene("The shutter closes at the frame")
def shutter_end():
    slides()
    bpy.context.scene.render.motion_blur_position = "END"
    _opened(0.8)


@scene("A shutter that opens slowly")
def shutter_curve():
    slides()
    curve = bpy.context.scene.render.motion_blur_shutter_curve
    points = curve.curves[0].points
    for point, place in zip(points, ((0.0, 0.0), (1.0, 1.0)), strict=False):
        point.location = place
    for point in list(points)[2:]:
        points.remove(point)
    curve.update()
    _opened()


@scene("A rolling shutter")
def rolling_shutter():
    camera = _row()
    turn = camera.rotation_euler.copy()
    animate(camera, "rotation_euler", lambda t: (turn.x, turn.y, 0.25 * t))
    cycles = bpy.context.scene.cycles
    cycles.rolling_shutter_type, cycles.rolling_shutter_duration = "TOP", 0.2
    _opened()


@scene("A lamp that moves stands still, as in Cycles", warns=("as in Cycles it stands still",))
def moving_lamp():
    empty_studio(strength=0.1)
    cube(plain(CREAM), (0.0, 0.0, 0.75))
    thing = lamp("POINT", 80.0, (1.5, -1.0, 1.2), shadow_soft_size=0.2)
    animate(thing, "location", lambda t: (1.5 + 2.0 * t, -1.0, 1.2))
    _opened()


@scene(
    "What glows moves and grows",
    tolerance=0.015,
    why="Cycles' shutter is a little early, docs/design/motion.md",
    noise=0.015,
)
def moving_glow():
    empty_studio(strength=0.05, lit=False)
    cube(plain(CREAM), (0.6, 0.4, 0.75))
    glow = material(lambda t: t.shows(t.node("Emission", Color=GOLD, Strength=20.0).outputs[0]))
    thing = cube(glow, (-1.2, -1.0, 0.9), 0.5)
    animate(thing, "location", lambda t: (-1.2 + 1.6 * t, -1.0, 0.9))
    animate(thing, "scale", lambda t: (1.0 + 0.5 * t, 1.0, 1.0))
    _opened()


@scene("Blur switched off for one, and for the shape of another")
def switched_off():
    empty_studio()
    still = ball(plain(RED), (-1.3, 0.0, 0.7), 0.7)
    still.cycles.use_motion_blur = False
    animate(still, "location", lambda t: (-1.3 + t, 0.0, 0.7))
    stiff = ball(plain(BLUE), (1.3, 0.0, 0.7), 0.7)
    stiff.cycles.use_deform_motion = False
    stiff.shape_key_add(name="Basis")
    bent = stiff.shape_key_add(name="Bent")
    for point in bent.data:
        point.co.x += 0.8 * math.copysign(np.sqrt(abs(point.co.z)), point.co.z)
    bent.slider_min = -2.0
    animate(bent, "value", lambda t: 0.9 * t)
    animate(stiff, "location", lambda t: (1.3, 0.0, 0.7 + 0.3 * t))
    _opened()


@scene("Hair goes with what it grows on, thick and as ribbons")
def hair_goes_along():
    empty_studio()
    bpy.context.scene.cycles_curves.shape = "RIBBONS"
    tuft = hair.grown(300, 5, 0.8, 0.03, material(lambda t: t.shows(t.diffuse(GOLD))), bend=0.8)
    animate(tuft, "location", lambda t: (0.8 * t, 0.0, 0.9))
    animate(tuft, "rotation_euler", lambda t: (0.0, 0.5 * t, 0.3))
    _opened()


def _sways(holder) -> None:
    """Each point of a holder goes sideways, as far as it is high, by nodes that ask for the time."""
    group = bpy.data.node_groups.new("Sway", "GeometryNodeTree")
    group.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    new, link = group.nodes.new, group.links.new
    start, end, sway = new("NodeGroupInput"), new("NodeGroupOutput"), new("GeometryNodeSetPosition")
    gone, far = new("ShaderNodeMath"), new("ShaderNodeMath")
    gone.operation, far.operation = "SUBTRACT", "MULTIPLY"
    link(new("GeometryNodeInputSceneTime").outputs["Frame"], gone.inputs[0])
    gone.inputs[1].default_value = FRAME
    place, aside = new("ShaderNodeSeparateXYZ"), new("ShaderNodeCombineXYZ")
    link(new("GeometryNodeInputPosition").outputs[0], place.inputs[0])
    link(gone.outputs[0], far.inputs[0])
    link(place.outputs["Z"], far.inputs[1])
    link(far.outputs[0], aside.inputs["X"])
    link(start.outputs[0], sway.inputs["Geometry"])
    link(aside.outputs[0], sway.inputs["Offset"])
    link(sway.outputs[0], end.inputs[0])
    holder.modifiers.new("Sway", "NODES").node_group = group


@scene("Ribbons that sway, and particles' hair on a ball that swells")
def hair_sways():
    """Both change their shape; the tuft slides, too, and is read at nine times."""
    empty_studio()
    bpy.context.scene.cycles_curves.shape = "RIBBONS"
    tuft = hair.grown(300, 5, 0.8, 0.03, material(lambda t: t.shows(t.diffuse(GOLD))), bend=0.8)
    animate(tuft, "location", lambda t: (-1.2, 0.3 * t, 0.9))
    tuft.cycles.motion_steps = 3
    _sways(tuft)
    head = hair.haired(200, plain(BLUE), (1.3, 0.0, 0.9), 0.6, tip_radius=0.3)
    head.shape_key_add(name="Basis")
    swollen = head.shape_key_add(name="Swollen")
    for one, own in zip(swollen.data, head.data.vertices, strict=True):
        one.co = 1.5 * own.co
    animate(swollen, "value", lambda t: 0.5 + 0.5 * t)
    _opened()


@scene("Round hair that sways")
def hair_sways_round():
    empty_studio()
    bpy.context.scene.cycles_curves.shape = "THICK"
    tuft = hair.grown(60, 5, 0.8, 0.06, material(lambda t: t.shows(t.diffuse(RED))), bend=0.8)
    tuft.cycles.motion_steps = 2
    _sways(tuft)
    _opened()


@scene("Fog in a box that slides, glass, and a bump in the object's own coordinates", noise=0.015)
def fog_and_glass():
    empty_studio()
    fog = volumes.filled(lambda t: t.node("VolumeScatter", Density=1.5, Color=CREAM).outputs[0])
    box = cube(fog, (-1.2, 0.0, 0.8), 1.3, 0.0)
    animate(box, "location", lambda t: (-1.2 + 0.8 * t, 0.0, 0.8))
    clear = ball(
        material(lambda t: t.shows(t.principled(Roughness=0.0, Transmission_Weight=1.0))), (0.9, -1.6, 0.5), 0.5
    )
    animate(clear, "location", lambda t: (0.9, -1.6, 0.5 + 0.4 * t))

    def rough(t):
        place = t.node("TexCoord").outputs["Object"]
        height = t.node("TexNoise", Vector=place, Scale=6.0).outputs[0]
        t.shows(t.diffuse(RED, Normal=t.node("Bump", Height=height, Strength=0.6).outputs[0]))

    thing = ball(material(rough), (1.5, 0.6, 0.8), 0.8)
    animate(thing, "rotation_euler", lambda t: (0.0, 0.0, 0.8 * t))
    _opened()


@scene("Points that slide, points that turn, points that part and grow")
def points_move():
    """The last by what their nodes make of shape keys: Cycles blurs places and radii."""
    empty_studio()
    slides = points.cloud(12, 0.3, plain(GOLD), (-1.6, 0.0, 0.8), 0.6)
    animate(slides, "location", lambda t: (-1.6 + 0.5 * t, 0.0, 0.8 + 0.2 * t))
    turns = points.cloud(12, 0.3, plain(BLUE), (0.1, 0.0, 0.8), 0.6, seed=2)
    animate(turns, "rotation_euler", lambda t: (0.0, 0.9 * t, 0.3 * t))
    parts = points.cloud(12, 0.3, plain(RED), (1.7, 0.0, 0.8), 0.6, seed=3)
    parts.shape_key_add(name="Basis")
    apart = parts.shape_key_add(name="Apart")
    for one, own in zip(apart.data, parts.data.vertices, strict=True):
        one.co = 1.6 * own.co
    animate(apart, "value", lambda t: 0.4 + 0.3 * t)
    _opened()


@scene("Points and a mesh that go as their velocity says")
def flies():
    """As simulations leave them: no frame beside tells."""
    empty_studio()
    flown = points.cloud(14, 0.3, plain(GOLD), (-1.1, 0.0, 0.8), 0.7)
    thing = monkey(plain(CREAM), (1.2, 0.0, 0.8), 1.4, levels=0)
    fps = bpy.context.scene.render.fps
    for one in (flown, thing):
        places = np.array([vertex.co for vertex in one.data.vertices])
        way = 0.4 * places[:, (2, 1, 0)] + (0.4, 0.0, 0.2)
        own = one.data.attributes.new("velocity", "FLOAT_VECTOR", "POINT")
        own.data.foreach_set("vector", (fps * way).astype(np.float32).ravel())
    _opened()
