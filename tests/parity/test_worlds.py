# SPDX-License-Identifier: GPL-3.0-or-later
"""Worlds whose nodes are computed by direction, against Cycles in the same Blender, block by block."""

from __future__ import annotations

import pytest

from support.ball_in_sky import alike
from support.node_tree import Tree


def clouds(t: Tree):
    noise = t.node("TexNoise", Vector=t.coordinates("Generated"), Scale=2.0)
    t.shows(t.node("Background", Color=t.ramp(noise.outputs[0]), Strength=1.5).outputs[0])


def camera_sees_another(t: Tree):
    """Lit by one colour before another."""
    path = t.node("LightPath")
    light = t.node("Background", Color=(0.9, 0.6, 0.3, 1.0))
    seen = t.node("Background", Color=(0.1, 0.2, 0.5, 1.0))
    t.shows(t.node("MixShader", _0=path.outputs["Is Camera Ray"], _1=light.outputs[0], _2=seen.outputs[0]).outputs[0])


def gradient(t: Tree):
    parts = t.node("SeparateXYZ", Vector=t.coordinates("Generated"))
    t.shows(t.node("Background", Color=t.ramp(parts.outputs["Z"])).outputs[0])


def preetham(t: Tree):
    sky = t.node("TexSky", {"sky_type": "PREETHAM", "turbidity": 3.0})
    t.shows(t.node("Background", Color=sky.outputs[0], Strength=0.2).outputs[0])


def scattered(kind: str, elevation: float, **settings):
    """A sky with its sun, dimmed like a photographer would."""

    def build(t: Tree):
        import bpy

        older = bpy.app.version < (5, 0, 0)
        sky_type = "NISHITA" if older and kind == "SINGLE_SCATTERING" else kind
        if older and kind == "MULTIPLE_SCATTERING":
            pytest.skip("this Blender has no such sky")
        sky = t.node("TexSky", {"sky_type": sky_type, "sun_elevation": elevation, "sun_rotation": 2.6, **settings})
        t.shows(t.node("Background", Color=sky.outputs[0], Strength=0.1).outputs[0])

    build.__name__ = f"{kind.lower()}_{elevation}_{'_'.join(settings)}"
    return build


def mirrored(t: Tree):
    """The mirrored direction; not below 0."""
    scaled = t.node(
        "VectorMath", {"operation": "MULTIPLY_ADD"}, _0=t.coordinates("Reflection"), _1=(0.45,) * 3, _2=(0.5,) * 3
    )
    t.shows(t.node("Background", Color=scaled.outputs[0]).outputs[0])


def nothing_there(t: Tree):
    """The fields of surfaces, objects, particles and rays that end, where there are none of these."""
    across = t.node("SeparateXYZ", Vector=t.node("NewGeometry").outputs["Parametric"]).outputs["X"]
    alpha = t.node("ObjectInfo").outputs["Alpha"]
    random = t.node("ParticleInfo").outputs["Random"]
    length = t.node("Math", {"operation": "MINIMUM"}, _0=t.node("LightPath").outputs["Ray Length"], _1=0.3)
    color = t.node("CombineXYZ", X=across, Y=random, Z=length.outputs[0])
    darker = t.node("Math", {"operation": "MULTIPLY_ADD"}, _0=alpha, _1=0.5, _2=0.7)
    t.shows(t.node("Background", Color=color.outputs[0], Strength=darker.outputs[0]).outputs[0])


def hosek(t: Tree):
    sky = t.node("TexSky", {"sky_type": "HOSEK_WILKIE", "turbidity": 4.0, "sun_direction": (0.3, -0.4, 0.6)})
    t.shows(t.node("Background", Color=sky.outputs[0], Strength=1.0).outputs[0])


def colour_for_a_shader(t: Tree):
    """An Environment Texture linked to the output without a Background."""
    import bpy
    import numpy as np

    pixels = np.ones((4, 8, 4), np.float32)
    pixels[..., 0], pixels[..., 2] = np.linspace(0.0, 2.0, 8), np.linspace(0.2, 1.0, 4)[:, None]
    image = bpy.data.images.new("sky", 8, 4, float_buffer=True)
    image.pixels.foreach_set(pixels.ravel())
    t.shows(t.node("TexEnvironment", {"image": image}).outputs[0])


def lost_image(t: Tree):
    """The same, its file missing."""
    import bpy

    image = bpy.data.images.new("lost", 4, 4)
    image.source, image.filepath = "FILE", "//lost.hdr"
    t.shows(t.node("TexEnvironment", {"image": image}).outputs[0])


SKIES = [
    scattered("SINGLE_SCATTERING", 0.6),
    scattered("MULTIPLE_SCATTERING", 0.6),
    # The sun half below the horizon.
    scattered("MULTIPLE_SCATTERING", 0.0, sun_size=0.1),
    scattered("SINGLE_SCATTERING", 0.2, sun_size=0.05, sun_intensity=0.3, altitude=2000.0),
    scattered("MULTIPLE_SCATTERING", 0.5, sun_disc=False),
]


@pytest.mark.parametrize(
    "build",
    [
        *SKIES,
        hosek,
        clouds,
        camera_sees_another,
        gradient,
        mirrored,
        nothing_there,
        preetham,
        colour_for_a_shader,
        lost_image,
    ],
    ids=lambda one: one.__name__,
)
def test_worlds(stage, blender, tmp_path, build):
    scene = blender.context.scene
    tree = stage.with_nodes(scene.world)
    output = tree.nodes.new("ShaderNodeOutputWorld")
    build(Tree(tree, output.inputs["Surface"]))
    made, nodes, surface = stage.material()
    shader = nodes.nodes.new("ShaderNodeBsdfPrincipled")
    shader.inputs["Roughness"].default_value = 0.3
    nodes.links.new(shader.outputs[0], surface)
    blender.context.object.data.materials.append(made)
    # 512 samples of 144 pixels; Cycles samples its own table of the sky.
    is_lost = build is lost_image
    # Magenta has no green.
    alike(tmp_path, 0.02, floor=0.1 * is_lost, warns="lost.hdr" * is_lost)


def two_alike(t: Tree):
    """One colour, by nodes that could give another to other rays."""
    path = t.node("LightPath")
    both = [t.node("Background", Color=(0.5, 0.6, 0.8, 1.0)) for _ in range(2)]
    t.shows(
        t.node("MixShader", _0=path.outputs["Is Camera Ray"], _1=both[0].outputs[0], _2=both[1].outputs[0]).outputs[0]
    )


def one_colour(t: Tree):
    t.shows(t.node("Background", Color=(0.5, 0.6, 0.8, 1.0)).outputs[0])


@pytest.mark.parametrize("build", [lost_image, two_alike, one_colour], ids=lambda one: one.__name__)
def test_one_colour_behind_glass_that_throws_no_shadow(stage, blender, tmp_path, build):
    """Light samples pass such glass, rays of closures do not, so what the ball gets hangs on which worlds are sampled: in Cycles those with an image,
    although it is missing and one colour."""
    scene = blender.context.scene
    tree = stage.with_nodes(scene.world)
    output = tree.nodes.new("ShaderNodeOutputWorld")
    build(Tree(tree, output.inputs["Surface"]))
    made, nodes, surface = stage.material()
    nodes.links.new(nodes.nodes.new("ShaderNodeBsdfDiffuse").outputs[0], surface)
    blender.context.object.data.materials.append(made)
    blender.ops.mesh.primitive_cube_add(size=3.0)
    shell, nodes, surface = stage.material("Shell")
    t = Tree(nodes, surface)
    dark = t.node("BsdfGlossy", Color=(0.4, 0.4, 0.4, 1.0), Roughness=0.2).outputs[0]
    seen = t.node("MixShader", _0=0.5, _1=dark, _2=t.node("BsdfTransparent").outputs[0]).outputs[0]
    is_shadow = t.node("LightPath").outputs["Is Shadow Ray"]
    t.shows(t.node("MixShader", _0=is_shadow, _1=seen, _2=t.node("BsdfTransparent").outputs[0]).outputs[0])
    blender.context.object.data.materials.append(shell)
    is_lost = build is lost_image
    alike(tmp_path, 0.02, floor=0.1 * is_lost, warns="lost.hdr" * is_lost)
