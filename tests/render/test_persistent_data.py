# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's Persistent Data: what stays from one render to the next is not sent again, and the picture is that of a scene sent whole."""

from __future__ import annotations

import numpy as np
import pytest


@pytest.fixture
def room(parts, blender):
    """A textured square and a red one before a grey sky, hair on a third, and a camera that moves from frame to frame."""
    scene = parts.set_up(width=36, height=24, samples=8)
    image = blender.data.images.new("Stripes", 4, 4)
    image.pixels.foreach_set(
        np.tile(np.repeat(np.float32([[0.2, 0.9, 0.4, 1.0], [0.9, 0.1, 0.5, 1.0]]), 2, 0).ravel(), 4)
    )
    painted, tree, surface = parts.material("Painted")
    texture, diffuse = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeBsdfDiffuse")
    texture.image, texture.interpolation = image, "Closest"
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(coordinates.outputs["Object"], texture.inputs["Vector"])
    tree.links.new(texture.outputs[0], diffuse.inputs[0])
    tree.links.new(diffuse.outputs[0], surface)
    parts.square("Painted", (-0.4, 3.0, 0.0), 0.8, painted)
    parts.square("Red", (0.5, 3.0, 0.1), 0.7, parts.emitter((2.0, 0.3, 0.3), name="Red"))
    hairs = blender.data.hair_curves.new("Hairs")
    hairs.add_curves([3] * 5)
    hairs.position_data.foreach_set(
        "vector",
        np.float32([[0.2 * strand - 0.4, 2.5, 0.2 * key - 0.6] for strand in range(5) for key in range(3)]).ravel(),
    )
    scene.collection.objects.link(blender.data.objects.new("Hairs", hairs))
    for frame, x in ((1, 0.0), (9, 0.4)):
        scene.camera.location.x = x
        scene.camera.keyframe_insert("location", frame=frame)
    scene.frame_set(1)
    return scene


def bend(bpy, parts):
    mesh = bpy.data.objects["Red"].data
    mesh.vertices[0].co.z += 0.4
    mesh.update()


def recolour(bpy, parts):
    emission = next(node for node in bpy.data.materials["Red"].node_tree.nodes if node.type == "EMISSION")
    emission.inputs["Color"].default_value = (0.2, 0.4, 3.0, 1.0)


def repaint(bpy, parts):
    image = bpy.data.images["Stripes"]
    image.pixels.foreach_set(np.full(4 * 4 * 4, 0.8, np.float32))
    image.update()
    image.update_tag()


def comb(bpy, parts):
    hairs = bpy.data.objects["Hairs"].data
    hairs.position_data[2].vector.x += 0.5
    hairs.update_tag()


def add(bpy, parts):
    parts.square("New", (0.0, 2.8, -0.5), 0.3, parts.emitter((0.1, 2.0, 0.1), name="New"))


def remove(bpy, parts):
    bpy.data.objects.remove(bpy.data.objects["Red"])


def exchange(bpy, parts):
    """One material for another."""
    bpy.data.objects["Painted"].material_slots[0].material = bpy.data.materials["Red"]


def darken(bpy, parts):
    bpy.context.scene.world = parts.grey_world(0.1)


#: Edits, and how many images, materials and meshes are sent or forgotten for each.
EDITS = {
    "the camera moves": (lambda bpy, parts: None, 0),
    "an object moves": (lambda bpy, parts: setattr(bpy.data.objects["Red"].location, "z", 0.5), 0),
    "a mesh changes": (bend, 2),
    "a material changes": (recolour, 2),
    "hair changes": (comb, 2),
    "an object comes": (add, 2),
    "an object goes": (remove, 1),
    "another material": (exchange, 2),
    "another sky": (darken, 0),
    "an image changes": (repaint, None),
}


@pytest.mark.parametrize("edit", EDITS)
def test_the_picture_is_that_of_a_scene_sent_whole(room, parts, blender, tmp_path, edit):
    change, sent = EDITS[edit]
    persistent, scene = parts.part("render.persistent"), room
    scene.render.use_persistent_data = True
    first = parts.render(tmp_path, "first.exr")
    before = persistent._last.kept.changes
    change(blender, parts)
    scene.frame_set(5)
    second = parts.render(tmp_path, "second.exr")
    assert sent is None or persistent._last.kept.changes - before == sent
    scene.render.use_persistent_data = False
    assert np.array_equal(second, parts.render(tmp_path, "whole.exr"))
    assert persistent._last is None
    assert not np.array_equal(first, second)


def test_an_image_that_changed_while_another_engine_rendered(room, parts, blender, tmp_path):
    """Blender makes a new dependency graph then."""
    room.render.use_persistent_data = True
    parts.render(tmp_path, "first.exr")
    room.render.engine = "BLENDER_WORKBENCH"
    repaint(blender, parts)
    room.render.engine = "CYCLES"
    room.cycles.samples = 1
    parts.render(tmp_path, "cycles.exr")
    room.render.engine = "PETZVAL"
    second = parts.render(tmp_path, "second.exr")
    room.render.use_persistent_data = False
    assert np.array_equal(second, parts.render(tmp_path, "whole.exr"))


def test_fingerprints_do_not_depend_on_what_was_sent_before(room, parts, blender, tmp_path, monkeypatch):
    """A checkpoint of one frame of an animation is gone on with by a render of that frame alone."""
    checkpoints, found = parts.part("render.checkpoints"), []
    plain = checkpoints.Checkpoint.add

    def add(self, pieces):
        plain(self, pieces)
        found.append(self._scene.hexdigest())

    monkeypatch.setattr(checkpoints.Checkpoint, "add", add)
    room.petzval.use_checkpoints = room.render.use_persistent_data = True
    parts.render(tmp_path, "first.exr")
    recolour(blender, parts)
    room.frame_set(5)
    parts.render(tmp_path, "second.exr")
    room.render.use_persistent_data = False
    parts.render(tmp_path, "alone.exr")
    assert found[1] == found[2] != found[0]
    # Nothing watched the first of these: its pieces have no fingerprints, so all is sent again.
    room.render.use_persistent_data, room.petzval.use_checkpoints = True, False
    parts.render(tmp_path, "unwatched.exr")
    room.petzval.use_checkpoints = True
    parts.render(tmp_path, "watched.exr")
    assert found[3] == found[2]


def test_warnings_stay_until_they_are_mended(room, parts, blender, tmp_path):
    """A missing image is said in each frame, until there is one."""
    last = parts.part("render.statistics").last
    image = blender.data.images["Stripes"]
    texture = next(node for node in blender.data.materials["Painted"].node_tree.nodes if node.type == "TEX_IMAGE")
    texture.image = None
    room.render.use_persistent_data = True
    for frame in (1, 2):
        room.frame_set(frame)
        parts.render(tmp_path, f"{frame}.exr")
        assert any("magenta" in warning for warning in last(room.name).warnings)
    texture.image = image
    parts.render(tmp_path, "3.exr")
    assert not last(room.name).warnings


def test_a_memory_limit_counts_every_mesh(room, parts, blender, tmp_path):
    """What was sent in the frame before takes memory, too: with a limit all is sent and counted again."""
    room.render.use_persistent_data, room.petzval.memory_limit = True, 4.0
    parts.render(tmp_path, "1.exr")
    room.frame_set(2)
    first = parts.part("render.persistent")._last
    parts.render(tmp_path, "2.exr")
    assert parts.part("render.persistent")._last is not first and first.shared_settings is None
