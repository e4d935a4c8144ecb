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


@pytest.fixture
def fingerprints(parts, monkeypatch):
    """Those of the scenes that are rendered from now on."""
    checkpoints, found = parts.part("render.checkpoints"), []
    plain = checkpoints.Checkpoint.add

    def add(self, pieces):
        plain(self, pieces)
        found.append(self._scene.hexdigest())

    monkeypatch.setattr(checkpoints.Checkpoint, "add", add)
    return found


def test_fingerprints_do_not_depend_on_what_was_sent_before(room, parts, blender, tmp_path, fingerprints):
    """A checkpoint of one frame of an animation is gone on with by a render of that frame alone."""
    found = fingerprints
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


@pytest.fixture
def filmed(room, parts, blender, tmp_path):
    """The room, its red square showing an image sequence of three frames from the third on; again from the first after these."""
    from support import image_files as files

    colours = {1: (0.9, 0.2, 0.1), 2: (0.2, 0.9, 0.1), 3: (0.1, 0.2, 0.9)}
    material, tree, surface = parts.material("Filmed")
    texture, glow = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeEmission")
    texture.image = files.sequence(tmp_path, {frame: files.plain(colour) for frame, colour in colours.items()})
    user = texture.image_user
    user.frame_start, user.frame_duration, user.use_auto_refresh = 3, 3, True
    tree.links.new(texture.outputs[0], glow.inputs[0])
    tree.links.new(glow.outputs[0], surface)
    blender.data.objects["Red"].material_slots[0].material = material
    room.render.use_persistent_data = True
    return texture


def test_a_sequence_follows_the_frame(filmed, room, parts, blender, tmp_path):
    """Its frame alone is sent again, and the last one forgotten; nothing where the frame stays."""
    persistent = parts.part("render.persistent")
    pictures, changes = {}, {}
    for frame in (3, 4, 5, 6, 7):
        room.frame_set(frame)
        pictures[frame] = parts.render(tmp_path, f"{frame}.exr")
        kept = persistent._last.kept
        changes[frame] = kept.changes
        # The stripes and one frame, opaque each: two keys of one image.
        assert len(set(kept.images.values())) == 2
        assert not parts.part("render.statistics").last(room.name).warnings
    # A material and an image, forgotten and sent; after the last frame nothing.
    assert [changes[frame + 1] - changes[frame] for frame in (3, 4, 5, 6)] == [4, 4, 0, 0]
    room.render.use_persistent_data = False
    for frame, picture in pictures.items():
        room.frame_set(frame)
        assert np.array_equal(picture, parts.render(tmp_path, f"whole-{frame}.exr")), frame


def test_a_frame_that_is_missing_is_said_while_it_is(filmed, room, parts, blender, tmp_path):
    """By a node that views do not refresh."""
    filmed.image_user.use_auto_refresh = False
    last = parts.part("render.statistics").last
    (tmp_path / "frame_0002.png").unlink()
    for frame, told in ((3, 0), (4, 1), (5, 0), (4, 1)):
        room.frame_set(frame)
        parts.render(tmp_path, "picture.exr")
        warnings = last(room.name).warnings
        assert len(warnings) == told and all("frame 2" in one for one in warnings), frame


def test_a_sequence_of_the_world(filmed, room, parts, blender, tmp_path):
    tree = room.world.node_tree
    sky = tree.nodes.new("ShaderNodeTexEnvironment")
    sky.image = filmed.image
    sky.image_user.frame_duration = 3
    # One frame behind the sky's.
    filmed.image_user.frame_start, filmed.image_user.use_cyclic = 2, True
    tree.links.new(sky.outputs[0], next(node for node in tree.nodes if node.type == "BACKGROUND").inputs["Color"])
    pictures = []
    for frame in (1, 2, 3):
        room.frame_set(frame)
        pictures.append(parts.render(tmp_path, f"{frame}.exr"))
        # The stripes, the frame of the sky, and that of the square.
        assert len(set(parts.part("render.persistent")._last.kept.images.values())) == 3
    sky.image = None
    parts.render(tmp_path, "without.exr")
    assert len(set(parts.part("render.persistent")._last.kept.images.values())) == 2
    sky.image = filmed.image
    room.render.use_persistent_data = False
    for frame, picture in enumerate(pictures, 1):
        room.frame_set(frame)
        assert np.array_equal(picture, parts.render(tmp_path, "whole.exr")), frame


def test_tiles_stay(room, parts, blender, tmp_path):
    """Tiles of an image are sent once, and again when the image changes."""
    from support import image_files as files

    texture = next(node for node in blender.data.materials["Painted"].node_tree.nodes if node.type == "TEX_IMAGE")
    texture.image = files.tiled(tmp_path, {1001: files.picture(8, 8, 1), 1011: files.picture(4, 4, 2)})
    persistent = parts.part("render.persistent")
    room.render.use_persistent_data = True
    parts.render(tmp_path, "first.exr")
    before = persistent._last.kept.changes
    room.frame_set(5)
    parts.render(tmp_path, "second.exr")
    assert persistent._last.kept.changes == before
    files.save(tmp_path / "tile.1001.png", files.plain((0.1, 0.9, 0.3)))
    texture.image.reload()
    texture.image.update_tag()
    changed = parts.render(tmp_path, "changed.exr")
    room.render.use_persistent_data = False
    assert np.array_equal(changed, parts.render(tmp_path, "whole.exr"))


def test_fingerprints_of_frames_and_tiles(filmed, room, parts, blender, tmp_path, fingerprints):
    from support import image_files as files

    texture = next(node for node in blender.data.materials["Painted"].node_tree.nodes if node.type == "TEX_IMAGE")
    texture.image = files.tiled(tmp_path, {1001: files.picture(8, 8, 1), 1011: files.picture(4, 4, 2)})
    room.petzval.use_checkpoints = True
    for frame in (3, 4, 5):
        room.frame_set(frame)
        parts.render(tmp_path, "persistent.exr")
    room.render.use_persistent_data = False
    for frame in (3, 4, 5):
        room.frame_set(frame)
        parts.render(tmp_path, "alone.exr")
    assert fingerprints[:3] == fingerprints[3:] and len(set(fingerprints)) == 3
