# SPDX-License-Identifier: GPL-3.0-or-later
"""Holes and caught shadows, and what a view layer makes of its objects."""

from __future__ import annotations

import bpy

from . import scene
from .studio import BLUE, CREAM, RED, ball, cube, empty_studio, material, monkey, plain


def _group() -> tuple[bpy.types.Object, bpy.types.Object, bpy.types.Object]:
    """A head, a ball and a cube on a floor before a wall."""
    empty_studio()
    return (
        monkey(plain(CREAM), (0.0, 0.0, 0.9), 1.7),
        ball(plain(RED), (-1.5, -1.5, 0.6), 0.6),
        cube(plain(BLUE), (1.6, 0.2, 0.6), 1.2),
    )


def _alone(name: str, *things: bpy.types.Object) -> bpy.types.LayerCollection:
    """A collection of these, as the view layer has it."""
    scene = bpy.context.scene
    made = bpy.data.collections.new(name)
    scene.collection.children.link(made)
    for one in things:
        scene.collection.objects.unlink(one)
        made.objects.link(one)
    return bpy.context.view_layer.layer_collection.children[name]


@scene("A Holdout shader, mixed with a surface")
def holdout_shader():
    head, one, _ = _group()

    def build(t):
        surface = t.principled(Base_Color=CREAM, Roughness=0.6)
        t.shows(t.node("MixShader", _0=0.6, _1=surface, _2=t.node("Holdout").outputs[0]).outputs[0])

    head.data.materials[0] = material(build)
    one.data.materials[0] = material(lambda t: t.shows(t.node("Holdout").outputs[0]))


@scene("An object that holds out, over a transparent film")
def holdout_object():
    head, *_ = _group()
    head.is_holdout = bpy.context.scene.render.film_transparent = True


@scene("A collection that holds out")
def holdout_collection():
    head, one, _ = _group()
    _alone("Holes", head, one).holdout = True


@scene("A collection that only bounces see")
def indirect_only():
    head, _, cube_ = _group()
    _alone("Unseen", head, cube_).indirect_only = True


@scene(
    "A floor that catches shadows, over the sky",
    tolerance=0.015,
    why="Cycles takes the sky away twice where a thing's edge crosses a pixel of the floor, docs/design/passes.md",
)
def shadow_catcher():
    _group()
    bpy.data.objects.remove(bpy.data.objects["Plane.001"])
    bpy.data.objects["Plane"].is_shadow_catcher = True


@scene("Floor and wall catch shadows, over a transparent film")
def shadow_catchers():
    _group()
    for name in ("Plane", "Plane.001"):
        bpy.data.objects[name].is_shadow_catcher = True
    bpy.context.scene.render.film_transparent = True


@scene("A view layer's own material")
def material_override():
    _group()
    bpy.context.view_layer.material_override = plain((0.3, 0.6, 0.4, 1.0), Roughness=0.3)
