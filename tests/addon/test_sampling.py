# SPDX-License-Identifier: GPL-3.0-or-later
"""Whose settings say how many samples there are: Cycles' until Petzval's own are set, and what the command line asks for."""

from __future__ import annotations

import json

import numpy as np
import pytest

pytest.importorskip("bpy")


@pytest.fixture
def scene(parts):
    """Finished in Cycles, nothing of Petzval's set, and switched."""
    scene = parts.set_up()
    sampling = parts.part("export.sampling")
    sampling.follow_cycles(scene, sampling.OF_RENDER)
    cycles = scene.cycles
    cycles.samples, cycles.use_adaptive_sampling, cycles.time_limit = 7, False, 50.0
    return scene


def described(parts, scene, **more):
    return parts.part("export.settings").describe(scene, 48, 32, **more)


def stats_of(parts, scene):
    return parts.part("render.statistics").last(scene.name)


# Renders -----------------------------------------------------------------------------------------------------------


def test_a_switched_scene_has_the_samples_set_for_cycles(parts, blender, scene):
    blender.ops.render.render()
    last = stats_of(parts, scene)
    assert last.stats["samples"] == last.stats["samples_mean"] == 7
    assert "sampling as set for Cycles: 7 samples, 50 s" in last.lines()
    scene.cycles.time_limit = 0.0
    scene.petzval.samples = 3
    blender.ops.render.render()
    last = stats_of(parts, scene)
    assert last.stats["samples"] == 3 and not any("Cycles" in line for line in last.lines())


def test_the_time_limit_of_cycles_ends_a_render(parts, blender, scene):
    scene.render.resolution_x, scene.render.resolution_y = 320, 200
    scene.cycles.samples, scene.cycles.time_limit = 1 << 20, 0.3
    blender.ops.render.render()
    assert stats_of(parts, scene).was_late() and 1 <= stats_of(parts, scene).stats["samples"] < 1 << 20


def test_cycles_threshold_with_its_own_rules_for_zeros(parts, scene):
    cycles = scene.cycles
    cycles.use_adaptive_sampling, cycles.samples = True, 1000
    unit = parts.part("export.sampling").CYCLES_THRESHOLD
    # What Cycles says in its log: 0.1 begins to look at 32 samples, 0.01 at 64, 0.001 at 128.
    for threshold, least in ((0.1, 32), (0.01, 64), (0.001, 128)):
        cycles.adaptive_threshold, cycles.adaptive_min_samples = threshold, 0
        found = described(parts, scene)
        assert found.noise_threshold == pytest.approx(unit * threshold) and abs(found.min_samples - least) <= 1
    cycles.adaptive_min_samples = 9
    assert described(parts, scene).min_samples == 9
    cycles.adaptive_threshold = 0.0
    assert described(parts, scene).noise_threshold == pytest.approx(unit * 0.001)
    cycles.samples = 10
    assert described(parts, scene).noise_threshold == pytest.approx(unit * 0.1)
    cycles.use_adaptive_sampling = False
    assert described(parts, scene).noise_threshold == 0.0


def test_a_part_of_the_samples(parts, scene):
    scene.cycles.samples, scene.cycles.use_sample_subset = 100, True
    scene.cycles.sample_offset, scene.cycles.sample_subset_length = 60, 30
    found = described(parts, scene)
    assert (found.sample_offset, found.samples) == (60, 30)
    scene.cycles.sample_subset_length = 50
    assert described(parts, scene).samples == 40
    scene.cycles.use_sample_subset = False
    found = described(parts, scene)
    assert (found.sample_offset, found.samples) == (0, 100)


@pytest.mark.parametrize(
    ("name", "value"), [("samples", 64), ("use_noise_threshold", False), ("time_limit", 0.0), ("sample_offset", 0)]
)
def test_one_own_setting_makes_all_count(parts, scene, name, value):
    """Also at its default: a file that was set up in Petzval renders as before, though Cycles' threshold is on."""
    scene.cycles.use_adaptive_sampling, scene.cycles.samples = True, 7
    setattr(scene.petzval, name, value)
    found = described(parts, scene)
    assert (found.samples, found.noise_threshold, found.min_samples) == (64, 0.0, 0)
    assert parts.part("export.sampling").of_render(scene).time_limit_s == 0.0


def test_a_file_keeps_its_own(parts, blender, scene, tmp_path):
    """As it was saved, beside one that Petzval never touched."""
    scene.cycles.use_adaptive_sampling = True
    paths = {}
    for name in ("never touched", "own"):
        paths[name] = str(tmp_path / f"{name}.blend")
        blender.ops.wm.save_as_mainfile(filepath=paths[name])
        scene.petzval.samples, scene.petzval.preview_samples = 12, 13
    found = {}
    for name, path in paths.items():
        blender.ops.wm.open_mainfile(filepath=path)
        now = blender.context.scene
        found[name] = (
            described(parts, now).samples,
            described(parts, now).noise_threshold > 0.0,
            described(parts, now, is_viewport=True).samples,
        )
    assert found == {"never touched": (7, True, 1024), "own": (12, False, 13)}


# 3D views ----------------------------------------------------------------------------------------------------------


def test_views_have_those_of_cycles_for_views(parts, scene):
    cycles, unit = scene.cycles, parts.part("export.sampling").CYCLES_THRESHOLD
    cycles.preview_samples, cycles.use_preview_adaptive_sampling = 21, True
    cycles.preview_adaptive_threshold, cycles.preview_adaptive_min_samples = 0.2, 5
    found = described(parts, scene, is_viewport=True)
    assert (found.samples, found.min_samples) == (21, 5) and found.noise_threshold == pytest.approx(0.2 * unit)
    cycles.preview_samples, cycles.use_preview_adaptive_sampling = 0, False
    found = described(parts, scene, is_viewport=True)
    assert found.samples > 10_000 and found.noise_threshold == 0.0
    scene.petzval.preview_samples = 33
    assert described(parts, scene, is_viewport=True).samples == 33
    assert described(parts, scene).samples == 7


# The panel ---------------------------------------------------------------------------------------------------------


def test_the_panel_says_whose_they_are_and_changes_it(parts, blender, scene):
    from support import panel_layout as layout

    scene.cycles.use_adaptive_sampling = scene.cycles.use_preview_adaptive_sampling = True
    drawn = layout.draw("render", layout.context())
    assert drawn.said.count("As set for Cycles") == 2 and "petzval.own_sampling" in drawn.operators
    names = ("samples", "adaptive_threshold", "adaptive_min_samples", "time_limit", "preview_samples")
    assert {("CyclesRenderSettings", name) for name in names} <= set(drawn.shown)
    assert ("PetzvalScene", "samples") not in drawn.shown
    before = described(parts, scene), described(parts, scene, is_viewport=True)
    for of in ("RENDER", "VIEW"):
        blender.ops.petzval.own_sampling(of=of)
    drawn = layout.draw("render", layout.context())
    assert "As set for Cycles" not in drawn.said and "petzval.cycles_sampling" in drawn.operators
    assert ("PetzvalScene", "samples") in drawn.shown and ("PetzvalScene", "preview_samples") in drawn.shown
    # What counts stays, to the last bit of single precision; a view's threshold alone has no row of Petzval's own.
    after = described(parts, scene), described(parts, scene, is_viewport=True)
    assert after[0].noise_threshold == pytest.approx(before[0].noise_threshold, rel=1e-6)
    assert (after[0].samples, after[0].min_samples) == (before[0].samples, before[0].min_samples)
    assert after[1].samples == before[1].samples and after[1].noise_threshold == 0.0
    scene.cycles.samples = 99
    assert described(parts, scene).samples == 7
    blender.ops.petzval.cycles_sampling(of="RENDER")
    # Blender's copy for renders knows of it, too.
    assert described(parts, blender.context.evaluated_depsgraph_get().scene_eval).samples == 99


# The command line --------------------------------------------------------------------------------------------------


@pytest.mark.once
def test_the_command_renders_with_what_the_file_has(petzval_cli, blender, parts, scene, tmp_path):
    """And with exactly the samples that it is told, whatever the file says of thresholds, limits and layers."""
    file = tmp_path / "scene.blend"
    scene.render.engine, scene.cycles.time_limit = "CYCLES", 0.0
    blender.ops.wm.save_as_mainfile(filepath=str(file))

    def stats(*arguments) -> dict:
        out = tmp_path / "stats.json"
        done = petzval_cli("render", file, *arguments, "--stats", out, "-o", tmp_path / "out.exr")
        assert done.returncode == 0, done.stderr
        return json.loads(out.read_text())

    plain = stats()
    assert plain["samples"] == 7 and plain["sampling"] == "sampling as set for Cycles: 7 samples"
    scene.cycles.use_adaptive_sampling, scene.cycles.adaptive_threshold = True, 1.0
    scene.cycles.samples, scene.cycles.adaptive_min_samples, scene.cycles.time_limit = 4096, 4, 0.001
    blender.context.view_layer.samples = 3
    blender.ops.wm.save_as_mainfile(filepath=str(file))
    exact = stats("--samples", 40)
    assert exact["samples"] == exact["samples_mean"] == 40 and exact["time_limit_s"] == 0.0
    # Another file's own settings, too.
    scene.petzval.use_noise_threshold, scene.petzval.noise_threshold, scene.petzval.time_limit = True, 5.0, 0.001
    blender.ops.wm.save_as_mainfile(filepath=str(file))
    assert stats("--samples", 40)["samples"] == 40
    # One that is asked for beside leaves it at that.
    told = stats("--samples", 400, "--noise-threshold", 5.0, "--min-samples", 16)
    assert told["samples_mean"] < 400


# The unit ----------------------------------------------------------------------------------------------------------


def test_a_threshold_of_cycles_leaves_the_noise_that_it_leaves_there(parts, blender, scene, tmp_path):
    """Three fifths of it to five thirds: each program looks at its noise in its own way. By the
    number alone it would be a third."""
    from support import beside_cycles

    scene.camera.location = (0.0, -4.0, 0.5)
    parts.square("Floor", (0.0, 0.0, -0.5), 8.0).rotation_euler.x = np.pi / 2
    parts.square("Wall", (0.0, 3.0, 0.0), 8.0)
    for x in (-1.0, 1.0):
        lamp = blender.data.objects.new("Lamp", blender.data.lights.new("Lamp", "AREA"))
        lamp.location, lamp.data.size, lamp.data.energy = (x, 0.0, 1.5), 1.5, 60.0
        scene.collection.objects.link(lamp)
    beside_cycles.without_tricks(2048)
    cycles = scene.cycles
    truth = parts.render(tmp_path)[..., :3]
    sampling = parts.part("export.sampling")
    sampling.follow_cycles(scene, sampling.OF_RENDER)
    cycles.use_adaptive_sampling, cycles.adaptive_threshold, cycles.adaptive_min_samples = True, 0.02, 4

    def noise(engine: str) -> float:
        scene.render.engine = engine
        off = np.abs(parts.render(tmp_path)[..., :3] - truth).sum(-1)
        return float(np.sqrt(np.mean((off / np.sqrt(truth.sum(-1).clip(0.003))) ** 2)))

    ours, theirs = noise("PETZVAL"), noise("CYCLES")
    assert 0.6 < ours / theirs < 1.67, (ours, theirs)
