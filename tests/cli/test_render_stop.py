# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval render`: Ctrl-C keeps what is done; the same in the real Blender, which renders alike."""

from __future__ import annotations

import json
import os
import pty
import re
import select
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from support.places import ROOT
from support.render_commands import one_line, picture


def start_long(scene: Path, folder: Path, *more, **how) -> subprocess.Popen:
    """A render that takes for ever."""
    return subprocess.Popen(
        [
            sys.executable, "-m", "petzval", "render", str(scene), "--lens", "cooke-triplet-50mm",
            "--samples", "1000000", "--resolution", "200x150", "-o", str(folder / "out.exr"), "--checkpoint", "off",
            "--stats", str(folder / "stats.json"), *map(str, more),
        ],
        cwd=ROOT, **how,
    )  # fmt: skip


def interrupted_well(folder: Path) -> None:
    stats = json.loads((folder / "stats.json").read_text())
    assert stats["interrupted"] is True
    assert 1 <= stats["samples"] < 1_000_000
    kept = picture(folder / "out.exr")
    assert kept.shape[:2] == (150, 200)
    assert kept[..., :3].mean() > 0.05


def wait_for_samples(stream: int, seconds: float = 60.0) -> bytes:
    """What was said until some samples were done; not every number is told."""
    seen, ends = b"", time.monotonic() + seconds
    while not re.search(rb"Sample [1-9]\d*/", seen):
        assert time.monotonic() < ends, seen
        if select.select([stream], [], [], 0.2)[0]:
            seen += os.read(stream, 4096)
    return seen


def test_ctrl_c_keeps_the_picture(blender, cli_scenes, tmp_path):
    """On a terminal, with its progress bar."""
    master, slave = pty.openpty()
    process = start_long(cli_scenes / "scene.blend", tmp_path, stdin=slave, stdout=subprocess.DEVNULL, stderr=slave)
    os.close(slave)
    try:
        # The whole bar, some way on.
        seen = wait_for_samples(master)
        assert re.search(rb"\[[#.]{30}\] +\d+%  Sample \d+/1000000", seen), seen
        began = time.monotonic()
        process.send_signal(signal.SIGINT)
        # A terminal that nobody reads fills up.
        while process.poll() is None:
            assert time.monotonic() - began < 20.0
            if select.select([master], [], [], 0.1)[0]:
                try:
                    seen += os.read(master, 4096)
                except OSError:
                    break
        assert process.wait(20) == 130
    finally:
        process.kill()
        os.close(master)
    assert b"Traceback" not in seen
    interrupted_well(tmp_path)


@pytest.fixture(scope="module")
def old_scene(run_blender, cli_scenes) -> Path:
    """Made by the real Blender, which may be older than bpy: its start-up scene."""
    path = cli_scenes / "old.blend"
    keep = f"import bpy; bpy.ops.wm.save_as_mainfile(filepath={str(path)!r})"
    done = run_blender("-b", "--factory-startup", "--python-expr", keep)
    assert path.exists(), done.stdout
    return path


@pytest.mark.real_blender
@pytest.mark.once
def test_the_real_blender_renders_the_same(blender, old_scene, cli_render):
    # A Blender may be built without a denoiser.
    options = ("--camera", "pinhole", "--samples", 4, "--resolution", "48x32", "--denoise", "off")
    done, out, stats = cli_render(*options, name="bpy.exr", scene="old.blend")
    assert done.returncode == 0, done.stderr
    again, real, real_stats = cli_render(
        *options, "--blender", ROOT / "tools/blender", name="real.exr", scene="old.blend"
    )
    assert again.returncode == 0, again.stderr
    assert again.stderr == ""
    assert stats["camera_rays"] == real_stats["camera_rays"]
    assert (picture(out) == picture(real)).all()


@pytest.mark.real_blender
@pytest.mark.once
def test_errors_in_the_real_blender(run_blender, petzval_cli, cli_scenes, tmp_path):
    done = petzval_cli(
        "render", cli_scenes / "no-camera.blend", "--camera", "pinhole", "--blender", ROOT / "tools/blender",
        "-o", tmp_path / "a.png",
    )  # fmt: skip
    assert done.returncode == 1
    assert "no camera" in one_line(done) or "cannot open" in one_line(done)


@pytest.mark.real_blender
@pytest.mark.once
def test_ctrl_c_in_the_real_blender(blender, old_scene, tmp_path):
    process = start_long(
        old_scene, tmp_path, "--blender", ROOT / "tools/blender",
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    try:
        wait_for_samples(process.stdout.fileno())
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=30)
        assert process.returncode == 130, err
        assert err == b""
    finally:
        process.kill()
    interrupted_well(tmp_path)


@pytest.mark.real_blender
@pytest.mark.once
def test_ctrl_c_before_the_real_blender_is_ready(old_scene, tmp_path):
    """At moments from the command's start to Blender's first samples: Blender ends, and no half of a picture is left."""
    for moment in (0.1, 0.4, 0.8, 1.2, 2.0):
        process = start_long(
            old_scene, tmp_path, "--blender", ROOT / "tools/blender",
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        )  # fmt: skip
        try:
            time.sleep(moment)
            process.send_signal(signal.SIGINT)
            # The pipes end when the last process that writes into them does: no Blender goes on alone.
            _, err = process.communicate(timeout=30)
        finally:
            process.kill()
        # While Python itself starts, the system ends the process, or Python does with status 1.
        allowed = {130} if moment > 1.5 else {130, 1, -signal.SIGINT}
        assert process.returncode in allowed, (moment, process.returncode, err)
        assert {left.name for left in tmp_path.iterdir()} <= {"out.exr", "stats.json"}, moment
        if (tmp_path / "out.exr").exists():
            assert picture(tmp_path / "out.exr")[..., :3].any(), moment
