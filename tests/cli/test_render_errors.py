# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval render`: bad usage, and what cannot be rendered, said in one line."""

from __future__ import annotations

import json

import pytest

from support.places import REFERENCE
from support.render_commands import one_line

BAD_USAGE = {
    "no scene": [],
    "both": ["S", "--lens", "cooke-triplet-50mm", "--camera", "pinhole"],
    "unknown option": ["S", "--colour", "red"],
    "not a number": ["S", "--f-number", "wide"],
    "nan": ["S", "--focal-length", "nan"],
    "negative": ["S", "--focal-length", "-50"],
    "zero samples": ["S", "--samples", "0"],
    "huge samples": ["S", "--samples", "99999999999999"],
    "size": ["S", "--resolution", "100"],
    "film": ["S", "--film", "no-such-film"],
    "pair": ["S", "--shift", "1,2,3"],
    "effect": ["S", "--effect", "rainbows=on"],
    "effect word": ["S", "--effect", "ghosts=maybe"],
    "camera": ["S", "--camera", "camera-obscura"],
    "pipeline": ["S", "--pipeline", "oil"],
    "integrator": ["S", "--integrator", "photon"],
    "frame": ["S", "--frame", "first"],
}


@pytest.mark.once
@pytest.mark.parametrize("case", BAD_USAGE)
def test_bad_usage(petzval_cli, cli_scenes, case):
    done = petzval_cli("render", *(cli_scenes / "scene.blend" if word == "S" else word for word in BAD_USAGE[case]))
    assert done.returncode == 2, done.stderr
    assert one_line(done)


ERRORS = {
    "no such scene": (["nowhere.blend"], "nowhere.blend"),
    "no such lens": (["S", "--lens", "no-such"], "no such lens: no-such"),
    "a folder": (["S", "-o", "no/such/folder/a.png"], "no such folder"),
    "a format": (["S", "-o", "a.jpg"], ".exr or .png"),
    "blades": (["S", "--blades", "2"], "2 blades"),
    "light paths without a lens": (["S", "--camera", "pinhole", "--integrator", "bdpt"], "choose the lens as camera"),
    "stretched axes": (
        ["S", "--lens", "cooke-triplet-50mm", "--scale", "1000,1000,2000", "--integrator", "bdpt"],
        "one scale for all three axes",
    ),
    "no such Blender": (["S", "--blender", "no-such-blender"], "no-such-blender"),
    "a Blender that is none": (["S", "--blender", "/bin/false"], "/bin/false"),
    "one that does nothing": (["S", "--blender", "/bin/true"], "/bin/true"),
    "effect": (["S", "--lens", "cooke-triplet-50mm", "--effect", "spectral_materials=on"], "spectral_materials=on"),
    "no camera": (["N", "--camera", "pinhole"], "no camera"),
    "no blend": (["T"], "cannot open"),
}


@pytest.mark.first_only("case")
@pytest.mark.parametrize("case", ERRORS)
def test_errors(petzval_cli, cli_scenes, tmp_path, case):
    words, wanted = ERRORS[case]
    (tmp_path / "text.blend").write_text("this is no scene")
    names = {"S": cli_scenes / "scene.blend", "N": cli_scenes / "no-camera.blend", "T": tmp_path / "text.blend"}
    output = [] if "-o" in words else ["-o", tmp_path / "out.png"]
    done = petzval_cli("render", *(names.get(word, word) for word in words), *output)
    assert done.returncode == 1, done.stderr
    assert wanted in one_line(done)


@pytest.mark.once
def test_a_mask_that_is_no_picture_is_said(cli_scenes, petzval_cli, tmp_path):
    (tmp_path / "text.png").write_text("this is no picture")
    done = petzval_cli("render", cli_scenes / "scene.blend", "--camera", "thin", "--aperture-mask", tmp_path / "text.png",
                       "-o", tmp_path / "out.exr")  # fmt: skip
    assert done.returncode == 1
    assert "text.png" in one_line(done)


@pytest.mark.once
def test_a_broken_lens_names_file_line_and_column(petzval_cli, cli_scenes, tmp_path):
    lens = tmp_path / "broken.lens"
    lens.write_text("#radius thickness glass diameter conic isstop\n50 5 BK7 20 0 0\n-50 x air 20 0 1\n")
    done = petzval_cli("render", cli_scenes / "scene.blend", "--lens", lens, "-o", tmp_path / "a.png")
    assert done.returncode == 1
    assert f"{lens}:3:" in one_line(done)


@pytest.mark.once
def test_a_picture_that_cannot_be_written(petzval_cli, cli_scenes):
    done = petzval_cli("render", cli_scenes / "scene.blend", "--samples", 1, "-o", "/proc/out.png")
    assert done.returncode == 1
    assert "/proc/out.png" in one_line(done)


@pytest.mark.once
def test_what_could_not_be_used_of_a_lens_file_is_said_once(petzval_cli, cli_scenes, tmp_path):
    lens, stats = REFERENCE / "foreign" / "cooke.len", tmp_path / "stats.json"
    options = ("--samples", "1", "--resolution", "16x9", "--film", "24x16", "--stats", stats, "-o", tmp_path / "x.png")
    done = petzval_cli("render", cli_scenes / "scene.blend", "--lens", lens, *options)
    assert done.returncode == 0, done.stderr
    said = [note for note in json.loads(stats.read_text())["warnings"] if "cooke.len" in note]
    # The same that `petzval lens check` says: apertures that the file leaves open, glasses of several makers.
    told = [line.removeprefix("petzval: note: ") for line in petzval_cli("lens", "check", lens).stderr.splitlines()]
    assert said == [note for note in told if "cooke.len" in note.split(":")[0] and "known from" not in note]
    assert len(said) == 3 and "cooke.len:11:1: 5 of 6 surfaces have no clear aperture" in said[0]
    assert all(done.stderr.count(note) + done.stdout.count(note) == 1 for note in said)
