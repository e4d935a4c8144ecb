# SPDX-License-Identifier: GPL-3.0-or-later
"""The plan of effects where people meet it: the command line, the statistics, the picture's metadata, the panel's button."""

from __future__ import annotations

import json
import sys

import pytest

LENS = ("--lens", "cooke-triplet-50mm")


@pytest.fixture
def plan(petzval_cli, cli_scenes):
    """`plan(*options)`: what `petzval plan --json` says."""

    def ask(*options):
        done = petzval_cli("plan", cli_scenes / "scene.blend", "--json", *options)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return ask


def row(plan, effect):
    return next(row for row in plan["effects"] if row["effect"] == effect)


def test_everybody_has_the_same_list(blender):
    from petzval import _native, effects

    addon = sys.modules["petzval_addon"]
    known = json.loads(_native.effects_json())
    engine = [effect["name"] for effect in known]
    assert [effect.is_available for effect in effects.EFFECTS] == [effect["is_available"] for effect in known]
    assert [effect.name for effect in effects.EFFECTS] == engine
    assert [word[0].lower() for word in addon.data.effects.WORDS] == list(effects.WORDS)


@pytest.mark.once
def test_a_plan_says_what_the_contract_asks(plan):
    found = plan(*LENS, "--resolution", "96x64")
    for one in found["effects"]:
        assert {"effect", "measure", "unit", "tolerance", "predicted_cost", "decision", "why"} <= set(one)
        assert one["decision"] in {"on", "off"} and one["why"]
    assert found["predicted"]["seconds"] > 0.0
    assert found["camera"]["model"] in {"exact", "gaussian", "pinhole"}
    # A triplet before full-frame film: that much is known of it.
    assert 0.1 < row(found, "vignetting")["measure"] < 3.0
    assert row(found, "vignetting")["unit"] == "stops"


@pytest.mark.once
def test_finer_pictures_call_for_more(plan):
    coarse, fine = (plan(*LENS, "--resolution", size) for size in ("48x32", "1920x1280"))
    assert coarse["camera"]["wavelengths"] == 1 < fine["camera"]["wavelengths"]
    for effect in ("aberration", "distortion", "lateral_colour", "axial_colour"):
        ratio = row(fine, effect)["measure"] / row(coarse, effect)["measure"]
        # Pixels forty times as small.
        assert ratio == pytest.approx(40.0, rel=0.02), effect
    # A bright point beside which it is seen counts, too, from its pixel's edge.
    assert row(fine, "diffraction")["measure"] > 35.0 * row(coarse, "diffraction")["measure"]
    assert row(fine, "vignetting")["measure"] == pytest.approx(row(coarse, "vignetting")["measure"], rel=1e-6)


@pytest.mark.once
def test_quality_and_words_reach_the_plan(plan):
    found = plan(*LENS, "--resolution", "48x32", "--quality", 50, "--effect", "vignetting=off")
    assert row(found, "defocus")["tolerance"] == pytest.approx(0.01)
    assert found["camera"]["wavelengths"] > 1
    assert row(found, "vignetting")["decision"] == "off" and row(found, "vignetting")["word"] == "off"
    assert found["quality"] == 50


@pytest.mark.once
def test_a_plan_for_people_is_a_table(petzval_cli, cli_scenes):
    done = petzval_cli("plan", cli_scenes / "scene.blend", *LENS, "--resolution", "48x32")
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0].split()[:2] == ["effect", "measure"]
    assert any(line.startswith("vignetting") and "stops" in line for line in lines)
    assert any(line.startswith("camera: ") for line in lines)


@pytest.mark.once
@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--quality", "0"), "quality"),
        (("--quality", "5000"), "quality 5000"),
        (("--effect", "spectral_materials=on"), "spectral_materials=on"),
        (("--camera", "pinhole", "--effect", "distortion=on"), "distortion=on"),
    ],
)
def test_what_cannot_be_planned_is_said(petzval_cli, cli_scenes, options, said):
    lens = () if "--camera" in options else LENS
    done = petzval_cli("plan", cli_scenes / "scene.blend", "--json", *lens, *options)
    assert done.returncode in {1, 2} and done.stdout == ""
    assert done.stderr.startswith("petzval: ") and said in done.stderr and done.stderr.count("\n") == 1


@pytest.mark.once
def test_a_render_tells_its_plan(cli_render):
    """In the statistics and in the picture's own metadata; and what was left out was not done."""
    done, out, stats = cli_render(*LENS, "--samples", 2)
    assert done.returncode == 0, done.stderr
    assert {one["effect"]: one["decision"] for one in stats["plan"]}["lateral_colour"] == "off"
    assert stats["pipeline"] == "film" and stats["wavelengths_carried"] == 0
    assert stats["seconds"]["plan"] > 0.0
    told = metadata(out)
    assert told["petzval/effects/lateral_colour"].startswith("off: ")
    assert told["petzval/effects/vignetting"].startswith("on: ")
    assert json.loads(told["petzval/camera"])["wavelengths"] == 1
    done, out, stats = cli_render(*LENS, "--samples", 2, "--effect", "lateral_colour=on", name="colours.exr")
    assert done.returncode == 0, done.stderr
    passed = stats["camera_rays"] - stats["camera_rays_lost"]
    assert stats["pipeline"] == "hero" and stats["wavelengths_carried"] == 8 * passed
    assert metadata(out)["petzval/effects/lateral_colour"].startswith("on: ")


def metadata(path):
    """The attributes of an OpenEXR file that hold text (its header: names, types, sizes)."""
    data = path.read_bytes()
    assert data[:4] == b"\x76\x2f\x31\x01"
    found, at = {}, 8
    while data[at]:
        end = data.index(b"\0", at)
        name, at = data[at:end].decode(), end + 1
        end = data.index(b"\0", at)
        kind, at = data[at:end], end + 1
        size = int.from_bytes(data[at : at + 4], "little")
        if kind == b"string":
            found[name] = data[at + 4 : at + 4 + size].decode()
        at += 4 + size
    return found


def test_the_button_measures(blender):
    from support import scenes

    addon = sys.modules["petzval_addon"]
    scene = scenes.set_up()
    scene.render.engine = "PETZVAL"
    scene.camera.data.petzval.model = "LENS"
    scene.camera.data.petzval.lens_file = "cooke-triplet-50mm.lens"
    scene.petzval.quality = 2.0
    scene.petzval.effects.distortion = "OFF"
    addon.render.planning.forget()
    assert blender.ops.petzval.plan_effects() == {"FINISHED"}
    found = addon.render.planning.last(scene.name)
    assert row(found, "distortion")["decision"] == "off"
    assert row(found, "defocus")["tolerance"] == pytest.approx(0.25)
    texts = [addon.data.effects.size(one) for one in found["effects"]] + [
        addon.data.effects.cost(one) for one in found["effects"]
    ]
    assert all(isinstance(text, str) for text in texts)
    assert "wavelength" in addon.data.effects.summary(found)
    scene.petzval.effects.distortion = "AUTO"
    scene.camera.data.petzval.lens_file = "no-such.lens"
    with pytest.raises(RuntimeError, match="no-such"):
        blender.ops.petzval.plan_effects()
