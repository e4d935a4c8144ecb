# SPDX-License-Identifier: GPL-3.0-or-later
"""What Cycles gives up of indirect light for less noise or time, against Cycles in the same Blender."""

from __future__ import annotations

import numpy as np
import pytest

from support.ball_row import add_panel
from support.shaders import (
    GOLD,
    RED,
    WHITE,
    diffuse,
    glass,
    glossy,
    metal,
    mix,
    node,
    principled,
    refraction,
)

SIDE, SAMPLES = 32, 1024
#: Pixels of a block's side.
BLOCK = 8


@pytest.fixture
def stage(blender):
    """A white matte wall before the camera. `parts.mirror(build, light)` adds a square behind the camera, whose material `build`
    makes, and a light that reaches the wall by way of that square alone: a lamp "above" by reflection, or what glows "behind" it."""
    from support import scenes as parts

    scene = parts.set_up(SIDE, SIDE, SAMPLES)
    scene.world = parts.grey_world(0.0)
    scene.camera.data.lens = 40
    parts.wall = parts.square("Wall", (0.0, 3.0, 0.0), 3.0, made(parts, lambda tree: diffuse(tree, WHITE)))

    def mirror(build, light: str) -> None:
        parts.square("Mirror", (0.0, -2.0, 0.0), 8.0, made(parts, build))
        if light == "behind":
            glow = parts.emitter(strength=5.0)
            # Cycles's light samples are too bright behind rough refraction: docs/design/closures.md.
            glow.cycles.emission_sampling = "NONE"
            parts.square("Glow", (0.0, -4.0, 0.0), 4.0, glow)
            return
        lamp = blender.data.objects.new("Lamp", blender.data.lights.new("Lamp", "AREA"))
        lamp.data.energy, lamp.data.size, lamp.location = 300.0, 1.0, (0.0, 4.5, 3.0)
        # At the middle of the square: an area lamp shines along its -z.
        lamp.rotation_euler = (np.arctan2(-3.0, 6.5) - np.pi / 2, 0.0, 0.0)
        scene.collection.objects.link(lamp)

    parts.mirror = mirror
    return parts


def made(parts, build):
    """A material whose surface `build` makes."""
    material, tree, surface = parts.material()
    tree.links.new(build(tree), surface)
    return material


def alike(folder, mean: float = 0.01, block: float = 0.03, **cycles_settings) -> np.ndarray:
    """Petzval shows what Cycles does, in the mean and block by block: the light is smooth, and at these samples its noise is
    less than a third of the first limit and two thirds of the other. Gives Petzval's picture."""
    from support import beside_cycles

    return beside_cycles.alike(folder, SAMPLES, side=BLOCK, mean=mean, block=block, bounces=4, **cycles_settings)


# Filter Glossy ------------------------------------------------------------------------------------------------------


def brushed(tree):
    """Wide enough along one axis alone."""
    made = glossy("BECKMANN", Color=GOLD, Roughness=0.3, Anisotropy=0.9)(tree)
    tree.links.new(node(tree, "Tangent", {"direction_type": "UV_MAP"}), made.node.inputs["Tangent"])
    return made


REFLECTING = {
    "ggx": glossy("GGX", Color=GOLD, Roughness=0.2),
    "mirror": glossy("MULTI_GGX", Color=GOLD, Roughness=0.0),
    "brushed beckmann": brushed,
    "ashikhmin-shirley": glossy("ASHIKHMIN_SHIRLEY", Color=GOLD, Roughness=0.2),
    "conductor": metal("PHYSICAL_CONDUCTOR", Roughness=0.2),
    "plastic": principled(Base_Color=RED, Roughness=0.1),
    "principled metal": principled(Base_Color=GOLD, Metallic=1.0, Roughness=0.2),
    "coat": principled(Base_Color=RED, Roughness=0.6, Coat_Weight=1.0, Coat_Roughness=0.05, Coat_IOR=1.8),
    # Wide enough as it is.
    "rough": glossy("GGX", Color=GOLD, Roughness=0.8),
}
LETTING_THROUGH = {
    "glass": glass("GGX", Color=WHITE, Roughness=0.1, IOR=1.45),
    "smooth glass": glass("MULTI_GGX", Color=WHITE, Roughness=0.0, IOR=1.45),
    "principled glass": principled(Base_Color=WHITE, Transmission_Weight=1.0, Roughness=0.2),
    "refraction": refraction("BECKMANN", Color=WHITE, Roughness=0.2, IOR=1.2),
}
CASES = [(kind, "above") for kind in REFLECTING] + [(kind, "behind") for kind in LETTING_THROUGH]


@pytest.mark.first_only("kind", "light")
@pytest.mark.parametrize(("kind", "light"), CASES, ids=[kind for kind, _ in CASES])
def test_filter_glossy(stage, blender, tmp_path, kind, light):
    """What the wall sees of the square is rougher than what the camera would see of it."""
    stage.mirror((REFLECTING | LETTING_THROUGH)[kind], light)
    # Cycles finds what glows by chance alone.
    alike(tmp_path, block=0.05 if light == "behind" else 0.03, blur_glossy=1.0)


@pytest.mark.once
@pytest.mark.parametrize("blur", [0.5, 10.0])
def test_filter_glossy_by_its_number(stage, blender, tmp_path, blur):
    stage.mirror(REFLECTING["ggx"], "above")
    ours = alike(tmp_path, blur_glossy=blur)
    blender.context.scene.cycles.blur_glossy = 0.0
    # No test passes because nothing happened.
    sharp = stage.render(tmp_path, "sharp.exr")[..., :3]
    assert np.abs(ours - sharp).mean() > 0.2 * sharp.mean()


@pytest.mark.once
def test_filter_glossy_of_what_a_mixture_looks_at(stage, blender, tmp_path):
    """The density of a direction is that of all lobes together, each by its chance."""
    stage.wall.data.materials[0] = made(
        stage, lambda tree: mix(tree, 0.5, diffuse(tree, WHITE), glossy("GGX", Color=WHITE, Roughness=0.5)(tree))
    )
    stage.mirror(REFLECTING["ggx"], "above")
    alike(tmp_path, blur_glossy=1.0)


@pytest.mark.once
def test_filter_glossy_from_fog(stage, blender, tmp_path):
    """Fog scatters with a density, too. Only fog is lit: the wall is black."""
    stage.wall.data.materials[0] = made(stage, lambda tree: diffuse(tree, (0.0, 0.0, 0.0, 1.0)))
    blender.ops.mesh.primitive_cube_add(size=1.5, location=(0.0, 2.0, 0.0))
    fog, tree, _ = stage.material("Fog")
    shader = node(tree, "VolumeScatter", None, Density=1.0, Anisotropy=0.3)
    tree.links.new(shader, next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL").inputs["Volume"])
    blender.context.object.data.materials.append(fog)
    stage.mirror(REFLECTING["ggx"], "above")
    # Noise of fog.
    alike(tmp_path, mean=0.015, block=0.05, blur_glossy=1.0, volume_bounces=2)


# Footprints ---------------------------------------------------------------------------------------------------------


def bumpy(tree, height: float = 0.05):
    """Matte, with a bump that is far finer than a pixel: how steep it looks depends on the footprint alone."""
    noise = node(tree, "TexNoise", None, Scale=5000.0, Detail=0.0).node
    bump = node(tree, "Bump", None, Strength=1.0, Distance=height).node
    tree.links.new(node(tree, "TexCoord").node.outputs["Object"], noise.inputs["Vector"])
    tree.links.new(noise.outputs[0], bump.inputs["Height"])
    made = diffuse(tree, WHITE)
    tree.links.new(bump.outputs[0], made.node.inputs["Normal"])
    return made


def half_glossy(tree):
    return mix(tree, 0.5, diffuse(tree, WHITE), glossy("GGX", Color=WHITE, Roughness=0.6)(tree))


LOOKING = {
    "matte": lambda tree: diffuse(tree, WHITE),
    "glossy": glossy("GGX", Color=WHITE, Roughness=0.5),
    "half glossy": half_glossy,
    "plastic": principled(Base_Color=WHITE, Roughness=0.5),
    "mirror": glossy("GGX", Color=WHITE, Roughness=0.0),
}


@pytest.mark.first_only("looking")
@pytest.mark.parametrize("blur", [0.0, 0.1])
@pytest.mark.parametrize("looking", LOOKING)
def test_bumps_after_a_scattering(stage, blender, tmp_path, looking, blur):
    """The footprint grows along the whole path; from 5.2 on the more, the rougher the surface that scatters."""
    stage.wall.data.materials[0] = made(stage, LOOKING[looking])
    stage.mirror(bumpy, "above")
    alike(tmp_path, block=0.05, blur_glossy=blur)


@pytest.mark.once
def test_bumps_away_from_the_middle(stage, blender, tmp_path):
    """A pixel is narrower towards the picture's edge, and a bump steeper."""
    stage.wall.data.materials[0] = made(stage, lambda tree: bumpy(tree, 0.2))
    blender.context.scene.camera.data.lens = 8
    stage.mirror(LOOKING["matte"], "above")
    alike(tmp_path, block=0.05, blur_glossy=0.0)


# Fast GI ------------------------------------------------------------------------------------------------------------


def fast_gi(method: str, bounces: int, distance: float, factor: float) -> dict:
    """Sets the world's part of it; gives Cycles's."""
    import bpy

    light = bpy.context.scene.world.light_settings
    light.distance, light.ao_factor = distance, factor
    # The viewport's is another.
    return {"use_fast_gi": True, "fast_gi_method": method, "ao_bounces_render": bounces, "ao_bounces": 7}


@pytest.mark.first_only("bounces")
@pytest.mark.parametrize("bounces", [0, 1, 2])
def test_fast_gi_replaces_bounces(room, blender, tmp_path, bounces):
    """Matte, metal and glass balls: each kind of bounce counts in its way. What glows is seen by the last ray, too."""
    add_panel(room)
    # Of its own.
    room.floor.cycles.ao_distance = 0.8
    ours = alike(tmp_path, **fast_gi("REPLACE", bounces, 1.5, 0.6))
    if bounces == 1:
        blender.context.scene.cycles.use_fast_gi = False
        whole = room.render(tmp_path, "whole.exr")[..., :3]
        assert np.abs(ours - whole).mean() > 0.02 * whole.mean()


@pytest.mark.once
def test_fast_gi_in_a_closed_room(blender, tmp_path):
    """The world shines through walls that are far enough, and on nothing but indirectly."""
    from support import scenes as parts

    scene = parts.set_up(SIDE, SIDE, SAMPLES)
    scene.world = parts.grey_world(1.0)
    blender.ops.mesh.primitive_cube_add(size=4.0, location=(0.0, 0.5, 0.0))
    blender.context.object.data.materials.append(made(parts, lambda tree: diffuse(tree, RED)))
    ours = alike(tmp_path, **fast_gi("REPLACE", 1, 1.0, 0.5))
    # Without, it is dark.
    assert ours.mean() > 0.1


@pytest.mark.once
def test_fast_gi_passes_what_is_clear(room, tmp_path):
    """A last ray goes on through a transparent surface, as far as it would without."""
    roof = made(
        room, lambda tree: mix(tree, 0.5, node(tree, "BsdfTransparent", None, Color=WHITE), diffuse(tree, WHITE))
    )
    for name, height in (("Low", 1.8), ("High", 2.4)):
        shade = room.mesh_object(
            name, [(-2, -2, height), (2, -2, height), (2, 2, height), (-2, 2, height)], [(0, 1, 2, 3)], roof
        )
        shade.visible_camera = False
    alike(tmp_path, **fast_gi("REPLACE", 1, 3.0, 1.0))


@pytest.mark.once
def test_fast_gi_of_fog(room, blender, tmp_path):
    """A last ray is dimmed by what fills space, and scattered there if no surface is near."""
    blender.ops.mesh.primitive_cube_add(size=1.6, location=(-1.9, 0.0, 0.85))
    fog, tree, _ = room.material("Fog")
    shader = node(tree, "VolumeScatter", None, Density=1.0)
    tree.links.new(shader, next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL").inputs["Volume"])
    blender.context.object.data.materials.append(fog)
    blender.data.objects["Matte"].scale = (0.5, 0.5, 0.5)
    # Noise of fog.
    alike(tmp_path, mean=0.015, block=0.05, volume_bounces=4, **fast_gi("REPLACE", 2, 1.5, 0.6))


@pytest.mark.once
@pytest.mark.parametrize("fogged", [False, True])
def test_fast_gi_is_added(room, blender, tmp_path, fogged):
    """White light from where nothing is near, on what is diffuse: at every bounce, in one lobe of several, and where light comes
    out of a body."""
    wax = made(room, lambda tree: node(tree, "SubsurfaceScattering", None, Color=WHITE, Scale=0.2))
    blender.data.objects["Matte"].data.materials[0] = wax
    plastic = made(room, principled(Base_Color=GOLD, Roughness=0.4))
    blender.data.objects["Metal"].data.materials[0] = plastic
    if fogged:
        blender.ops.mesh.primitive_cube_add(size=1.8, location=(1.9, 0.0, 0.85))
        fog, tree, _ = room.material("Fog")
        shader = node(tree, "VolumeAbsorption", None, Density=0.5, Color=RED)
        tree.links.new(shader, next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL").inputs["Volume"])
        blender.context.object.data.materials.append(fog)
    ours = alike(tmp_path, **fast_gi("ADD", 1, 1.5, 0.6))
    blender.context.scene.cycles.use_fast_gi = False
    without = room.render(tmp_path, "without.exr")[..., :3]
    assert (ours - without).mean() > 0.1 * without.mean()


def test_fast_gi_of_view_and_picture(blender):
    """Each has its own number of bounces; without a world there is no fast GI."""
    from support import scenes as parts

    scene = parts.set_up()
    for name, value in fast_gi("REPLACE", 3, 4.0, 0.5).items():
        setattr(scene.cycles, name, value)
    describe = parts.part("export.settings").describe
    picture, view = (describe(scene, 8, 8, is_viewport=is_view).approximations.fast_gi for is_view in (False, True))
    assert picture == {"REPLACE": {"bounces": 3, "distance": 4.0, "factor": 0.5}}
    assert view["REPLACE"]["bounces"] == 7
    scene.world = None
    assert describe(scene, 8, 8).approximations.fast_gi == "OFF"
