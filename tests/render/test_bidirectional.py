# SPDX-License-Identifier: GPL-3.0-or-later
"""Bidirectional paths show what paths from the camera alone show: what shaders ask of a path, who sees whom, which light reaches how far."""

from __future__ import annotations

import numpy as np
import pytest

from support.node_tree import Tree

pytestmark = pytest.mark.once

SAMPLES, BLOCK = 64, 8


@pytest.fixture
def room(parts, blender):
    """A floor and a wall under a soft lamp, through a lens; gives the scene, the lamp, and what puts balls and plates there."""
    scene = parts.set_up(48, 32, SAMPLES, "LENS")
    parts.straight(scene)
    scene.world = parts.grey_world(0.0)
    camera, own = scene.camera, scene.camera.data.petzval
    own.lens_file, own.wide_open, own.f_number = "double-gauss-f2-tronnier.lens", False, 8.0
    own.focal_mode, camera.data.lens, camera.data.dof.focus_distance = "BLENDER", 50.0, 8.0
    camera.location, camera.rotation_euler = (0.0, -8.0, 1.4), (1.45, 0.0, 0.0)
    scene.petzval.clamp_indirect, scene.petzval.use_light_tracing = 0.0, False
    scene.petzval.max_bounces = scene.cycles.max_bounces = 8
    for kind in ("diffuse", "glossy", "transmission", "transparent_max"):
        setattr(scene.cycles, f"{kind}_bounces", 8)
    scene.cycles.blur_glossy = 0.0

    def material(build):
        made, tree, surface = parts.material()
        build(Tree(tree, surface))
        return made

    def plate(place, size, build, turn=(0.0, 0.0, 0.0)):
        blender.ops.mesh.primitive_plane_add(size=size, location=place, rotation=turn)
        blender.context.object.data.materials.append(material(build))
        return blender.context.object

    def ball(place, build):
        blender.ops.mesh.primitive_uv_sphere_add(radius=0.8, location=place, segments=48, ring_count=24)
        blender.ops.object.shade_smooth()
        blender.context.object.data.materials.append(material(build))
        return blender.context.object

    plate((0.0, 0.0, 0.0), 12.0, matte)
    plate((0.0, 3.0, 2.0), 12.0, matte, (np.pi / 2, 0.0, 0.0))
    blender.ops.object.light_add(type="AREA", location=(1.5, -1.5, 3.5), rotation=(0.3, 0.35, 0.0))
    lamp = blender.context.object
    lamp.data.energy, lamp.data.size = 200.0, 1.0
    return scene, lamp, ball, plate


def matte(t: Tree, colour=(0.7, 0.6, 0.5, 1.0)):
    t.shows(t.node("BsdfDiffuse", Color=colour).outputs[0])


def glossy(t: Tree):
    t.shows(t.node("BsdfAnisotropic", Color=(0.8, 0.8, 0.9, 1.0), Roughness=0.25).outputs[0])


def mirror(t: Tree):
    t.shows(t.node("BsdfAnisotropic", Roughness=0.0).outputs[0])


def green_where(answer: str):
    """Else red."""

    def build(t: Tree):
        green, red = (
            t.node("BsdfDiffuse", Color=colour).outputs[0] for colour in ((0.1, 0.8, 0.1, 1), (0.9, 0.1, 0.1, 1))
        )
        t.shows(t.mix(t.node("LightPath").outputs[answer], red, green))

    return build


def darker_by_depth(t: Tree):
    part = t.math("DIVIDE", 0.8, t.math("ADD", t.node("LightPath").outputs["Ray Depth"], 1.0))
    t.shows(t.node("BsdfDiffuse", Color=t.node("CombineXYZ", X=part, Y=0.5, Z=0.5).outputs[0]).outputs[0])


def clear_for_shadows(t: Tree):
    red = t.node("BsdfDiffuse", Color=(0.8, 0.3, 0.3, 1.0)).outputs[0]
    t.shows(t.mix(t.node("LightPath").outputs["Is Shadow Ray"], red, t.node("BsdfTransparent").outputs[0]))


def half_clear(t: Tree):
    red = t.node("BsdfDiffuse", Color=(0.8, 0.3, 0.3, 1.0)).outputs[0]
    t.shows(t.mix(0.5, red, t.node("BsdfTransparent").outputs[0]))


def bumpy(t: Tree):
    height = t.node("TexNoise", Vector=t.coordinates("Object"), Scale=60.0).outputs[0]
    bump = t.node("Bump", Strength=1.0, Distance=0.2, Height=height).outputs[0]
    t.shows(t.node("BsdfDiffuse", Color=(0.7, 0.7, 0.7, 1.0), Normal=bump).outputs[0])


MIDDLE, LEFT, RIGHT, ABOVE = (0.0, 0.0, 0.8), (-1.0, 0.0, 0.8), (1.0, 0.0, 0.8), (1.0, -1.0, 1.8)


def camera_sees_another_colour(_scene, _lamp, ball, _plate):
    ball(MIDDLE, green_where("Is Camera Ray"))


def diffuse_rays_see_another_colour(_scene, _lamp, ball, _plate):
    ball(MIDDLE, green_where("Is Diffuse Ray"))


def a_mirror_sees_another_colour(_scene, _lamp, ball, _plate):
    ball(LEFT, green_where("Is Glossy Ray"))
    ball(RIGHT, mirror)


def each_bounce_sees_a_darker_one(_scene, _lamp, ball, _plate):
    ball(MIDDLE, darker_by_depth)


def shadows_pass(_scene, _lamp, ball, plate):
    plate(ABOVE, 1.5, clear_for_shadows)
    ball(LEFT, matte)


def shadows_do_not_pass(_scene, _lamp, ball, plate):
    plate(ABOVE, 1.5, half_clear).active_material.use_transparent_shadow = False
    ball(LEFT, matte)


def hidden_from_gloss(_scene, _lamp, ball, _plate):
    ball(RIGHT, glossy)
    ball((-0.7, 0.0, 0.8), matte).visible_glossy = False


def hidden_from_diffuse_rays(_scene, _lamp, ball, _plate):
    ball(MIDDLE, matte).visible_diffuse = False


def a_lamp_without_gloss(_scene, lamp, ball, _plate):
    ball(MIDDLE, glossy)
    lamp.visible_glossy = False


def a_lamp_that_lights_no_bounce(_scene, lamp, ball, _plate):
    ball(MIDDLE, matte)
    lamp.data.cycles.max_bounces = 0


def fine_bumps(_scene, _lamp, ball, _plate):
    ball(MIDDLE, bumpy)


SCENES = [
    camera_sees_another_colour,
    diffuse_rays_see_another_colour,
    a_mirror_sees_another_colour,
    each_bounce_sees_a_darker_one,
    shadows_pass,
    shadows_do_not_pass,
    hidden_from_gloss,
    hidden_from_diffuse_rays,
    a_lamp_without_gloss,
    a_lamp_that_lights_no_bounce,
    fine_bumps,
]


@pytest.mark.parametrize("build", SCENES, ids=lambda build: build.__name__)
def test_it_shows_what_paths_show(room, parts, tmp_path, build):
    """In the mean and in blocks of 64 pixels, whose noise is a third of the limit; a glossy ball under a lamp has more."""
    scene = room[0]
    build(*room)
    found = {}
    for integrator in ("PATH", "BIDIRECTIONAL"):
        scene.petzval.integrator = integrator
        found[integrator] = parts.render(tmp_path)[..., :3]
        assert parts.part("render.statistics").last(scene.name).warnings == []
    blocks = [p.reshape(32 // BLOCK, BLOCK, 48 // BLOCK, BLOCK, 3).mean((1, 3)) for p in found.values()]
    off = np.abs(blocks[0] - blocks[1]) / (blocks[0] + 0.1 * blocks[0].mean())
    means = [one.mean((0, 1)) for one in blocks]
    print(f"{build.__name__}: mean {np.abs(means[1] / means[0] - 1.0).max():.4f}, block {off.max():.4f}")
    assert np.abs(means[1] / means[0] - 1.0).max() < 0.01
    assert off.max() < 0.06


def test_what_it_does_not_know_is_named(room, parts, tmp_path):
    scene, _lamp, ball, _plate = room
    ball(MIDDLE, matte)
    scene.petzval.integrator, scene.petzval.samples = "BIDIRECTIONAL", 1
    scene.cycles.diffuse_bounces, scene.cycles.caustics_refractive = 2, False
    parts.render(tmp_path)
    warnings = " ".join(parts.part("render.statistics").last(scene.name).warnings)
    assert "limits of single kinds of bounces" in warnings and "caustics that are switched off" in warnings
