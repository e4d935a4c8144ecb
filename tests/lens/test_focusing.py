# SPDX-License-Identifier: GPL-3.0-or-later
"""Focus found rather than set, and what focus distances count from: command line, panel and bridge."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from math import degrees, tan

import numpy as np
import pytest

from petzval import _native
from petzval.description import Focusing
from support.photograph import native
from support.photograph.chart import LENSES
from support.places import ROOT, TESTS

TRIPLET = LENSES / "cooke-triplet-50mm.lens"

MAKE = """
import os, sys
sys.path.insert(0, {tests!r})
import bpy
import petzval
bpy.ops.wm.read_factory_settings(use_empty=True)
petzval.load_addon().register()
from support import scenes as parts
scene = parts.set_up(48, 32, 1)
parts.square("Square", (0.1, 5, 0.2), 0.6, parts.emitter((1.0, 0.5, 0.2), 2.0))
bpy.ops.wm.save_as_mainfile(filepath={path!r})
sys.stdout.flush()
os._exit(0)
"""


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """A square five metres in front of the camera, which looks along +y; nothing else."""
    pytest.importorskip("bpy")
    path = tmp_path_factory.mktemp("focusing") / "scene.blend"
    script = MAKE.format(tests=str(TESTS), path=str(path))
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False, timeout=60)
    assert path.exists(), done.stdout + done.stderr
    return path


@pytest.fixture
def focus(petzval_cli, scene, tmp_path):
    """`focus(options...)`: the finished process and its statistics."""

    def run(*options):
        stats = tmp_path / "stats.json"
        done = petzval_cli("render", scene, *options, "-o", tmp_path / "out.exr", "--stats", stats)
        return done, json.loads(stats.read_text()) if stats.exists() else None

    return run


@pytest.mark.once
@pytest.mark.parametrize("anchor", ["entrance-pupil", "front-vertex", "film"])
def test_autofocus_looks_where_it_is_told(focus, anchor):
    lens = ("--lens", TRIPLET, "--f-number", 11, "--anchor", anchor)
    done, stats = focus(*lens, "--autofocus", "0.5,0.5")
    assert done.returncode == 0, done.stderr
    found = stats["autofocus"]
    assert found["subject_world"][1] == pytest.approx(5.0, abs=1e-4)
    # Newton: aberrations and colours move the film by a tenth of a millimetre at most, a third of what f/11 lets pass.
    assert abs(50.0**2 * (1.0 / found["focus_scale_mm"] - 1.0 / 5000.0)) < 0.1
    done, stats = focus(*lens, "--autofocus", "0.02,0.98")
    assert done.returncode == 0, done.stderr
    assert stats["autofocus"]["subject_world"] is None


@pytest.mark.once
def test_a_zoom_focuses_by_its_groups(focus):
    lens = ("--lens", "zoom-nikon-57-143-f2.8", "--anchor", "front-vertex", "--spectrum", 587.56)
    done, stats = focus(*lens, "--focal-length", 100, "--f-number", 11, "--autofocus", "0.5,0.5")
    assert done.returncode == 0, done.stderr
    found = stats["autofocus"]
    assert found["moves_groups"]
    # Counted from the front, which stands in the camera; spherical aberration takes its part.
    assert found["focus_scale_mm"] == pytest.approx(5000.0, rel=0.01)
    zoom = ROOT / "lenses/zoom-nikon-57-143-f2.8.lens"
    far = native.camera(zoom, focal_length_mm=100.0, focus_distance=None, wavelength_nm=587.56)
    far = native.info(far, 48, 32)
    # Blender keeps the wavelength in single precision.
    assert found["film_distance_mm"] == pytest.approx(far["film_distance_mm"], abs=1e-6)
    assert far["zoom_range_mm"] == [57.21, 143.08] and far["focuses_inside"]
    for options, word in ((("--focal-length", 200), "57.2 to 143.1"), (("--focus-distance", 0.5), "too close")):
        done, _ = focus(*lens, *options)
        assert done.returncode == 1 and word in done.stderr, done.stderr


@pytest.mark.once
def test_three_points_turn_the_film_as_scheimpflug_says(focus):
    """Object plane, lens and film meet in a line: here 2.5 m below the axis, for the plane is y = 5 + 2 z."""
    # Equally far from the axis as the lens sees them, so that field curvature moves all three alike.
    points = ("-0.08,4.9,-0.05", "0.08,4.9,-0.05", "0,5.2,0.1")
    done, stats = focus("--lens", TRIPLET, "--f-number", 16, "--sharp", *points)
    assert done.returncode == 0, done.stderr
    found = stats["sharp"]
    film_mm = json.loads(_native.Lens(str(TRIPLET)).info_json())["efl_mm"] * 5.0 / 4.95
    # The places of the lens's own planes, some millimetres, are left out of 2.5 m here.
    assert 2500.0 * tan(found["tilt_rad"]) == pytest.approx(film_mm, rel=0.02)
    assert abs(degrees(found["swing_rad"])) < 0.01
    assert 0.0 < found["rms_spot_mm"] < 0.05


@pytest.mark.once
def test_what_cannot_be_focused_is_refused(focus):
    for options, word in (
        (("--lens", TRIPLET, "--sharp", "0,1,0", "0,2,0", "0,3,0"), "line"),
        (("--lens", TRIPLET, "--sharp", "0,-1,0", "1,2,0", "0,3,1"), "sharp point 1"),
        (("--camera", "pinhole", "--autofocus", "0.5,0.5"), "lens"),
    ):
        done, _ = focus(*options)
        assert done.returncode == 1, done.stderr
        assert done.stderr.startswith("petzval: ") and done.stderr.count("\n") == 1 and word in done.stderr, done.stderr


@pytest.mark.once
@pytest.mark.parametrize(
    "options",
    [
        ("--autofocus", "1.5,0"),
        ("--autofocus", "0.5"),
        ("--sharp", "0,1,0", "0,2,0"),
        ("--sharp", "0,1,0", "0,2,0", "1,2", "--f-number", "8"),
        ("--sharp", "0,1,0", "0,2,0", "1,2,0", "--tilt", "3"),
        ("--autofocus", "0.5,0.5", "--focus-distance", "1000"),
        ("--anchor", "nose"),
    ],
)
def test_bad_usage(petzval_cli, scene, options):
    done = petzval_cli("render", scene, *options)
    assert done.returncode == 2, done.stderr
    assert done.stderr.startswith("petzval: "), done.stderr


@pytest.mark.once
def test_film_and_distance_are_linked_for_each_anchor_and_relation():
    for anchor in ("ENTRANCE_PUPIL", "FRONT_VERTEX", "FILM"):
        for relation in ("EXACT", "THIN"):
            how = {"anchor": anchor, "focus_relation": relation}
            by_distance = native.info(native.camera(TRIPLET, focus_distance=1.2, **how), 48, 32)
            assert by_distance["focus_scale_mm"] == pytest.approx(1200.0, rel=1e-12)
            film = by_distance["film_distance_mm"]
            by_film = native.info(native.camera(TRIPLET, film_distance_mm=film, **how), 48, 32)
            assert by_film["focus_scale_mm"] == pytest.approx(1200.0, rel=1e-9)
    for wrong in ({"anchor": "NOSE"}, {"focus_relation": "THICK"}):
        with pytest.raises(_native.PetzvalError, match="unknown variant .*expected"):
            native.info(native.camera(TRIPLET, **wrong), 48, 32)


def test_the_panels_settings_reach_the_engine(blender):
    from support import scenes

    scene = scenes.set_up(model="LENS")
    own = scene.camera.data.petzval
    own.lens_file, own.focus_mode = str(TRIPLET), "AUTO"
    own.anchor, own.focus_relation, own.autofocus_point = "FILM", "THIN", (0.25, 0.75)
    report = scenes.part("export.report").Report()
    sent = scenes.part("export.camera").describe(scene.camera, scene, 48, 32, report)
    assert sent.focus.focusing == Focusing("FILM", "THIN") and sent.focus.autofocus == (0.25, 0.75)
    own.focus_mode, own.model = "CAMERA", "THIN"
    sent = scenes.part("export.camera").describe(scene.camera, scene, 48, 32, report)
    assert sent.focus.focusing == Focusing() and sent.focus.autofocus is None


@pytest.mark.once
def test_a_scene_is_looked_at_through_the_lens():
    """The picture is not turned: what lies to the right, nearer, is found at the right."""
    builder = _native.SceneBuilder()
    triangles = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
    for name, x, depth in (("Left", -1.0, 6.0), ("Right", 1.0, 4.0)):
        corners = [(x - 0.9, -2.0, -depth), (x + 0.9, -2.0, -depth), (x + 0.9, 2.0, -depth), (x - 0.9, 2.0, -depth)]
        mesh = builder.add_mesh(name, np.array(corners, np.float32), triangles)
        builder.add_instance(name, mesh, native.IDENTITY, [])
    stage = builder.build((0.0, 0.0, 0.0))
    for x, depth in ((0.35, 6.0), (0.65, 4.0)):
        camera = native.camera(os.fspath(TRIPLET), f_number=8.0)
        found = json.loads(_native.autofocus_json(stage, camera, 48, 32, (x, 0.5)))
        assert -found["subject_world"][2] == pytest.approx(depth, rel=1e-5)
        sharp = native.info(native.camera(TRIPLET, film_distance_mm=found["film_distance_mm"]), 48, 32)
        assert sharp["focus_scale_mm"] == pytest.approx(found["focus_scale_mm"], rel=1e-6)
