# SPDX-License-Identifier: GPL-3.0-or-later
"""What `petzval dataset` writes of a scene fits together: places, depth, normals, flow and camera parameters, by the equations of the
programs that read them."""

from __future__ import annotations

import json

import numpy as np
import pytest

from support import dataset_scene as scene
from support.render_commands import many

SPEC = """
scene = "scene.blend"
output = "{name}"
frames = {frames}
[path]
object = "Camera"
{camera}
[render]
resolution = [96, 64]
threads = 1
[labels]
rays = "centre"
[classes.box]
objects = ["Box.*"]
[write]
depth = "exr"
normal = "exr"
position = "exr"
instances = true
flow = "flo"
flow-directions = ["forward", "backward"]
cameras = ["colmap", "nerf", "kitti"]
points = 30
"""

CAMERAS = {
    "pinhole": '[camera]\ncamera = "pinhole"\nfocal-length = 30',
    "lens": '[camera]\nlens = "wide-angle-smith-f3.4"\nfilm = "lens"\nf-number = 8\nfocus-distance = 6000',
    "rig": '[[camera]]\nname = "left"\ncamera = "pinhole"\n[[camera]]\nname = "right"\ncamera = "pinhole"\nlocation = [0.3, 0, 0]\nrotation = [0, -5, 0]',
}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The folder with the data sets of all cameras, made by the command."""
    pytest.importorskip("bpy")
    folder = tmp_path_factory.mktemp("dataset")
    scene.save(folder / "scene.blend")
    for name, camera in CAMERAS.items():
        # Every other frame: flow leads over two.
        frames = '"1-3"' if name == "lens" else '"1-5,2"'
        (folder / f"{name}.toml").write_text(SPEC.format(name=name, camera=camera, frames=frames))
    for done in many([["dataset", folder / f"{name}.toml"] for name in CAMERAS], folder):
        assert done.returncode == 0, done.stderr
        assert done.stderr == ""
    return folder


def tolerance_px(one: dict) -> float:
    """The filter is a hundredth of a pixel wide; single precision of places of some metres, 1e-6 of them, is far below. With a lens, what
    is said of the fit, what its opening of f/100 blurs (0.2 mm, seen over 3 m by 70 pixels a radian), and as much for its entrance pupil, which
    moves off the axis."""
    fit = one["intrinsics"]["fit_largest_px"]
    return 0.012 if one["intrinsics"]["model"] == "PINHOLE" else 0.012 + fit + 0.01


@pytest.mark.parametrize("name", CAMERAS)
def test_places_are_shown_in_their_pixels(blender, made, name):
    folder = made / name
    by_colmap = scene.colmap(folder / "colmap" / "sparse" / "0")
    nerf = json.loads((folder / "transforms.json").read_text())
    told = scene.records(folder)
    assert len(told) == len(by_colmap) == len(nerf["frames"]) == 3 * (2 if name == "rig" else 1)
    for one, frame in zip(told, nerf["frames"], strict=True):
        places = scene.numbers(folder / one["files"]["position"], 3).astype(float)
        hits = places.any(axis=-1)
        assert 0.2 < hits.mean() < 1.0
        model, parameters, to_camera = by_colmap[f"{one['name']}.png"]
        seen = places @ to_camera[:, :3].T + to_camera[:, 3]
        off = scene.distorted(model, parameters, seen) - scene.pixels(*hits.shape)
        assert np.abs(off[hits]).max() < tolerance_px(one), name
        # NeRF: camera to world, the view along -z.
        inverse = np.linalg.inv(np.array(frame["transform_matrix"]))
        own = (places @ inverse[:3, :3].T + inverse[:3, 3]) * [1, -1, -1]
        assert np.abs(own - seen)[hits].max() < 1e-5
        k = nerf if "fl_x" in nerf else frame
        assert [k["fl_x"], k["fl_y"], k["cx"], k["cy"]] == parameters[:4]
        # Depth along the axis is the third coordinate.
        depth = scene.numbers(folder / one["files"]["depth"])
        assert np.abs(depth - seen[..., 2])[hits].max() < 1e-4
        assert (depth[~hits] == 1e10).all()


@pytest.mark.parametrize("name", ["pinhole", "rig"])
def test_kitti_projects_from_the_first_camera(blender, made, name):
    """P_i shows points of the first camera's space; poses lead from a camera to the first one at its first frame."""
    folder = made / name
    lines = (line.split(":") for line in (folder / "kitti" / "calib.txt").read_text().splitlines())
    calib = {key: np.array(words.split(), float).reshape(3, 4) for key, words in lines}
    told = scene.records(folder)
    first = np.array(told[0]["camera_to_world"]) @ np.diag([1, -1, -1, 1])
    cameras = list(dict.fromkeys(one["camera"] for one in told))
    # The rig is stiff: its first camera's pose places them all.
    end = "" if len(cameras) == 1 else f"_{cameras[0]}"
    poses = np.loadtxt(folder / "kitti" / f"poses{end}.txt").reshape(-1, 3, 4)
    assert np.allclose(poses[0], np.eye(4)[:3], atol=1e-9)
    for one in told:
        number = [t for t in told if t["camera"] == one["camera"]].index(one)
        places = scene.numbers(folder / one["files"]["position"], 3).astype(float)
        hits = places.any(axis=-1)
        in_first = (places - first[:3, 3]) @ first[:3, :3]
        in_rig = (in_first - poses[number][:, 3]) @ poses[number][:, :3]
        shown = np.append(in_rig, np.ones((*hits.shape, 1)), -1) @ calib[f"P{cameras.index(one['camera'])}"].T
        # KITTI counts from the middle of the first pixel.
        off = shown[..., :2] / shown[..., 2:] - (scene.pixels(*hits.shape) - 0.5)
        assert np.abs(off[hits]).max() < 0.012


def boxes_normal(places: np.ndarray, centre: np.ndarray, turn: float, half: float) -> np.ndarray:
    """Normals of a box that is turned about z, by the face on which each place lies."""
    c, s = np.cos(turn), np.sin(turn)
    axes = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    own = (places - centre) @ axes.T / half
    face = np.abs(own).argmax(axis=-1)
    return axes[face] * np.sign(np.take_along_axis(own, face[..., None], -1))


def test_normals_of_a_box(blender, made):
    folder = made / "pinhole"
    rows = {row["object"]: row["id"] for row in json.loads((folder / "instances.json").read_text())["instances"]}
    for one in scene.records(folder):
        places = scene.numbers(folder / one["files"]["position"], 3).astype(float)
        ids = scene.numbers(folder / one["files"]["instances"])
        inside = ids == rows["Box.A"]
        assert inside.sum() > 100
        x = box_x(one["frame"])
        expected = boxes_normal(places[inside], np.array([x, 6, 0]), x / 3, 1.0)
        turn = np.array(one["camera_to_world"])[:3, :3] @ np.diag([1, -1, -1])
        normal = scene.numbers(folder / one["files"]["normal"], 3)[inside] @ turn.T
        assert np.abs(normal - expected).max() < 1e-4


def box_x(frame: int) -> float:
    """The x of Box.A by the curve of its two keys, Blender's default: a cubic whose handles are a third of the way, level."""
    t = (frame - 1) / 10
    # With level handles at thirds the time is linear in the curve's parameter.
    return 3.0 * (3 * t**2 - 2 * t**3)


@pytest.mark.parametrize("name", ["pinhole", "rig", "lens"])
def test_flow_leads_to_where_the_same_place_is(blender, made, name):
    """Places at one frame, carried to the next by closed forms, are shown there where flow says: backward likewise."""
    folder = made / name
    by_colmap = scene.colmap(folder / "colmap" / "sparse" / "0")
    told = scene.records(folder)
    rows = {row["id"]: row["object"] for row in json.loads((folder / "instances.json").read_text())["instances"]}
    compared = 0
    for one in told:
        places = scene.numbers(folder / one["files"]["position"], 3).astype(float)
        ids = scene.numbers(folder / one["files"]["instances"])
        hits = ids > 0
        own = [other for other in told if other["camera"] == one["camera"]]
        number = own.index(one)
        for direction, step in (("forward", 1), ("backward", -1)):
            kind = f"flow_{direction}"
            if not 0 <= number + step < len(own):
                assert kind not in one["files"]
                continue
            then = own[number + step]
            carried = places.copy()
            box = ids == next(key for key, value in rows.items() if value == "Box.A")
            x0, x1 = box_x(one["frame"]), box_x(then["frame"])
            turn = (x1 - x0) / 3
            about = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
            carried[box] = (places[box] - [x0, 6, 0]) @ about.T + [x1, 6, 0]
            model, parameters, now = by_colmap[f"{one['name']}.png"]
            _, _, to_camera = by_colmap[f"{then['name']}.png"]
            before = scene.distorted(model, parameters, places @ now[:, :3].T + now[:, 3])
            after = scene.distorted(model, parameters, carried @ to_camera[:, :3].T + to_camera[:, 3])
            flow = scene.flow(folder / one["files"][kind])
            # Beyond the picture a fit says nothing; rays that the lens loses are few, and said to be unknown.
            stays = hits & ((after > 0) & (after < [hits.shape[1], hits.shape[0]])).all(axis=-1)
            is_known = np.abs(flow).max(axis=-1) < 1e9
            assert is_known[hits].mean() > (0.99 if name == "lens" else 1.0 - 1e-9)
            off = np.abs(flow - (after - before)).max(axis=-1)[(stays if name == "lens" else hits) & is_known]
            assert np.abs(after - before)[hits].max() > 1.0
            # Single precision of ways of some pixels. What a lens's fit leaves is nearly the same at both ends of a way; of a ray that the lens
            # loses on the way the engine goes a part and makes it longer, which is short by some hundredths.
            if name == "lens":
                way = np.abs(after - before).max(axis=-1)[stays & is_known]
                assert np.quantile(off, 0.99) < 0.002 and (off < 0.005 + 0.02 * way).all(), (one["name"], direction)
            else:
                assert off.max() < 2e-4, (name, one["name"], direction)
            compared += 1
    assert compared == (8 if name == "rig" else 4)
