# SPDX-License-Identifier: GPL-3.0-or-later
"""What moves while the shutter is open: a blurred picture is the mean of sharp ones, by every camera and integrator; what is
left out is said; where nothing moves nothing changes. tests/parity/test_parity_scenes.py holds it beside Cycles."""

from __future__ import annotations

import math

import numpy as np
import pytest

from support.multilayer import mattes, photograph

FRAME = 10


def matte(parts, colour):
    made, tree, surface = parts.material("Matte")
    node = tree.nodes.new("ShaderNodeBsdfDiffuse")
    node.inputs["Color"].default_value = (*colour, 1.0)
    tree.links.new(node.outputs[0], surface)
    return made


def animate(holder, path: str, value) -> None:
    """Gives a property `value(t)` from a frame before, t = -1, to a frame after, straight in between."""
    for t in (-2, -1, 0, 1, 2):
        setattr(holder, path, value(float(t)))
        holder.keyframe_insert(path, frame=FRAME + t)
    action = holder.id_data.animation_data.action
    if hasattr(action, "layers"):
        bags = [bag for layer in action.layers for strip in layer.strips for bag in strip.channelbags]
    else:
        bags = [action]
    for point in (point for bag in bags for curve in bag.fcurves for point in curve.keyframe_points):
        point.interpolation = "LINEAR"


def stage(parts, model: str = "PINHOLE", size: int = 32):
    """A card that glows slides before a wall that it lights, and one swings."""
    scene = parts.set_up(width=size, height=size, model=model)
    scene.world = parts.grey_world(0.2)
    wall = parts.square("Wall", (0.0, 6.0, 0.0), 6.0, matte(parts, (0.6, 0.6, 0.6)))
    slides = parts.square("Slides", (0.0, 4.0, 0.3), 0.8, parts.emitter(strength=3.0))
    animate(slides, "location", lambda t: (1.2 * t, 4.0, 0.3))
    swings = parts.square("Swings", (0.0, 4.5, -0.8), 1.2, matte(parts, (0.8, 0.2, 0.1)))
    animate(swings, "rotation_euler", lambda t: (0.0, 0.8 * t, 0.0))
    scene.frame_set(FRAME)
    return scene, wall, slides, swings


def opened(scene, shutter: float = 1.0) -> None:
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, shutter


def warnings(parts, scene) -> list[str]:
    return parts.part("render.statistics").last(scene.name).warnings


def decision(parts, scene) -> dict:
    plan = parts.part("render.statistics").last(scene.name).stats["plan"]
    return next(row for row in plan if row["effect"] == "motion_blur")


def blocks(picture: np.ndarray, side: int) -> np.ndarray:
    height, width = picture.shape[:2]
    return picture.reshape(height // side, side, width // side, side, -1).mean((1, 3))


def colour(channels: dict) -> np.ndarray:
    return np.stack([channels[f"combined.{c}"] for c in "rgb"], axis=-1)


def assert_mean_of_sharp_ones(parts, scene, tmp_path, blurred: dict) -> None:
    """A picture of the whole shutter is the mean of pictures without motion blur while it is open."""
    scene.render.use_motion_blur = False
    count = 24
    mean = 0.0
    for i in range(count):
        part = (i + 0.5) / count - 0.5
        scene.frame_set(FRAME + math.floor(part), subframe=part - math.floor(part))
        scene.petzval.seed = i
        sharp, _ = photograph(parts, scene, tmp_path / "sharp.exr", samples=16)
        mean = mean + colour(sharp) / count
    ours, truth = (blocks(picture, 8) for picture in (colour(blurred), mean))
    # Edges go 1/24 of their way between two of the sharp ones; noise is as much again.
    assert np.abs(ours - truth).max() < 0.03 * truth.max()
    assert abs(ours.mean() / truth.mean() - 1.0) < 0.01


LENS = "double-gauss-f2-tronnier.lens"


@pytest.mark.parametrize(
    ("model", "pipeline", "integrator"),
    [
        ("PINHOLE", "AUTO", "PATH"),
        # By which camera and which way light is followed is nothing that a version of Blender changes.
        pytest.param("THIN", "AUTO", "PATH", marks=pytest.mark.once),
        pytest.param("LENS", "FILM", "PATH", marks=pytest.mark.once),
        pytest.param("LENS", "HERO", "PATH", marks=pytest.mark.once),
        pytest.param("LENS", "SCENE", "PATH", marks=pytest.mark.once),
        pytest.param("LENS", "HERO", "BIDIRECTIONAL", marks=pytest.mark.once),
    ],
)
def test_a_blurred_picture_is_the_mean_of_sharp_ones(parts, blender, tmp_path, model, pipeline, integrator):
    scene, *_ = stage(parts, model)
    scene.petzval.pipeline, scene.petzval.integrator = pipeline, integrator
    if model == "LENS":
        own = scene.camera.data.petzval
        own.lens_file, own.film_mode, own.film_width, own.film_height = LENS, "SIZE", 36.0, 36.0
        own.focal_mode, own.focal_length = "LENGTH", 50.0
    scene.camera.data.dof.focus_distance = 4.0
    camera = scene.camera
    animate(camera, "location", lambda t: (0.3 * t, 0.4 * t, 0.0))
    animate(camera, "rotation_euler", lambda t: (math.pi / 2, 0.2 * t, 0.1 * t))
    for holder in (camera, *scene.objects):
        holder.cycles.motion_steps = 2
    scene.frame_set(FRAME)
    opened(scene)
    blurred, _ = photograph(parts, scene, tmp_path / "blurred.exr", samples=256)
    assert not warnings(parts, scene)
    assert decision(parts, scene)["decision"] == "on"
    assert scene.frame_current == FRAME and scene.frame_subframe == 0.0
    assert_mean_of_sharp_ones(parts, scene, tmp_path, blurred)


def test_where_nothing_moves_nothing_changes(parts, blender, tmp_path):
    """Not a bit, and no sample has a time."""
    scene, *_ = stage(parts)
    for holder in scene.objects:
        holder.animation_data_clear()
    still, _ = photograph(parts, scene, tmp_path / "still.exr", samples=8)
    opened(scene)
    same, _ = photograph(parts, scene, tmp_path / "same.exr", samples=8)
    assert (colour(still) == colour(same)).all()
    assert decision(parts, scene)["decision"] == "off"


def test_the_plan_measures_what_moves(parts, blender, tmp_path):
    """A slide of a card at depth 4 over so many pixels; below the tolerance, or taken out, the picture is a sharp one."""
    scene, _, slides, swings = stage(parts)
    swings.animation_data_clear()
    focal_px = scene.render.resolution_x * 50 / 36
    opened(scene, 0.5)
    photograph(parts, scene, tmp_path / "much.exr", samples=1)
    row = decision(parts, scene)
    # Its corners lie a little nearer or farther than its middle.
    assert row["decision"] == "on" and row["measure"] == pytest.approx(0.6 / 4.0 * focal_px, rel=0.1)
    assert "Slides" in row["why"]
    scene.render.use_motion_blur = False
    sharp, _ = photograph(parts, scene, tmp_path / "sharp.exr", samples=4)
    opened(scene, 0.5)
    scene.petzval.effects.motion_blur = "OFF"
    left_out, _ = photograph(parts, scene, tmp_path / "off.exr", samples=4)
    assert (colour(sharp) == colour(left_out)).all()
    scene.petzval.effects.motion_blur = "AUTO"
    opened(scene, 0.02)
    little, _ = photograph(parts, scene, tmp_path / "little.exr", samples=64)
    assert decision(parts, scene)["decision"] == "off"
    scene.petzval.effects.motion_blur = "ON"
    photograph(parts, scene, tmp_path / "on.exr", samples=1)
    assert decision(parts, scene)["decision"] == "on"


def test_what_is_left_out_is_said(parts, blender, tmp_path):
    scene, _, _, swings = stage(parts)
    grows = parts.square("Grows", (1.0, 4.0, 1.0), 0.5, matte(parts, (0.5, 0.5, 0.5)))
    array = grows.modifiers.new("Array", "ARRAY")
    animate(array, "count", lambda t: int(4 + t))
    light = blender.data.objects.new("Lamp", blender.data.lights.new("Lamp", "POINT"))
    scene.collection.objects.link(light)
    animate(light, "location", lambda t: (t, 3.0, 2.0))
    scene.frame_set(FRAME)
    opened(scene, 2.0)
    photograph(parts, scene, tmp_path / "said.exr", samples=1)
    told = warnings(parts, scene)
    assert len(told) == 2, told
    assert any("'Grows'" in line and "other vertices" in line for line in told)
    assert any("'Lamp'" in line and "stands still" in line for line in told)


def test_mattes_know_what_moves(parts, blender, tmp_path):
    """The coverage of what slides is that of its blurred picture, as in Cycles."""
    scene, *_ = stage(parts)
    scene.view_layers[0].use_pass_cryptomatte_object = True
    opened(scene)
    covered = {}
    for engine in ("PETZVAL", "CYCLES"):
        channels, metadata = photograph(parts, scene, tmp_path / f"{engine}.exr", engine, samples=256)
        covered[engine] = mattes(channels, "Object")
    assert covered["PETZVAL"].keys() == covered["CYCLES"].keys()
    for which, ours in covered["PETZVAL"].items():
        # A pixel that is half covered by 256 samples: 0.03 each.
        assert np.abs(blocks(ours[..., None], 4) - blocks(covered["CYCLES"][which][..., None], 4)).max() < 0.05


def test_frames_of_an_animation(parts, blender, tmp_path):
    """With what Blender keeps of the frame before, the next one is the same."""
    scene, *_ = stage(parts)
    opened(scene)
    scene.frame_set(FRAME + 1)
    alone, _ = photograph(parts, scene, tmp_path / "alone.exr", samples=4)
    scene.render.use_persistent_data = True
    scene.frame_set(FRAME)
    photograph(parts, scene, tmp_path / "before.exr", samples=1)
    scene.frame_set(FRAME + 1)
    after, _ = photograph(parts, scene, tmp_path / "after.exr", samples=4)
    assert np.allclose(colour(alone), colour(after), atol=1e-6)


@pytest.mark.once
def test_a_checkpoint_is_of_one_motion(parts, blender, tmp_path):
    """A render that moves otherwise does not take up what another has left."""
    scene, _, slides, _ = stage(parts)
    watch = parts.part("render.loop").WATCH
    opened(scene)
    # Kept at the end, for one that asks for it by name.
    watch.checkpoint, watch.checkpoint_every_s = str(tmp_path / "kept"), 0.0
    try:
        resumed = []
        for shutter in (1.0, 1.0, 0.7):
            scene.render.motion_blur_shutter = shutter
            photograph(parts, scene, tmp_path / "kept.exr", samples=4)
            kept = parts.part("render.statistics").last(scene.name).stats["checkpoint"]
            resumed.append(kept["resumed_samples"])
    finally:
        watch.checkpoint = watch.checkpoint_every_s = None
    assert resumed[0] == 0 and resumed[1] > 0 and resumed[2] == 0


def sways(tree) -> None:
    """A modifier's nodes: each point goes sideways with time, as far as it is high."""
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")

    def math_node(operation, *values):
        node = tree.nodes.new("ShaderNodeMath")
        node.operation = operation
        for socket, value in zip(node.inputs, values, strict=False):
            if isinstance(value, float):
                socket.default_value = value
            else:
                tree.links.new(value, socket)
        return node.outputs[0]

    start, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    frame = tree.nodes.new("GeometryNodeInputSceneTime").outputs["Frame"]
    place = tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(tree.nodes.new("GeometryNodeInputPosition").outputs[0], place.inputs[0])
    gone = math_node("MULTIPLY", math_node("SUBTRACT", frame, float(FRAME)), 0.8)
    aside = tree.nodes.new("ShaderNodeCombineXYZ")
    tree.links.new(math_node("MULTIPLY", gone, place.outputs["Z"]), aside.inputs["X"])
    sway = tree.nodes.new("GeometryNodeSetPosition")
    tree.links.new(start.outputs[0], sway.inputs["Geometry"])
    tree.links.new(aside.outputs[0], sway.inputs["Offset"])
    tree.links.new(sway.outputs[0], end.inputs[0])


@pytest.mark.parametrize("shape", ["RIBBONS", "THICK"])
def test_hair_that_changes_its_shape(parts, blender, tmp_path, shape):
    """Curves that nodes bend, and particles' hair on a mesh that a shape key spreads."""
    scene, *_ = stage(parts)
    scene.cycles_curves.shape = shape
    data = blender.data.hair_curves.new("Hair")
    data.add_curves([4] * 5)
    strands = [[(0.3 * k, 0.0, 0.4 * i) for i in range(4)] for k in range(5)]
    data.attributes["position"].data.foreach_set("vector", np.ravel(strands))
    width = data.attributes.new("radius", "FLOAT", "POINT")
    width.data.foreach_set("value", [0.1] * 20)
    data.materials.append(parts.emitter(strength=2.0))
    holder = blender.data.objects.new("Hair", data)
    holder.location = (-1.4, 3.0, -1.0)
    scene.collection.objects.link(holder)
    group = blender.data.node_groups.new("Sway", "GeometryNodeTree")
    sways(group)
    holder.modifiers.new("Sway", "NODES").node_group = group
    head = parts.square("Head", (0.6, 3.0, 0.5), 0.6, matte(parts, (0.1, 0.5, 0.2)))
    head.shape_key_add(name="Basis")
    spread = head.shape_key_add(name="Spread")
    for one, own in zip(spread.data, head.data.vertices, strict=True):
        one.co = 2.0 * own.co
    animate(spread, "value", lambda t: 0.4 + 0.4 * t)
    head.modifiers.new("Hair", "PARTICLE_SYSTEM")
    grown = head.particle_systems[0].settings
    grown.type, grown.count, grown.hair_length, grown.radius_scale, grown.root_radius = "HAIR", 12, 0.8, 0.1, 1.0
    for one in (holder, head):
        one.cycles.motion_steps = 3
    scene.frame_set(FRAME)
    opened(scene)
    blurred, _ = photograph(parts, scene, tmp_path / "blurred.exr", samples=256)
    assert not warnings(parts, scene)
    assert_mean_of_sharp_ones(parts, scene, tmp_path, blurred)


def test_hair_that_turns_keeps_its_shape(parts, blender):
    """Blender tells the keys of particles' hair in world coordinates; what these round is no change of shape."""
    scene, _, slides, _ = stage(parts)
    slides.modifiers.new("Hair", "PARTICLE_SYSTEM")
    slides.particle_systems[0].settings.type = "HAIR"
    animate(slides, "location", lambda t: (1.2 * t, 400.0, 0.3))
    animate(slides, "rotation_euler", lambda t: (0.0, 0.8 * t, 0.3))
    shutter = parts.part("export.shutter")
    blur = shutter.Blur(None, 1.0)

    def look(_number: int) -> None:
        blur.read(blender.context.evaluated_depsgraph_get())

    shutter.sweep(shutter.Shutter(FRAME - 0.5, 1.0), 3, lambda frame, part: scene.frame_set(frame, subframe=part), look)
    first, *others = (shape for standing in blur._keys for shape in standing["Slides",].hair.values())
    assert len(others) == 2 and all(one is first for one in others)
