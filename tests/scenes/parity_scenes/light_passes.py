# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture's light in parts: by lobe, by where it comes from, by group, and what shadows leave of it."""

from __future__ import annotations

import bpy

from . import scene, volumes
from .studio import BLUE, CREAM, GOLD, GREEN, RED, WHITE, ball, cube, empty_studio, lamp, material, monkey, plain, plane


def _asks(*names: str, of_cycles: bool = False) -> None:
    layer = bpy.context.view_layer
    for name in names:
        setattr(layer.cycles if of_cycles else layer, f"use_pass_{name}", True)


def _asks_for_lobe(name: str) -> None:
    _asks(*(f"{name}_{part}" for part in ("direct", "indirect", "color")))


@scene("Diffuse", passes=("Diffuse Direct", "Diffuse Indirect", "Diffuse Color"), noise=0.02)
def diffuse_light():
    """Nothing touches the floor: which of two faces in one place light meets first, and whether both, is chance."""
    empty_studio()
    monkey(plain(CREAM), (-0.8, 0.0, 0.9), 1.7)
    ball(material(lambda t: t.shows(t.diffuse(RED, Roughness=0.8))), (1.0, -0.8, 0.6), 0.6)
    cube(material(lambda t: t.shows(t.node("BsdfTranslucent", Color=GREEN).outputs[0])), (1.5, 1.2, 0.65), 1.2)
    _asks_for_lobe("diffuse")


@scene(
    "Glossy: metals and plastic",
    passes=("Glossy Direct", "Glossy Indirect", "Glossy Color"),
    tolerance=0.025,
    why="colour where plastic is seen at a slant, docs/design/passes.md",
    noise=0.02,
)
def glossy_light():
    empty_studio()
    monkey(plain(GOLD, Metallic=1.0, Roughness=0.4), (-0.8, 0.0, 0.9), 1.7)
    ball(plain(BLUE, Roughness=0.3, Coat_Weight=0.5), (1.0, -0.8, 0.6), 0.6)
    cube(material(lambda t: t.shows(t.glossy(CREAM, 0.7, "MULTI_GGX"))), (1.5, 1.2, 0.6), 1.2)
    _asks_for_lobe("glossy")


@scene(
    "Transmission: clear and tinted glass, and a pane before the sky",
    passes=("Transmission Direct", "Transmission Indirect", "Transmission Color"),
    noise=0.03,
)
def transmitted_light():
    """Lit by the sky alone: light that a lamp sends through glass is rare, and bright."""
    empty_studio(lit=False, strength=1.0)
    bpy.data.objects.remove(bpy.data.objects["Plane.001"])
    ball(plain(WHITE, Transmission_Weight=1.0, Roughness=0.0, IOR=1.45), (-0.9, 0.0, 0.9), 0.9)
    cube(material(lambda t: t.shows(t.node("BsdfGlass", Color=GREEN, IOR=1.3).outputs[0])), (1.0, -0.3, 0.65), 1.2)
    pane = material(lambda t: t.shows(t.node("BsdfRefraction", Color=GOLD, Roughness=0.0, IOR=1.2).outputs[0]))
    plane(pane, (0.3, 3.0, 2.6), 1.6, (80, 0, 10))
    _asks_for_lobe("transmission")


@scene("What volumes scatter", passes=("Volume Direct", "Volume Indirect"), noise=0.02)
def volume_light():
    empty_studio(strength=0.2)
    volumes.bounces(3)
    ball(plain(RED), (1.3, -0.6, 0.6), 0.6)
    cube(volumes.filled(lambda t: volumes.scatter(t, 0.8, CREAM)), (-0.4, 0.0, 1.01), 2.0)
    _asks("volume_direct", "volume_indirect", of_cycles=True)


@scene("What glows, and the sky behind it", passes=("Emission", "Environment"))
def emission_and_environment():
    empty_studio(lit=False)
    bpy.data.objects.remove(bpy.data.objects["Plane.001"])
    ball(material(lambda t: t.shows(t.node("Emission", Color=GOLD, Strength=2.0).outputs[0])), (-1.0, 0.0, 0.9), 0.7)
    pane = material(lambda t: t.shows(t.node("BsdfTransparent", Color=(0.5, 0.8, 1.0, 1.0)).outputs[0]))
    cube(pane, (0.9, -0.6, 1.2), 1.3)
    _asks("emit", "environment")


@scene("Light by group", passes=("Combined_Key", "Combined_Glow", "Combined_Sky"), noise=0.02)
def groups_of_light():
    empty_studio(lit=False)
    monkey(plain(CREAM), (-0.4, 0.0, 0.9), 1.7)
    glow = ball(
        material(lambda t: t.shows(t.node("Emission", Color=GOLD, Strength=6.0).outputs[0])), (1.4, -0.6, 0.5), 0.5
    )
    key = lamp("AREA", 350.0, (-3.0, -2.5, 4.5), (40, -35, 0), size=2.0)
    for name, holder in (("Key", key), ("Glow", glow), ("Sky", bpy.context.scene.world)):
        bpy.context.view_layer.lightgroups.add(name=name)
        holder.lightgroup = name


@scene("What shadows leave of the light on what catches them", passes=("Shadow Catcher",))
def caught_shadow():
    empty_studio()
    monkey(plain(CREAM), (0.0, 0.0, 0.9), 1.7)
    ball(plain(RED), (-1.5, -1.5, 0.6), 0.6)
    for name in ("Plane", "Plane.001"):
        bpy.data.objects[name].is_shadow_catcher = True
    _asks("shadow_catcher", of_cycles=True)
