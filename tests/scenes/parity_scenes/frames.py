# SPDX-License-Identifier: GPL-3.0-or-later
"""Animations: three frames of each, rendered one after the other."""

from __future__ import annotations

import bpy

from . import scene
from .motion import FRAME, animate
from .studio import BLUE, CREAM, GOLD, GREEN, RED, ball, cube, empty_studio, lamp, material, monkey, plain, world

FRAMES = (FRAME - 2, FRAME, FRAME + 2)


@scene("Things slide, turn and grow", frames=FRAMES, noise=0.02)
def frames_of_things():
    empty_studio()
    slides = ball(plain(RED), (0.0, 0.0, 0.8), 0.6)
    animate(slides, "location", lambda t: (0.7 * t, 0.2 * t, 0.8))
    turns = cube(plain(BLUE), (1.5, 1.2, 0.9), 1.0)
    animate(turns, "rotation_euler", lambda t: (0.3, 0.0, 0.4 * t))
    grows = ball(plain(GREEN), (-1.4, 0.6, 0.7), 0.6)
    animate(grows, "scale", lambda t: (1.0 + 0.2 * t, 1.0, 1.0 - 0.2 * t))


@scene("Shapes bend, with their blur", frames=FRAMES, noise=0.02)
def frames_of_shapes():
    empty_studio()
    for x, make in ((-1.3, ball), (1.3, cube)):
        thing = make(plain(RED if x < 0 else BLUE), (x, 0.0, 0.9))
        thing.shape_key_add(name="Basis")
        bent = thing.shape_key_add(name="Bent")
        for point in bent.data:
            point.co.x += 0.9 * point.co.z * abs(point.co.z)
        bent.slider_min, bent.slider_max = -2.0, 2.0
        animate(bent, "value", lambda t: 0.4 * t)
    bpy.context.scene.render.use_motion_blur = True


@scene("The camera walks, turns and zooms, with its blur", frames=FRAMES, noise=0.02)
def frames_of_a_camera():
    empty_studio()
    monkey(plain(CREAM), (0.0, 0.0, 0.9), 1.7)
    ball(plain(RED), (-1.5, -1.5, 0.6), 0.6)
    cube(plain(BLUE), (1.6, 1.2, 0.6), 1.2)
    camera = bpy.context.scene.camera
    place, turn = camera.location.copy(), camera.rotation_euler.copy()
    animate(camera, "location", lambda t: (place.x + 0.2 * t, place.y + 0.5 * t, place.z))
    animate(camera, "rotation_euler", lambda t: (turn.x, turn.y, 0.05 * t))
    animate(camera.data, "lens", lambda t: 45.0 + 6.0 * t)
    bpy.context.scene.render.use_motion_blur = True


@scene("A lamp walks and changes its colour, the sky and a glowing thing dim", frames=FRAMES, noise=0.02)
def frames_of_light():
    empty_studio(lit=False)
    monkey(plain(CREAM), (0.3, 0.4, 0.9), 1.7)
    key = lamp("AREA", 250.0, (-2.0, -2.5, 4.0), (35, -25, 0), size=1.5)
    animate(key, "location", lambda t: (-2.0 + 1.2 * t, -2.5, 4.0))
    animate(key.data, "energy", lambda t: 250.0 - 60.0 * t)
    animate(key.data, "color", lambda t: (0.7 + 0.15 * t, 0.7, 0.7 - 0.15 * t))
    sky = world(lambda t: t.shows(t.node("Background", Color=CREAM, Strength=0.3).outputs[0]))
    strength = next(n for n in sky.node_tree.nodes if n.type == "BACKGROUND").inputs["Strength"]
    animate(strength, "default_value", lambda t: 0.3 - 0.1 * t)
    glow = material(lambda t: t.shows(t.node("Emission", Color=GOLD, Strength=1.5).outputs[0]))
    ball(glow, (-1.4, -0.8, 0.5), 0.5)
    brightness = next(n for n in glow.node_tree.nodes if n.type == "EMISSION").inputs["Strength"]
    animate(brightness, "default_value", lambda t: 1.5 + 0.5 * t)


@scene("Things appear and vanish, materials change", frames=FRAMES, noise=0.02)
def frames_of_appearance():
    empty_studio()
    comes, goes = ball(plain(RED), (-1.4, 0.0, 0.7), 0.7), cube(plain(BLUE), (1.4, 0.2, 0.7), 1.2)
    for thing, hidden in ((comes, (True, False, False)), (goes, (False, False, True))):
        for frame, value in zip(FRAMES, hidden, strict=True):
            thing.hide_render = value
            thing.keyframe_insert("hide_render", frame=frame)
    surface = plain(CREAM, Roughness=0.2)
    shader = next(n for n in surface.node_tree.nodes if n.type == "BSDF_PRINCIPLED").inputs
    animate(shader["Base Color"], "default_value", lambda t: (0.5 + 0.2 * t, 0.5, 0.5 - 0.2 * t, 1.0))
    animate(shader["Roughness"], "default_value", lambda t: 0.4 + 0.15 * t)
    monkey(surface, (0.0, 0.6, 0.9), 1.4)
