# SPDX-License-Identifier: GPL-3.0-or-later
"""What `petzval dataset` refuses, and where it says it is; poses by their conventions."""

from __future__ import annotations

import numpy as np
import pytest

from petzval.errors import CommandError

GOOD = """scene = "scene.blend"
output = "out"
[[pose]]
location = [0, 0, 0]
rotation = [90, 0, 0]
[camera]
camera = "pinhole"
[classes.box]
objects = ["Box"]
[write]
picture = "png"
"""


def read(folder, text: str):
    from petzval.dataset import spec

    (folder / "scene.blend").touch()
    (folder / "spec.toml").write_text(text)
    return spec.read(folder / "spec.toml")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("[write]\n", "[write]\ndeepth = true\n"), ("spec.toml:11:1: write.deepth: unknown key", "did you mean depth")),
        (('camera = "pinhole"', 'f-number = "wide"'), ("spec.toml:7:1: camera.f-number: invalid number value",)),
        (('camera = "pinhole"', "f-number = -2"), ("spec.toml:7:1: camera.f-number: must be above zero",)),
        (('camera = "pinhole"', 'lens = "no-such-lens"'), ("spec.toml:6:1: camera: ", "no-such-lens")),
        (('camera = "pinhole"', "autofocus = [0.5, 0.5]"), ("spec.toml:7:1: camera.autofocus: unknown key",)),
        (("location = [0, 0, 0]", "location = [0, 0]"), ("spec.toml:4:1: pose[0].location: must be a list of 3 numbers",)),
        (("rotation = [90, 0, 0]", ""), ("spec.toml:3:1: pose[0]: a direction is missing",)),
        (("rotation = [90, 0, 0]", "target = [0, 0, 0]"), ("spec.toml:3:1: pose[0]: the camera stands in its own target",)),
        (("rotation = [90, 0, 0]", "rotation = [90, 0, 0]\ntarget = [1, 0, 0]"), ("spec.toml:3:1: pose[0]: ", "leave out all but one")),
        (("[[pose]]\n", "[orbit]\nradius = 2\ncount = 3\n[[pose]]\n"), ("[pose], [orbit] says where the camera stands",)),
        (('picture = "png"', 'picture = "jpg"'), ("spec.toml:11:1: write.picture: must be one of off, png, exr",)),
        (('picture = "png"', "instances = 1"), ("spec.toml:11:1: write.instances: must be true or false",)),
        (('objects = ["Box"]', "id = 3"), ("spec.toml:8:1: classes.box: says of nothing that it belongs here",)),
        (('scene = "scene.blend"', 'scene = "other.blend"'), ("spec.toml:1:1: scene: no such scene: ", "other.blend")),
        (('output = "out"', "output = out"), ("spec.toml:2:10: no TOML: ",)),
        (('output = "out"', 'output = "out"\nframes = "3-1"'), ("spec.toml:3:1: frames: ", "ends before it begins")),
    ],
)  # fmt: skip
def test_wrong_specifications(tmp_path, change, said):
    text = GOOD.replace(*change)
    assert text != GOOD
    with pytest.raises(CommandError) as refused:
        read(tmp_path, text)
    assert all(words in str(refused.value) for words in said), refused.value
    assert "\n" not in str(refused.value)


def test_a_good_one(tmp_path):
    made = read(tmp_path, GOOD)
    assert made.cameras[0].options["camera"] == "pinhole" and made.classes[0].id == 1


@pytest.mark.once
def test_what_only_the_scene_knows(tmp_path, petzval_cli):
    """An object that is not there is named with those that are; a camera that has no model, before anything is rendered."""
    from support import dataset_scene

    pytest.importorskip("bpy")
    dataset_scene.save(tmp_path / "scene.blend")
    (tmp_path / "a.toml").write_text(GOOD.replace("rotation = [90, 0, 0]", 'target = "Box.C"'))
    done = petzval_cli("dataset", tmp_path / "a.toml")
    assert done.returncode == 1 and "no object 'Box.C' in scene 'Scene'; there is Box.A, Box.B" in done.stderr.replace(
        "Box.B, Box.A", "Box.A, Box.B"
    )
    anchored = 'lens = "double-gauss-f2-tronnier"\nanchor = "film"'
    (tmp_path / "b.toml").write_text(GOOD.replace('camera = "pinhole"', anchored) + 'cameras = ["colmap"]\n')
    done = petzval_cli("dataset", tmp_path / "b.toml")
    assert done.returncode == 1 and "camera 'Camera' stands where its film is" in done.stderr
    assert not list((tmp_path / "out").rglob("*.png"))


def test_random_poses_stand_clear(blender, parts):
    """None is inside of a box or nearer to it than asked, and the same seed gives the same."""
    from petzval.dataset import placing
    from petzval.dataset.spec import Random

    blender.ops.mesh.primitive_cube_add(size=2, location=(0, 0, 0))
    around = placing.Surroundings(blender.context.evaluated_depsgraph_get())
    asked = Random(200, 5, ((-2, -2, -2), (2, 2, 2)), (0, 0, 0), (1, 1), (-90, 90), (0.0, 0.0, 0.0), 0.0, 0.2, True)
    found, refused = placing.random(asked, (0, 0, 0), (0.0, 0.0, 0.0), around)
    places = np.array([one[:3, 3] for one in found])
    beyond = np.maximum(np.abs(places) - 1, 0)
    assert np.linalg.norm(beyond, axis=1).min() > 0.2
    # The box's part of the volume, an eighth, is refused for being inside or near.
    assert any("inside of 'Cube'" in why for why in refused) and any(
        "nearer than 0.2 to 'Cube'" in why for why in refused
    )
    again, _ = placing.random(asked, (0, 0, 0), (0.0, 0.0, 0.0), around)
    assert np.array_equal(places, [one[:3, 3] for one in again])
    # The target lies on the axis.
    for one in found:
        seen = np.linalg.inv(one) @ [0, 0, 0, 1]
        assert np.abs(seen[:2]).max() < 1e-9 and seen[2] < 0


def test_files_of_poses_come_back(tmp_path):
    """What is written for COLMAP, NeRF and KITTI is read as the same poses; Blender's own mathutils agrees about angles."""
    from petzval.dataset import camera_files, pose_files, poses
    from petzval.dataset.cameras import Intrinsics

    chance = np.random.default_rng(2)
    made = [poses.placed(poses.of_quaternion(tuple(chance.normal(size=4))), chance.normal(size=3)) for _ in range(20)]
    one = Intrinsics("PINHOLE", (100.0, 100.0, 48.0, 32.0), 96, 64)
    views = [camera_files.View(f"pictures/{i:04d}.png", "camera", one, pose, 0.5, 0.0) for i, pose in enumerate(made)]
    camera_files.write_colmap(tmp_path, views, [])
    camera_files.write_nerf(tmp_path / "transforms.json", views)
    for file, kind in ((tmp_path / "images.txt", "colmap"), (tmp_path / "transforms.json", "nerf")):
        read = [one.matrix for one in pose_files.read(file, kind, 0.5)]
        assert np.abs(np.array(read) - made).max() < 1e-12, kind
    camera_files.write_kitti(tmp_path, views)
    read = np.array([one.matrix for one in pose_files.read(tmp_path / "poses.txt", "kitti", 0.5)])
    # The first one's axes become the world's; from one to the other the way is the same.
    assert np.abs(np.linalg.inv(read[0]) @ read - np.linalg.inv(made[0]) @ np.array(made)).max() < 1e-12
    assert np.allclose(read[0][:3, :3] @ [0, 0, -1], [0, 1, 0]) and np.allclose(read[0][:3, :3] @ [0, 1, 0], [0, 0, 1])


def test_angles_are_blenders(blender):
    from mathutils import Euler, Quaternion

    from petzval.dataset import poses

    for x, y, z in np.random.default_rng(3).uniform(-170, 170, (20, 3)):
        theirs = np.array(Euler(np.radians([x, y, z]), "XYZ").to_matrix())
        assert np.abs(poses.euler_deg((x, y, z)) - theirs).max() < 1e-6
        quaternion = poses.to_quaternion(poses.euler_deg((x, y, z)))
        assert np.abs(np.array(Quaternion(quaternion).to_matrix()) - theirs).max() < 1e-6
        assert np.abs(poses.of_quaternion(quaternion) - theirs).max() < 1e-6
