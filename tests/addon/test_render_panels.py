# SPDX-License-Identifier: GPL-3.0-or-later
"""What the render panels have beside samples: a time limit, what is said meanwhile, and the messages with what they are about."""

from __future__ import annotations

import json
import time

import numpy as np
import pytest

# Time limit --------------------------------------------------------------------------------------------------------


def test_a_render_ends_when_its_time_is_up(parts, blender, tmp_path):
    """It keeps what it has, is not called stopped, and says so."""
    scene = parts.set_up(width=160, height=100, samples=1 << 20, model="LENS")
    scene.petzval.time_limit = 1.0
    began = time.monotonic()
    picture = parts.render(tmp_path)
    took = time.monotonic() - began
    last = parts.part("render.statistics").last(scene.name)
    # Reading, planning and writing come on top, and a busy machine takes its time.
    assert 1.0 <= took < 8.0 and 1.0 <= last.stats["seconds"]["render"] < 4.0
    assert not last.stopped and last.was_late() and 1 <= last.stats["samples"] < 1 << 20
    assert any("time was up" in line for line in last.lines())
    assert picture[40:60, 60:100, :3].mean() == pytest.approx(0.5, rel=0.1)


def test_a_render_that_is_quick_enough_is_the_same_with_a_limit(parts, blender, tmp_path):
    scene = parts.set_up(samples=4, model="LENS")
    without = parts.render(tmp_path)
    scene.petzval.time_limit = 300.0
    assert (parts.render(tmp_path) == without).all()
    assert not parts.part("render.statistics").last(scene.name).was_late()


@pytest.mark.once
def test_the_command_has_the_limit(petzval_cli, parts, blender, tmp_path):
    parts.set_up(width=64, height=48, samples=1 << 20, model="LENS")
    blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    out = tmp_path / "out.exr"
    arguments = ("--time-limit", 0.5, "--checkpoint", "off", "--stats", tmp_path / "stats.json", "-o", out)
    done = petzval_cli("render", tmp_path / "scene.blend", *arguments)
    assert done.returncode == 0, done.stderr
    stats = json.loads((tmp_path / "stats.json").read_text())
    assert stats["time_limit_s"] == 0.5 and 1 <= stats["samples"] < 1 << 20 and not stats["interrupted"]
    assert np.isfinite(parts.read(out)).all()
    done = petzval_cli("render", tmp_path / "scene.blend", "--time-limit", 0)
    assert done.returncode == 2 and "--time-limit" in done.stderr


def test_no_limit_ends_before_every_pixel_has_a_sample(parts):
    loop = parts.part("render.loop")

    class Job:
        def __init__(self):
            self.looked, self.stopped = 0, False

        def wait(self, _):
            return self.stopped

        def samples_done(self):
            self.looked += 1
            return int(self.looked > 5)

        def progress(self):
            return 0.0

        def take_tiles(self):
            return []

        def stop(self):
            self.stopped = True

    job = Job()
    nothing = lambda *_: None  # noqa: E731
    assert loop.follow(job, stop_asked=lambda: False, show=nothing, tell=nothing, limit_s=1e-9) is False
    assert job.stopped and job.looked > 5


# Progress ----------------------------------------------------------------------------------------------------------


class _Job:
    def __init__(self, part=0.0, rays=0):
        self.part, self.rays = part, rays

    def progress(self):
        return self.part

    def stats_json(self):
        return json.dumps({"rays": self.rays})


def test_time_left_and_rays_a_second(parts):
    progress = parts.part("render.progress")
    now = [100.0]
    # Taken up half way.
    job = _Job(0.5, 1_000_000)
    made = progress.Progress(job, clock=lambda: now[0])
    assert made.left_s(0.5) is None and made.remaining(0.5) == "" and made.speed() == ""
    now[0], job.rays = 110.0, 25_000_000
    # A fifth of the whole in ten seconds, three tenths to go.
    assert made.left_s(0.7) == pytest.approx(15.0)
    assert made.remaining(0.7) == "Remaining:00:15.00 | "
    assert made.speed() == " | 2.4 M rays/s"
    limited = progress.Progress(_Job(), limit_s=12.0, clock=lambda: now[0])
    assert limited.left_s(0.0) == 12.0
    now[0] += 9.0
    assert limited.left_s(0.01) == pytest.approx(3.0) and limited.left_s(0.9) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.0, "00:00.00"), (-1.0, "00:00.00"), (59.994, "00:59.99"), (61.5, "01:01.50"), (7322.9, "2:02:02")],
)
def test_times_are_written_as_blender_writes_them(parts, seconds, text):
    assert parts.part("render.progress").clock_time(seconds) == text


def test_what_is_said_while_rendering(parts, blender):
    scene = parts.set_up(width=96, height=64, samples=2000, model="LENS")
    scene.petzval.time_limit = 2.5
    watch, said = parts.part("render.loop").WATCH, []
    watch.on_progress = lambda _, text: said.append(text)
    try:
        blender.ops.render.render()
    finally:
        watch.on_progress = None
    during = [text for text in said if text.startswith("Sample ")]
    assert any("rays/s" in text for text in during), during[-3:]
    assert all("/2000" in text for text in during)
    lines = parts.part("render.statistics").last(scene.name).lines()
    assert any("rays a second" in line and "GB of memory" in line for line in lines), lines


def test_memory_is_what_the_system_says(parts):
    memory = parts.part("data.process_memory")
    before = memory.used_bytes()
    kept = np.ones(1 << 25)
    assert memory.used_bytes() - before == pytest.approx(kept.nbytes, rel=0.1)
    assert memory.peak_bytes() >= memory.used_bytes() * 0.99


# Messages ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "kind", "name"),
    [
        ("Object 'Cube': metaballs are not supported yet, left out", "object", "Cube"),
        ("object 'it's': its scale is zero; left out", "object", "it's"),
        ("Image 'a.png' cannot be read (x), magenta is shown", "image", "a.png"),
        ("Light linking: more than 3 collections, 'a' is left out", "", ""),
        ("its glass is not known", "", ""),
    ],
)
def test_a_message_says_what_it_is_about(parts, text, kind, name):
    assert parts.part("render.messages").of_text(text) == (text, kind, name)


def test_messages_are_listed_once_and_select_what_they_are_about(parts, blender):
    scene = parts.set_up(samples=1)
    square = parts.square("Square", (0.0, 5.0, 0.0), 1.0)
    other = parts.square("Other", (2.0, 5.0, 0.0), 1.0)
    made, tree, surface = parts.material("Odd")
    tree.links.new(tree.nodes.new("ShaderNodeHoldout").outputs[0], surface)
    for one in (square, other):
        one.data.materials.append(made)
    other.scale = (0.0, 0.0, 0.0)
    blender.ops.render.render()
    messages = parts.part("render.messages")
    found = messages.all_of(scene.name)
    assert len({one.text for one in found}) == len(found)
    assert ("object", "Other") in {(one.kind, one.name) for one in found}, found
    messages.keep_viewport(scene.name, [found[0].text, "Material 'Odd': in the viewport"])
    again = messages.all_of(scene.name)
    assert [one.text for one in again] == [*(one.text for one in found), "Material 'Odd': in the viewport"]
    messages.forget()
    select = blender.ops.petzval.select_named
    assert select(kind="object", name="Other") == {"FINISHED"}
    assert blender.context.selected_objects == [other] and blender.context.object == other
    assert select(kind="material", name="Odd") == {"FINISHED"}
    assert set(blender.context.selected_objects) == {square, other}
    assert select(kind="mesh", name=square.data.name) == {"FINISHED"} and blender.context.selected_objects == [square]
    assert select(kind="object", name="gone") == {"CANCELLED"}
