# SPDX-License-Identifier: GPL-3.0-or-later
"""The computations of `make bench` itself: its scene, its measure of noise, its camera script for Cycles."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import numpy as np
import pytest
from bench import double_gauss, measure, noise, scene

from support.places import ROOT

pytestmark = pytest.mark.once


@pytest.mark.parametrize(("name", "triangles"), [("small", 19_844), ("large", 999_044)])
def test_the_scene_has_the_triangles_that_its_name_says(name, triangles):
    # Twenty bodies of 2 n^2, two squares, 24 icosahedra.
    assert sum(len(one["triangles"]) for one in scene.objects(scene.SIZES[name])) == triangles


def test_bodies_are_closed_and_face_outwards():
    for vertices, triangles in (scene.bumpy_ball(22, 3), scene.bumpy_ring(22, 0.5), scene.icosahedron()):
        edges = np.concatenate([triangles[:, pair] for pair in ((0, 1), (1, 2), (2, 0))])
        there, back = ({tuple(edge) for edge in ends.tolist()} for ends in (edges, edges[:, ::-1]))
        # Each edge is run through once in either direction.
        assert len(there) == len(edges) and there == back
        assert np.linalg.det(vertices[triangles]).sum() > 0.0
        outward = (scene.smooth_normals(vertices, triangles) * _facing(vertices, triangles)).sum(1)
        assert outward.min() > 0.5


def _facing(vertices, triangles):
    """The mean normal of the triangles of each vertex, weighted by their area: another way to a smooth normal."""
    corners = vertices[triangles]
    total = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(total, triangles[:, k], np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    return total / np.linalg.norm(total, axis=1, keepdims=True)


def test_the_scene_is_written_once_and_the_same(tmp_path, monkeypatch):
    monkeypatch.setattr(scene, "SIZES", {"small": scene.SIZES["small"]})
    for folder in ("one", "two"):
        scene.write(tmp_path / folder)
    about, arrays = scene.read(tmp_path / "one" / "small")
    again, same = scene.read(tmp_path / "two" / "small")
    assert about == again and about["triangles"] == sum(len(a) for k, a in arrays.items() if k.endswith(".triangles"))
    assert arrays.keys() == same.keys() and all(np.array_equal(arrays[key], same[key]) for key in arrays)


def test_the_noise_of_a_known_picture_is_found():
    dice = np.random.default_rng(1)
    truth = np.full((200, 200, 3), 0.5)

    def picture(samples):
        # One sample has a relative variance of 0.2; the floor of 1 % takes a ten-thousandth off.
        return truth * (1.0 + dice.normal(scale=np.sqrt(0.2 / samples), size=truth.shape))

    samples, reference_samples = (4, 16, 64), 256
    reference = picture(reference_samples)
    errors = [noise.rel_mse(picture(n), reference, n, reference_samples) for n in samples]
    fitted = noise.fit(samples, errors, [1.0 + 0.03 * n for n in samples])
    # 120,000 numbers give 0.4 %; the trimmed thousandth takes off 0.5 %, the reference's noise as a divisor adds 0.3 %.
    assert fitted.error_samples == pytest.approx(0.2, rel=0.02)
    # The start-up of one second is left out.
    assert fitted.seconds_per_sample == pytest.approx(0.03)
    assert fitted.seconds_to(0.01) == pytest.approx(20 * 0.03, rel=0.02)


def test_a_difference_is_told_from_noise():
    dice = np.random.default_rng(2)
    truth = np.full((200, 200, 3), 0.5)
    halves = [[truth * bright * dice.normal(1.0, 0.03, truth.shape) for _ in range(2)] for bright in (1.05, 1.0)]
    measured, own = noise.difference(*halves)
    # Two pictures, each the mean of two with a variance of 0.03^2. The trimmed thousandth takes off up to 1 %; the noise
    # of the divisor adds a hundredth to the step of 5 %, and so two to its square.
    assert own == pytest.approx(0.5 * 0.03**2 * (1.05**2 + 1.0), rel=0.03)
    assert measured - own == pytest.approx(0.05**2, rel=0.05)


def test_sparks_are_left_out():
    truth = np.full((100, 100, 3), 0.5)
    sparks = truth.copy()
    sparks.reshape(-1, 3)[:10] = 1e6
    assert noise.rel_mse(sparks, truth) == 0.0
    sparks.reshape(-1, 3)[:11] = 1e6
    assert noise.rel_mse(sparks, truth) > 1.0


@pytest.fixture(scope="module")
def lens(petzval_cli):
    path = ROOT / "lenses" / "double-gauss-f2-available.lens"
    arguments = ("--focal-length", 50, "--f-number", 2, "--focus-distance", 2000, "--json")
    info = petzval_cli("lens", "info", path, *arguments)
    return double_gauss.read(path, json.loads(info.stdout))


def test_the_script_for_cycles_focuses_where_petzval_does(lens):
    way = np.array([[1e-4, 0.0, -1.0]])
    place, way, through = double_gauss.trace(lens, np.array([[0.0, 0.0, lens.film_z]]), way / np.linalg.norm(way))
    crosses = place[0, 2] - place[0, 0] / way[0, 0] * way[0, 2]
    assert through.all()
    # The index of the last glass to 1e-7 moves it by some hundredths of a millimetre.
    assert lens.entrance_z - crosses == pytest.approx(2000.0, abs=0.1)


def test_the_script_for_cycles_loses_no_light_by_its_aim(lens, monkeypatch):
    spots = [(0.0, 0.0), (8.0, 3.0), (15.0, 6.0)]
    near = [double_gauss.exposure(lens, *spot)[0] * double_gauss.AIM**2 for spot in spots]
    monkeypatch.setattr(double_gauss, "AIM", 1.3)
    wide = [double_gauss.exposure(lens, *spot)[0] * 1.3**2 for spot in spots]
    # 20,000 even points find the area of a pupil to some thousandths.
    assert near == pytest.approx(wide, rel=5e-3)


def test_places_have_what_the_page_says():
    script = """
import bpy, json
from bench import places
found = {}
for name, make in places.MAKERS.items():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    make()
    shown = [one.instance_object or one.object for one in bpy.context.evaluated_depsgraph_get().object_instances]
    kinds = [one.data.name.rstrip("0123456789") for one in shown if one.data is not None]
    found[name] = {kind: kinds.count(kind) for kind in set(kinds)}
    found[name]["fog"] = any(n.type == "VOLUME_SCATTER" for n in bpy.context.scene.world.node_tree.nodes)
    assert bpy.context.scene.camera is not None
print("FOUND" + json.dumps(found))
"""
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, env=os.environ | {"PYTHONPATH": str(ROOT / "tools")}
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout[done.stdout.index("FOUND") + 5 :].splitlines()[0])
    meadow, room, night = (found[name] for name in ("meadow", "room", "night"))
    # A cluster stands in the scene as it is besides, where Blender does not hide it.
    assert 120_000 <= meadow["grass"] * 30 <= 120_100 and 3000 <= meadow["leaf"] <= 3002 and meadow["sun"] == 1
    assert room["thing"] == 8 and room["sun"] == 1 and not room["fog"]
    assert night["lamp"] == 70 and night["house"] == 16 and night["fog"]


def test_a_place_is_measured_as_known_pictures_say(tmp_path):
    dice = np.random.default_rng(4)

    def rounds(variance, seconds):
        made = []
        for turn in range(12):
            pictures = []
            for i in range(2):
                file = tmp_path / f"{variance}-{turn}-{i}.npy"
                np.save(file, 0.5 * (1.0 + np.sqrt(variance) * dice.normal(size=(40, 50, 1)) * np.ones(3)))
                pictures.append({"user_s": seconds, "file": str(file)})
            made.append([{"user_s": 1.0}, *pictures])
        return made

    found = measure.beside(rounds(0.02, 3.0), rounds(0.04, 5.0), 101, (50, 40))
    assert found["petzval_us"] == pytest.approx(10.0) and found["cycles_us"] == pytest.approx(20.0)
    # 24 pictures of 2000 pixels: a variance is known to 1 %.
    assert found["noise"] == pytest.approx(0.5, rel=0.05) and found["time"] == pytest.approx(0.25, rel=0.05)
    assert found["mean"] == pytest.approx(1.0, abs=0.01)
