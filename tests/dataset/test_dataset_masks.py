# SPDX-License-Identifier: GPL-3.0-or-later
"""Masks of `petzval dataset` beside Cycles, COCO's annotations decoded by their page, pictures that go on after a kill."""

from __future__ import annotations

import hashlib
import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from support import dataset_scene as scene
from support.places import ROOT

SPEC = """
scene = "scene.blend"
output = "{output}"
[[pose]]
location = [0, 0, 0.5]
target = [0, 6, 0]
[[pose]]
location = [1.5, 1, 1.5]
target = "Box.B"
[[pose]]
location = [-2, 0, 2]
rotation = [75, 0, -20]
[camera]
camera = "pinhole"
[render]
resolution = [96, 64]
threads = 1
samples = 2
seed = 3
[classes.box]
objects = ["Box.A"]
[classes.blue]
property = "kind=blue"
id = 9
[classes.small]
objects = ["Small"]
[classes.missing]
objects = ["Nothing*"]
[write]
picture = "exr"
depth = "png"
instances = true
classes = true
flow = "off"
coco = "{coco}"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    pytest.importorskip("bpy")
    folder = tmp_path_factory.mktemp("masks")
    scene.save(folder / "scene.blend")
    for coco in ("rle", "polygons"):
        (folder / f"{coco}.toml").write_text(SPEC.format(output=coco, coco=coco))
    return folder


@pytest.fixture(scope="module")
def made(folder, petzval_cli):
    for name in ("rle", "polygons"):
        done = petzval_cli("dataset", folder / f"{name}.toml")
        assert done.returncode == 0, done.stderr
        # Said by name, once.
        assert done.stderr.count("\n") == 1 and "classes.missing: objects 'Nothing*'" in done.stderr
    return folder


def test_instances_are_those_of_cycles(blender, made, tmp_path):
    """Each object with an index of its own, as Cycles has them at the same places: away from edges all pixels agree. Two instances of one
    object, which share Cycles' index, are two."""
    folder = made / "rle"
    bpy = blender
    bpy.ops.wm.open_mainfile(filepath=str(made / "scene.blend"))
    rows = json.loads((folder / "instances.json").read_text())["instances"]
    index = {}
    for number, name in enumerate(("Floor", "Box.A", "Box.B", "Small"), 1):
        bpy.data.objects[name].pass_index = index[name] = number
    now = bpy.context.scene
    now.render.engine, now.cycles.samples, now.cycles.device = "CYCLES", 1, "CPU"
    now.view_layers[0].use_pass_object_index = True
    now.render.resolution_x, now.render.resolution_y = 96, 64
    from mathutils import Matrix

    from support import render_passes

    small = [row["id"] for row in rows if row["object"] == "Small"]
    assert len(small) == 2
    for one in scene.records(folder):
        now.camera.animation_data_clear()
        now.camera.matrix_world = Matrix(one["camera_to_world"])
        bpy.context.view_layer.update()
        theirs = np.flipud(render_passes.photograph(tmp_path / "c.exr", "CYCLES", samples=1)["Object Index"][..., 0])
        ids = scene.numbers(folder / one["files"]["instances"])
        table = np.array([0] + [index[row["object"]] for row in rows])
        ours = table[ids]
        edges = np.zeros(ids.shape, bool)
        for axis in (0, 1):
            for step in (-1, 1):
                edges |= np.roll(ours, step, axis) != ours
        assert (~edges).mean() > 0.8
        assert (ours == theirs)[~edges].all()
        assert set(small) <= set(np.unique(ids)) or one["name"] != "0000"
        by_class = scene.numbers(folder / one["files"]["classes"])
        expected = {"Box.A": 1, "Box.B": 9, "Small": 10}
        names = np.array(["", *(row["object"] for row in rows)])[ids]
        assert (by_class == np.vectorize(expected.get)(names, 0)).all()


def decoded(segmentation: dict) -> np.ndarray:
    """COCO's compressed run lengths by the text of its interface's C code, rleFrString."""
    counts, text, at = [], segmentation["counts"], 0
    while at < len(text):
        x, k, more = 0, 0, True
        while more:
            c = ord(text[at]) - 48
            x |= (c & 0x1F) << (5 * k)
            more = bool(c & 0x20)
            at, k = at + 1, k + 1
            if not more and c & 0x10:
                x |= -1 << (5 * k)
        counts.append(x + counts[-2] if len(counts) > 2 else x)
    flat = np.repeat(np.arange(len(counts)) % 2, counts)
    height, width = segmentation["size"]
    return flat.reshape(width, height).T.astype(bool)


def filled(polygons: list[list[int]], shape: tuple[int, int]) -> np.ndarray:
    """The pixels whose middles lie in polygons: an odd number of edges to their left."""
    rows, columns = np.indices(shape)
    inside = np.zeros(shape, bool)
    for flat in polygons:
        own, points = np.zeros(shape, bool), np.reshape(flat, (-1, 2))
        for (x0, y0), (x1, y1) in zip(points, np.roll(points, -1, axis=0), strict=True):
            assert x0 == x1 or y0 == y1
            own ^= (x0 == x1) & (columns + 0.5 > x0) & (rows + 0.5 > min(y0, y1)) & (rows + 0.5 < max(y0, y1))
        inside |= own
    return inside


@pytest.mark.parametrize("form", ["rle", "polygons"])
def test_coco_says_what_the_masks_say(blender, made, form):
    folder = made / form
    told = json.loads((folder / "annotations.json").read_text())
    assert {one["name"]: one["id"] for one in told["categories"]} == {"box": 1, "blue": 9, "small": 10, "missing": 11}
    assert [one["id"] for one in told["annotations"]] == list(range(1, len(told["annotations"]) + 1))
    masks = {one["name"]: scene.numbers(folder / one["files"]["instances"]) for one in scene.records(folder)}
    seen = 0
    for image in told["images"]:
        ids = masks[Path(image["file_name"]).stem]
        assert (folder / "pictures" / image["file_name"]).exists()
        assert ids.shape == (image["height"], image["width"])
        for one in told["annotations"]:
            if one["image_id"] != image["id"]:
                continue
            mask = ids == one["instance_id"]
            own = one["segmentation"]
            shape = decoded(own) if form == "rle" else filled(own, mask.shape)
            assert (shape == mask).all()
            rows, columns = np.nonzero(mask)
            assert one["bbox"] == [columns.min(), rows.min(), np.ptp(columns) + 1, np.ptp(rows) + 1]
            assert (one["area"], one["iscrowd"]) == (mask.sum(), 0)
            seen += 1
    assert seen == len(told["annotations"]) >= 6


def test_outlines_of_hard_shapes():
    """Corners that touch, holes and borders: the outlines cover what the mask does, holes filled."""
    from petzval.dataset import coco

    chance = np.random.default_rng(1)
    for _ in range(50):
        mask = chance.random((7, 9)) < 0.6
        runs = {"size": [7, 9], "counts": coco.packed(coco.run_lengths(mask))}
        assert (decoded(runs) == mask).all()
        shape = filled(coco.polygons(mask), mask.shape)
        assert shape[mask].all()
        # What is covered beside is shut in by the mask: no way leads out of it along sides.
        outside = np.pad(~mask, 1, constant_values=True)
        reached = np.zeros_like(outside)
        reached[0, 0] = True
        for _ in range(mask.size):
            spread = (
                reached
                | np.roll(reached, 1, 0)
                | np.roll(reached, -1, 0)
                | np.roll(reached, 1, 1)
                | np.roll(reached, -1, 1)
            )
            reached = spread & outside
        assert not (shape & reached[1:-1, 1:-1]).any()


def files_of(folder: Path) -> dict[str, str]:
    """Hashes of all files by their names."""
    return {
        str(file.relative_to(folder)): hashlib.sha256(file.read_bytes()).hexdigest()
        for file in sorted(folder.rglob("*"))
        if file.is_file()
    }


def test_a_killed_data_set_goes_on_with_the_same_bits(made, petzval_cli):
    """Killed after its first picture, it renders the others alone, and all files are those of a run without a kill."""
    (made / "killed.toml").write_text(SPEC.format(output="killed", coco="rle"))
    process = subprocess.Popen(
        [sys.executable, "-m", "petzval", "dataset", made / "killed.toml"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, cwd=ROOT
    )  # fmt: skip
    for line in process.stdout:
        if line.startswith("0000: written"):
            break
    process.send_signal(signal.SIGKILL)
    process.wait()
    there = made / "killed" / "records" / "0000.json"
    assert there.exists() and not (made / "killed" / "annotations.json").exists()
    before = there.stat().st_mtime_ns
    done = petzval_cli("dataset", made / "killed.toml", "--dry-run")
    assert "0000: frame 1, camera camera at 0, 0, 0.5: there" in done.stdout
    done = petzval_cli("dataset", made / "killed.toml")
    assert done.returncode == 0 and there.stat().st_mtime_ns == before
    assert "0000: written" not in done.stdout and "0002: written" in done.stdout
    same, again = files_of(made / "rle"), files_of(made / "killed")
    assert again == same
    # A picture with a damaged file is not taken for whole.
    (made / "killed" / "depth" / "0001.png").write_bytes(b"half")
    done = petzval_cli("dataset", made / "killed.toml")
    assert "0001: written, 1 of 1" in done.stdout
    assert files_of(made / "killed") == same


def test_ctrl_c_keeps_what_is_whole(made):
    """The first picture stays, is told of, and the status is that of a command that was broken off."""
    text = SPEC.format(output="stopped", coco="rle").replace("samples = 2", "samples = 20000")
    (made / "stopped.toml").write_text(
        text.replace("[96, 64]", "[320, 200]").replace('picture = "exr"', 'picture = "png"')
    )
    process = subprocess.Popen(
        [sys.executable, "-m", "petzval", "dataset", made / "stopped.toml"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT
    )  # fmt: skip
    for line in process.stdout:
        if "0 of 3 pictures are there" in line:
            break
    time.sleep(1.5)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "broken off: 0 of 3 pictures are whole; the same command goes on" in said
    assert not list((made / "stopped" / "pictures").glob("*")) if (made / "stopped" / "pictures").exists() else True
    assert not list((made / "stopped" / ".work").glob("*"))
