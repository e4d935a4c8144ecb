# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of the film, of worlds, materials and images that Cycles keeps, against Cycles in the same Blender: each shows, and the same."""

from __future__ import annotations

import numpy as np
import pytest

from support.ball_in_sky import SAMPLES, SIDE
from support.node_tree import Tree

BLOCK = 6


@pytest.fixture
def ball(blender):
    """A ball of a material that `paint` makes, in a sky of many colours."""
    from support import ball_in_sky

    ball_in_sky.set_up(blender)
    return blender.context.object


def paint(holder, build) -> None:
    """Gives an object a material whose surface `build` makes of a tree."""
    from support import scenes

    made, tree, surface = scenes.material()
    t = Tree(tree, surface)
    t.shows(build(t))
    holder.data.materials.clear()
    holder.data.materials.append(made)


def taken(folder, engine: str, samples: int = SAMPLES) -> np.ndarray:
    """The picture with its alpha, in blocks."""
    import bpy

    from support import beside_cycles, scenes

    beside_cycles.prepare(samples)
    scene = bpy.context.scene
    scene.render.engine = engine
    picture = scenes.render(folder, f"{engine.lower()}.exr")
    scene.render.engine = "PETZVAL"
    return picture.reshape(SIDE // BLOCK, BLOCK, SIDE // BLOCK, BLOCK, 4).mean((1, 3))


def shows_alike(folder, change, least: float, most: float, samples: int = SAMPLES) -> None:
    """What `change` sets shows in Cycles by more than `least` somewhere, and Petzval has the same within `most`."""
    before = taken(folder, "CYCLES", samples)
    change()
    ours, theirs = taken(folder, "PETZVAL", samples), taken(folder, "CYCLES", samples)
    shows, apart = np.abs(theirs - before).max(), np.abs(ours - theirs).max()
    assert shows > least, shows
    assert apart < most, (apart, shows)


# Film --------------------------------------------------------------------------------------------------------------


def glass(roughness: float):
    """Of a colour, so that alpha has to know what gets through."""
    return lambda t: t.node("BsdfGlass", Color=(0.9, 0.7, 0.4, 1.0), Roughness=roughness, IOR=1.2).outputs[0]


@pytest.mark.parametrize(("roughness", "threshold"), [(0.0, 0.1), (0.2, 0.3), (0.3, 0.2)])
def test_a_transparent_film_is_seen_through_glass(ball, blender, tmp_path, roughness, threshold):
    """As far as it is no rougher than that, and where nothing stands behind it."""
    scene, cycles = blender.context.scene, blender.context.scene.cycles
    paint(ball, glass(roughness))
    blender.ops.mesh.primitive_cube_add(size=1.0, location=(1.0, 3.0, 0.0))
    scene.render.film_transparent = True
    if roughness > threshold:
        cycles.film_transparent_glass, cycles.film_transparent_roughness = True, threshold
        assert np.abs(taken(tmp_path, "PETZVAL") - taken(tmp_path, "CYCLES")).max() < 0.02
        return

    def change():
        cycles.film_transparent_glass, cycles.film_transparent_roughness = True, threshold

    shows_alike(tmp_path, change, least=0.4, most=0.02)


# Worlds ------------------------------------------------------------------------------------------------------------


@pytest.fixture
def room(blender, parts):
    """A corner whose sky has nearly all its light in one patch: light samples find it, and hardly any path."""
    scene = parts.set_up(SIDE, SIDE, SAMPLES)
    y, x = np.mgrid[0:64, 0:128]
    pixels = np.full((64, 128, 4), 0.02, np.float32)
    pixels[..., :3] += 400.0 * np.exp(-0.5 * ((x - 76.0) ** 2 + (y - 46.0) ** 2))[..., None] * np.array([1.0, 0.9, 0.7])
    scene.world = parts.grey_world(1.0)
    tree = scene.world.node_tree
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = parts.image("sky", pixels, is_float=True, space="Non-Color")
    background = next(node for node in tree.nodes if node.type == "BACKGROUND")
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    parts.square("Wall", (0.0, 6.0, 0.0), 6.0)
    parts.square("Floor", (0.0, 3.0, -1.5), 6.0).rotation_euler.x = np.pi / 2
    blender.ops.mesh.primitive_cube_add(size=1.4, location=(0.3, 3.6, -0.8))
    return scene


@pytest.mark.parametrize("bounces", [0, 1])
def test_a_sky_lights_so_many_bounces(room, blender, tmp_path, bounces):
    # Cycles before 5 finds the patch with more noise: without a limit pictures are 0.07 apart, too.
    most = 0.02 if blender.app.version >= (5, 0, 0) else 0.06
    shows_alike(tmp_path, lambda: setattr(room.world.cycles, "max_bounces", bounces), least=2.0 * most, most=most)


def test_a_sky_without_shadows(room, tmp_path):
    if not hasattr(room.world.cycles, "use_shadows"):
        pytest.skip("of 5.2 on")
    shows_alike(tmp_path, lambda: setattr(room.world.cycles, "use_shadows", False), least=0.3, most=0.02)


def test_a_sky_that_is_not_sampled_lights_all(room, parts, tmp_path):
    """In Cycles its limits are of its light samples."""
    room.world.cycles.sampling_method, room.world.cycles.max_bounces = "NONE", 0
    described = parts.part("export.world").describe(
        room.world, nothing_of_images(parts), parts.part("export.aovs").Aovs(room.view_layers[0])
    )
    assert described.max_bounces == 1024


def nothing_of_images(parts):
    """Images that nothing is asked of but numbers."""

    class Numbers:
        def of_node(self, *_):
            return 0

    return Numbers()


# Materials ---------------------------------------------------------------------------------------------------------


def bumped(kind: str, **inputs):
    def build(t):
        noise = t.node("TexNoise", Vector=t.coordinates("Object"), Scale=4.0)
        bump = t.node("Bump", Height=noise.outputs[0], Distance=0.6)
        return t.node(kind, Normal=bump.outputs[0], **inputs).outputs[0]

    return build


@pytest.mark.parametrize(
    ("kind", "inputs"),
    [
        ("BsdfDiffuse", {}),
        ("BsdfAnisotropic", {"Roughness": 0.3}),
        ("BsdfPrincipled", {"Roughness": 0.4, "Coat_Weight": 0.5}),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_bumps_without_correction(ball, blender, tmp_path, kind, inputs):
    paint(ball, bumped(kind, **inputs))
    material = ball.active_material
    shows_alike(tmp_path, lambda: setattr(material.cycles, "use_bump_map_correction", False), least=0.05, most=0.02)


def test_a_smooth_surface_without_correction(ball, blender, tmp_path):
    """Normals that are interpolated over large triangles reflect into the surface, too: the quick form of a material knows of none."""
    blender.ops.mesh.primitive_uv_sphere_add(segments=7, ring_count=5, radius=1.0)
    blender.ops.object.shade_smooth()
    blender.data.objects.remove(ball)
    coarse = blender.context.object

    paint(coarse, lambda t: t.node("BsdfPrincipled", Roughness=0.15, Metallic=1.0).outputs[0])
    material = coarse.active_material
    shows_alike(tmp_path, lambda: setattr(material.cycles, "use_bump_map_correction", False), least=0.1, most=0.02)


# Images ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [(256, 256), (160, 100), (257, 131)], ids=str)
@pytest.mark.parametrize(
    ("name", "value"),
    [("texture_limit_render", "128"), ("texture_resolution_render", 0.7), ("texture_resolution_render", 0.1)],
)
@pytest.mark.parametrize("space", ["Non-Color", "sRGB"])
def test_images_are_halved_until_they_are_small_enough(blender, parts, tmp_path, name, value, size, space):
    """Pixel by pixel, as a surface shows them without interpolation."""
    scene = parts.set_up(61, 53, 4)
    cycles = scene.cycles
    if not hasattr(cycles, name):
        pytest.skip("this Cycles has no such setting")
    width, height = size
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = np.random.default_rng(3).random((height, width, 3))
    made, tree, surface = parts.material()
    t = Tree(tree, surface)
    texture = t.node("TexImage", {"interpolation": "Closest"}, Vector=t.coordinates("Window"))
    texture.image = parts.image("noise", pixels, space=space)
    t.shows(t.node("Emission", Color=texture.outputs["Color"]).outputs[0])
    parts.square("Square", (0.0, 4.0, 0.0), 20.0, made)
    cycles.device, cycles.samples, cycles.use_adaptive_sampling = "CPU", 1, False
    cycles.pixel_filter_type, cycles.filter_width = "BLACKMAN_HARRIS", 0.01
    scene.petzval.samples = 1
    scene.render.use_simplify = True

    def picture(engine: str) -> np.ndarray:
        scene.render.engine = engine
        return parts.render(tmp_path, f"{engine}.exr")

    before = picture("PETZVAL")
    setattr(cycles, name, value)
    ours, theirs = picture("PETZVAL"), picture("CYCLES")
    # Steps of eight bits, rounded once more at each halving; but for a row and a column whose middle falls between two pixels of the image.
    off = np.abs(ours - theirs)
    assert (off > 0.02).mean() < 0.02 and off[off < 0.02].mean() < 0.003
    assert np.abs(ours - before).mean() > 0.1
    scene.render.use_simplify = False
    assert np.array_equal(picture("PETZVAL"), before)


# Lamps -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["POINT", "SPOT"])
def test_a_lamp_that_holds_what_it_lights(blender, parts, tmp_path, kind):
    """Without soft falloff it is a sphere, which shines inwards, too; a spot then to all sides."""
    scene = parts.set_up(SIDE, SIDE, SAMPLES)
    scene.world = parts.grey_world(0.02)
    parts.square("Wall", (0.0, 6.0, 0.0), 6.0)
    blender.ops.mesh.primitive_cube_add(size=1.4, location=(0.3, 4.0, -0.3), rotation=(0.3, 0.2, 0.5))
    lamp = blender.data.objects.new("Lamp", blender.data.lights.new("Lamp", kind))
    lamp.location, lamp.data.shadow_soft_size, lamp.data.energy = (-0.8, 3.2, 0.8), 2.0, 300.0
    lamp.rotation_euler = (0.4, -0.6, 0.0)
    lamp.data.use_soft_falloff = True
    scene.collection.objects.link(lamp)
    # What a spot shows away from its middle is in Cycles the weight of its light samples beside a ray's: a half but for grazing light.
    most = 0.02 if kind == "POINT" else 0.06
    if blender.app.version < (5, 0, 0):
        # Blocks of Cycles 4.5's own picture are 0.043 from those of Cycles 5.2, and Petzval's 0.003 from the latter: measured with the point lamp.
        most = 0.06
    shows_alike(tmp_path, lambda: setattr(lamp.data, "use_soft_falloff", False), least=0.5, most=most)
