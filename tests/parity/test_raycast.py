# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays that shaders cast: the Raycast node against Cycles in the same Blender."""

from __future__ import annotations

import numpy as np
import pytest

from support.ball_in_sky import alike
from support.node_tree import Tree
from support.shaders import material_of

pytestmark = pytest.mark.once


def _cast(t: Tree, settings: dict | None = None, **inputs):
    """A ray from a ball, a floor under it and a wall behind it, all of the same material."""
    import bpy

    ball = bpy.context.object
    for place, turn in (((0.0, 0.0, -1.0), 0.0), ((0.0, 1.3, 0.0), np.pi / 2)):
        bpy.ops.mesh.primitive_plane_add(size=8.0, location=place, rotation=(turn, 0.0, 0.0))
        bpy.context.object.data.materials.append(material_of(t))
    bpy.context.view_layer.objects.active = ball
    return t.node("Raycast", settings, **inputs)


def _glows(t: Tree, *numbers):
    """With three numbers, and a little of each where it is zero."""
    parts = dict(zip("XYZ", (t.math("ADD", number, 0.1) for number in numbers), strict=True))
    t.shows(t.node("Emission", Color=t.node("CombineXYZ", **parts).outputs[0]).outputs[0])


def cast_along_the_normal(t: Tree):
    made = _cast(t, Length=6.0)
    far = t.math("MULTIPLY", made.outputs["Hit Distance"], 0.2)
    _glows(t, made.outputs["Is Hit"], made.outputs["Self Hit"], far)


def cast_no_farther(t: Tree):
    """Nothing is hit beyond the length, which is counted in directions."""
    direction = t.node("VectorMath", {"operation": "SCALE"}, _0=t.node("NewGeometry").outputs["Normal"], Scale=2.0)
    made = _cast(t, Direction=direction.outputs[0], Length=0.45)
    _glows(t, made.outputs["Is Hit"], made.outputs["Self Hit"], made.outputs["Hit Distance"])


def cast_onto_a_normal(t: Tree):
    """The side of the hit from which the ray came."""
    made = _cast(t, Direction=t.node("CombineXYZ", X=0.3, Y=1.0, Z=-0.4).outputs[0], Length=20.0)
    parts = t.node("SeparateXYZ", _0=made.outputs["Hit Normal"])
    _glows(t, *(t.math("MULTIPLY_ADD", parts.outputs[i], 0.5) for i in range(3)))


def cast_onto_a_place(t: Tree):
    made = _cast(t, Direction=t.node("CombineXYZ", X=0.2, Y=0.9, Z=-0.5).outputs[0], Length=20.0)
    t.shows(
        t.node(
            "Emission", Color=t.ramp(t.node("TexNoise", Vector=made.outputs["Hit Position"], Scale=1.5).outputs[0])
        ).outputs[0]
    )


def cast_from_elsewhere(t: Tree):
    """From above the surface back to it, which the ray hits as anything else."""
    up = t.node("VectorMath", {"operation": "SCALE"}, _0=t.node("NewGeometry").outputs["Normal"], Scale=0.7)
    place = t.node("VectorMath", {"operation": "ADD"}, _0=t.node("NewGeometry").outputs["Position"], _1=up.outputs[0])
    down = t.node("VectorMath", {"operation": "SCALE"}, _0=up.outputs[0], Scale=-1.0)
    made = _cast(t, Position=place.outputs[0], Direction=down.outputs[0], Length=20.0)
    _glows(t, made.outputs["Is Hit"], made.outputs["Self Hit"], t.math("MULTIPLY", made.outputs["Hit Distance"], 0.5))


def cast_at_itself_alone(t: Tree):
    inwards = t.node("VectorMath", {"operation": "SCALE"}, _0=t.node("NewGeometry").outputs["Normal"], Scale=-1.0)
    made = _cast(t, {"only_local": True}, Direction=inwards.outputs[0], Length=6.0)
    _glows(t, made.outputs["Is Hit"], made.outputs["Self Hit"], t.math("MULTIPLY", made.outputs["Hit Distance"], 0.4))


def cast_for_attributes(t: Tree):
    """Of what is hit, which asks for none of them itself."""
    import bpy

    from support import scenes

    made = _cast(t, Direction=t.node("CombineXYZ", X=0.3, Y=-0.2, Z=-1.0).outputs[0], Length=20.0)
    for kind in ("FLOAT", "VECTOR"):
        made.sample_attribute_items.new(kind, kind)
    for socket, name in zip([one for one in made.inputs if one.type == "STRING"], ("height", "way"), strict=True):
        socket.default_value = name
    for plane in (one for one in bpy.context.scene.objects if one.name.startswith("Plane")):
        plane.data.materials.clear()
        plane.data.materials.append(scenes.emitter((0.2, 0.3, 0.4)))
        plane.data.attributes.new("height", "FLOAT", "POINT").data.foreach_set("value", [0.1, 0.4, 0.9, 0.6])
        plane.data.attributes.new("way", "FLOAT_VECTOR", "POINT").data.foreach_set("vector", np.linspace(0.0, 1.0, 12))
    shown = [one for one in made.outputs if one.identifier.startswith("Attribute")]
    parts = t.node("SeparateXYZ", _0=shown[1])
    _glows(t, shown[0], parts.outputs[0], parts.outputs[2])


def cast_in_a_bump(t: Tree):
    """The distance of the floor and the wall as a height."""
    made = _cast(t, Direction=t.node("CombineXYZ", X=0.3, Y=1.0, Z=-0.6).outputs[0], Length=20.0)
    bump = t.node("Bump", Strength=0.7, Distance=0.3, Height=made.outputs["Hit Distance"])
    t.shows(t.node("BsdfDiffuse", Color=(0.6, 0.7, 0.8, 1.0), Normal=bump.outputs[0]).outputs[0])


CASTS = [
    cast_along_the_normal,
    cast_no_farther,
    cast_onto_a_normal,
    cast_onto_a_place,
    cast_from_elsewhere,
    cast_at_itself_alone,
    cast_for_attributes,
    cast_in_a_bump,
]


@pytest.mark.parametrize("graph", CASTS, ids=lambda graph: graph.__name__)
def test_rays_of_shaders(stage, blender, tmp_path, graph):
    if not hasattr(blender.types, "ShaderNodeRaycast"):
        pytest.skip("Blender has Raycast from 5.1 on")
    made, tree, surface = stage.material()
    blender.context.object.data.materials.append(made)
    graph(Tree(tree, surface))
    alike(tmp_path, 0.02, floor=0.0)
