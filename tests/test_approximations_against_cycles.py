# SPDX-License-Identifier: GPL-3.0-or-later
"""What Cycles gives up of indirect light for less noise or time, against Cycles in the same Blender."""

from __future__ import annotations

import numpy as np
import pytest

from test_closures_against_cycles import (
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
    import scene_parts as parts

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
    import beside_cycles

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


@pytest.mark.parametrize(("kind", "light"), CASES, ids=[kind for kind, _ in CASES])
def test_filter_glossy(stage, blender, tmp_path, kind, light):
    """What the wall sees of the square is rougher than what the camera would see of it."""
    stage.mirror((REFLECTING | LETTING_THROUGH)[kind], light)
    # Cycles finds what glows by chance alone.
    alike(tmp_path, block=0.05 if light == "behind" else 0.03, blur_glossy=1.0)


@pytest.mark.parametrize("blur", [0.5, 10.0])
def test_filter_glossy_by_its_number(stage, blender, tmp_path, blur):
    stage.mirror(REFLECTING["ggx"], "above")
    ours = alike(tmp_path, blur_glossy=blur)
    blender.context.scene.cycles.blur_glossy = 0.0
    # No test passes because nothing happened.
    sharp = stage.render(tmp_path, "sharp.exr")[..., :3]
    assert np.abs(ours - sharp).mean() > 0.2 * sharp.mean()


def test_filter_glossy_of_what_a_mixture_looks_at(stage, blender, tmp_path):
    """The density of a direction is that of all lobes together, each by its chance."""
    stage.wall.data.materials[0] = made(
        stage, lambda tree: mix(tree, 0.5, diffuse(tree, WHITE), glossy("GGX", Color=WHITE, Roughness=0.5)(tree))
    )
    stage.mirror(REFLECTING["ggx"], "above")
    alike(tmp_path, blur_glossy=1.0)


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
