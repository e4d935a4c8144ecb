# SPDX-License-Identifier: GPL-3.0-or-later
"""Light and shadow linking against Cycles in the same Blender, block by block."""

from __future__ import annotations

import pytest

from support.ball_row import alike, differs
from support.lamp_studio import lamp, panel


def collection(blender, *objects, state: str = "INCLUDE"):
    """A collection of objects, linked in that way."""
    made = blender.data.collections.new("Linked")
    for one in objects:
        made.objects.link(one)
    for held in made.collection_objects:
        held.light_linking.link_state = state
    return made


def emitter(studio, blender, kind: str):
    return panel(studio) if kind == "MESH" else lamp(blender, kind)


KINDS = ("POINT", "AREA", "SUN", "MESH")


@pytest.mark.first_only("kind")
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("state", ["INCLUDE", "EXCLUDE", "EMPTY"])
@pytest.mark.parametrize("role", ["receiver", "blocker"])
def test_links(studio, blender, tmp_path, kind, state, role):
    holder = emitter(studio, blender, kind)
    objects = () if state == "EMPTY" else (blender.data.objects["Sphere"],)
    linked = collection(blender, *objects, state="EXCLUDE" if state == "EMPTY" else state)
    setattr(holder.light_linking, f"{role}_collection", linked)
    # Seeds of either program differ by 4 % in a block where the area lamp is found by mirrors alone.
    ours = alike(tmp_path, block=0.06 if kind == "AREA" else 0.04)
    if state == "EXCLUDE" or (state == "INCLUDE" and role == "receiver"):
        setattr(holder.light_linking, f"{role}_collection", None)
        differs(ours, studio.render(tmp_path, "all.exr")[..., :3], 0.0005)


def test_collections_within_collections(studio, blender, tmp_path):
    holder, objects = lamp(blender, "AREA"), blender.data.objects
    outer, inner = collection(blender, objects["Floor"]), collection(blender, objects["Sphere"])
    outer.children.link(inner)
    outer.collection_children[0].light_linking.link_state = "EXCLUDE"
    holder.light_linking.receiver_collection = outer
    alike(tmp_path)


def test_several_lights(studio, blender, tmp_path):
    """Each with its own, and one for all."""
    objects = blender.data.objects
    names = ("Floor", "Wall", "Sphere")
    for place, name in enumerate(names):
        holder = lamp(blender, "POINT")
        holder.location.x = place - 1.0
        holder.data.color = [float(part == place) + 0.1 for part in range(3)]
        holder.light_linking.receiver_collection = collection(blender, objects[name])
        holder.light_linking.blocker_collection = collection(blender, objects[names[place - 1]], state="EXCLUDE")
    panel(studio)
    alike(tmp_path)


def test_more_sets_than_there_are_bits(studio, blender, tmp_path):
    for _ in range(70):
        holder = lamp(blender, "POINT without size")
        holder.data.energy = 1.0
        holder.light_linking.receiver_collection = collection(blender, blender.data.objects["Floor"])
    studio.render(tmp_path)
    warnings = studio.part("render.statistics").last("Scene").warnings
    assert len(warnings) == 7 and all("receiver collections" in one for one in warnings)
