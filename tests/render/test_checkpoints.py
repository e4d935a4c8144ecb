# SPDX-License-Identifier: GPL-3.0-or-later
"""A render that is killed goes on where it was, to the same picture; and no other render takes it up."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from support.places import ROOT
from support.render_commands import picture

pytestmark = pytest.mark.once

LENS = ("--lens", "cooke-triplet-50mm")
# Long enough to be killed in on a slow disk: some seconds of one thread.
SAMPLES = 1600
SIZE = ("--resolution", "160x120", "--samples", str(SAMPLES), "--threads", "1")


def start(scene: Path, out: Path, *more) -> subprocess.Popen:
    options = [*LENS, *SIZE, "--checkpoint-every", "0.1", "-o", str(out), *map(str, more)]
    return subprocess.Popen(
        [sys.executable, "-m", "petzval", "render", str(scene), *options],
        cwd=ROOT, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip


def finish(process: subprocess.Popen, stats: Path) -> dict:
    _, said = process.communicate(timeout=120)
    assert process.returncode == 0, said
    return json.loads(stats.read_text())


def broken_off(process: subprocess.Popen, kept: Path, stats: Path) -> tuple[str, dict]:
    """Ctrl-C once the render has written the file `kept`: the process's stderr, and the statistics."""
    before = kept.stat().st_mtime_ns if kept.exists() else None
    while not kept.exists() or kept.stat().st_mtime_ns == before:
        assert process.poll() is None, process.communicate()
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=120)
    assert process.returncode == 130, said
    return said, json.loads(stats.read_text())


def test_killed_again_and_again(blender, cli_scenes, tmp_path):
    """By kill -9, each time after another number of checkpoints."""
    whole, out = tmp_path / "whole.exr", tmp_path / "out.exr"
    kept, stats = tmp_path / "out.exr.checkpoint", tmp_path / "stats.json"
    scene = cli_scenes / "scene.blend"
    finish(start(scene, whole, "--checkpoint", "off", "--stats", stats), stats)

    for wanted in (2, 1):
        process = start(scene, out)
        changes, last = 0, 0
        while changes < wanted and process.poll() is None:
            time.sleep(0.01)
            now = kept.stat().st_mtime_ns if kept.exists() else last
            changes, last = changes + (now != last), now
        process.send_signal(signal.SIGKILL)
        process.communicate()
        assert not out.exists(), "it was done before it could be killed"
    assert kept.exists()
    done = finish(start(scene, out, "--stats", stats), stats)
    assert done["checkpoint"]["resumed_samples"] > 0.0
    assert done["checkpoint"]["problem"] is None
    # Samples of all the renders together, none twice.
    assert done["camera_rays"] == 160 * 120 * SAMPLES
    assert (picture(out) == picture(whole)).all()
    assert list(tmp_path.glob("*checkpoint*")) == []


def test_passes_go_on_too(blender, tmp_path):
    """Data, light by lobe, a shader's own outputs, mattes and light groups, by programs that hash otherwise: to the last bit."""
    import kill_often

    scene, whole, out = (tmp_path / name for name in ("scene.blend", "whole.exr", "out.exr"))
    kept, stats = tmp_path / "out.exr.checkpoint", tmp_path / "stats.json"
    kill_often.make(scene, 64, 48, 200)
    process = kill_often.start(scene, whole, "--checkpoint", "off", PYTHONHASHSEED="1")
    _, said = process.communicate(timeout=120)
    assert process.returncode == 0, said
    process = kill_often.start(scene, out, "--checkpoint-every", 0.1, PYTHONHASHSEED="2")
    while not kept.exists():
        assert process.poll() is None, process.communicate()
        time.sleep(0.01)
    time.sleep(0.4)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    assert not out.exists(), "it was done before it could be killed"
    done = finish(kill_often.start(scene, out, "--stats", stats, PYTHONHASHSEED="3"), stats)
    assert done["checkpoint"]["problem"] is None
    assert done["checkpoint"]["resumed_samples"] > 0.0
    assert kill_often.same_pixels(out, whole)


def test_stopped_and_gone_on(blender, cli_scenes, tmp_path):
    """Ctrl-C says where the render is kept; another picture begins anew, and says why."""
    # Never done, however slow the disk is and however late the signal: each render ends by Ctrl-C.
    endless = ("--samples", "100000")
    scene, out, stats = cli_scenes / "scene.blend", tmp_path / "out.exr", tmp_path / "stats.json"
    kept, other = tmp_path / "out.exr.checkpoint", tmp_path / "other.checkpoint"
    said, _ = broken_off(start(scene, out, *endless, "--stats", stats), kept, stats)
    assert str(kept) in said

    other.write_bytes(kept.read_bytes())
    another = start(scene, out, *endless, "--stats", stats, "--seed", 5, "--checkpoint", other)
    _, done = broken_off(another, other, stats)
    assert done["checkpoint"]["resumed_samples"] == 0.0
    assert "another picture" in done["checkpoint"]["problem"]
    _, done = broken_off(start(scene, out, *endless, "--stats", stats), kept, stats)
    assert done["checkpoint"]["resumed_samples"] > 0.0


def test_what_leaves_its_mark(blender):
    """Everything that the engine is told, and nothing that does not change the picture."""
    import petzval

    checkpoints = petzval.load_addon().render.checkpoints

    def mark(*values) -> str:
        digest = hashlib.blake2b()
        checkpoints.feed(digest, values)
        return digest.hexdigest()

    @dataclasses.dataclass
    class Material:
        name: str
        colour: tuple

    points = np.arange(6, dtype=np.float32).reshape(2, 3)
    values = [
        points, points.reshape(3, 2), points.astype(np.float64), points + 1e-6, points[::-1], b"ab", "ab", ["a", "b"], ["ab"],
        [["a"], "b"], Material("a", (1.0, 0.5)), Material("a", (1.0, 0.25)), Material("b", (1.0, 0.5)), {"a": 1}, {"a": 1.0},
        None, False, 0, (), [()],
    ]  # fmt: skip
    marks = [mark(value) for value in values]
    assert len(set(marks)) == len(values)
    assert marks == [mark(value) for value in values]
    # As it lies in memory does not count.
    assert mark(np.asfortranarray(points)) == mark(points)


def test_a_render_in_blender_keeps_itself_among_the_users_files(blender, tmp_path, monkeypatch):
    """Without a program around it: in a file of the scene's own, deleted when the picture is there."""
    import petzval
    from support import scenes as parts

    addon = petzval.load_addon()
    monkeypatch.setattr(blender.utils, "user_resource", lambda _kind, path, create: str(tmp_path))
    monkeypatch.setattr(addon.render.checkpoints, "EVERY_S", 0.005)
    # 64 samples are over in 20 ms where it is fast; these take a second there.
    scene = parts.set_up(96, 64, 3000)
    parts.square("Square", (0.1, 5, 0.2), 0.6, parts.emitter((1.0, 0.5, 0.2), 2.0))
    seen = []
    monkeypatch.setattr(addon.render.loop.WATCH, "on_progress", lambda _part, _text: seen.extend(tmp_path.iterdir()))
    blender.ops.render.render(scene=scene.name)
    stats = addon.render.statistics.last(scene.name).stats["checkpoint"]
    assert stats["written"] > 0 and stats["problem"] is None
    assert any(path.suffix == ".checkpoint" for path in seen)
    assert list(tmp_path.iterdir()) == []
    scene.petzval.use_checkpoints = False
    blender.ops.render.render(scene=scene.name)
    assert addon.render.statistics.last(scene.name).stats["checkpoint"] is None
