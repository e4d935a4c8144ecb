# SPDX-License-Identifier: GPL-3.0-or-later
"""The blender program with the installed extension, from its own command line: -E, -o, -f, -a, Ctrl-C."""

from __future__ import annotations

import os
import re
import select
import signal
import subprocess
import time
from pathlib import Path

import pytest

from support.places import ROOT

pytestmark = [pytest.mark.real_blender, pytest.mark.once]


MAKE = """
import sys
import bpy
folder, samples = sys.argv[-2], int(sys.argv[-1])
scene = bpy.context.scene
scene.render.engine = "PETZVAL"
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 48, 32, 100
scene.render.image_settings.file_format = "OPEN_EXR"
scene.petzval.samples = samples
own = scene.camera.data.petzval
own.lens_file = "cooke-triplet-50mm.lens"
for frame, value in ((1, 4.0), (2, 16.0)):
    own.wide_open, own.f_number = False, value
    own.keyframe_insert("f_number", frame=frame)
scene.render.engine = "CYCLES"
bpy.ops.wm.save_as_mainfile(filepath=folder + "/scene.blend")
"""


@pytest.fixture(scope="module")
def scene(run_blender, installed_extension, tmp_path_factory):
    """`scene(samples)`: a folder with scene.blend, saved with another engine chosen."""

    def make(samples: int) -> Path:
        folder = tmp_path_factory.mktemp("real")
        (folder / "make.py").write_text(MAKE)
        done = run_blender(
            "-b", "--factory-startup", "--addons", installed_extension, "--python-exit-code", 3,
            "--python", folder / "make.py", "--", folder, samples,
        )  # fmt: skip
        assert (folder / "scene.blend").exists(), done.stdout
        return folder

    return make


def read(path: Path):
    pytest.importorskip("bpy")
    from support import scenes

    return scenes.read(path)


def test_the_engine_is_listed(run_blender, installed_extension):
    done = run_blender("-b", "--factory-startup", "--addons", installed_extension, "-E", "help")
    assert "PETZVAL" in done.stdout


def test_a_frame_and_an_animation(run_blender, installed_extension, scene):
    folder = scene(4)
    start = ("-b", folder / "scene.blend", "--addons", installed_extension, "-E", "PETZVAL")
    done = run_blender(*start, "-o", "//one-####", "-f", 1)
    assert done.returncode == 0, done.stdout
    assert "Cooke" in done.stdout and "Traceback" not in done.stdout
    one = read(folder / "one-0001.exr")
    assert one.shape == (32, 48, 4) and one[..., :3].mean() > 0.001
    done = run_blender(*start, "-o", "//all-####", "-s", 1, "-e", 2, "-a")
    assert done.returncode == 0, done.stdout
    first, second = (read(folder / f"all-000{frame}.exr") for frame in (1, 2))
    assert (first == one).all()
    assert abs(first - second).mean() > 1e-4


def test_a_missing_lens_is_an_error_in_the_log(run_blender, installed_extension, scene):
    folder = scene(1)
    wrong = "import bpy; bpy.context.scene.camera.data.petzval.lens_file = 'gone.lens'"
    done = run_blender(
        "-b", folder / "scene.blend", "--addons", installed_extension, "-E", "PETZVAL", "--python-expr", wrong,
        "-o", "//wrong-####", "-f", 1,
    )  # fmt: skip
    # It goes on as Blender does, and does not crash on the way to the file.
    assert done.returncode in (0, 1), done.stdout
    assert "no such lens: " in done.stdout
    if (folder / "wrong-0001.exr").exists():
        assert not read(folder / "wrong-0001.exr")[..., :3].any()


def innermost(pid: int) -> int:
    """The process at the end of a chain of wrappers: Blender itself, which takes a second Ctrl-C as a kill."""
    while children := Path(f"/proc/{pid}/task/{pid}/children").read_text().split():
        pid = int(children[0])
    return pid


def test_ctrl_c_ends_blender(installed_extension, real_blender_environment, scene):
    folder = scene(1_000_000)
    process = subprocess.Popen(
        [
            str(ROOT / "tools/blender"), "-b", str(folder / "scene.blend"), "--addons", installed_extension,
            "-E", "PETZVAL", "-o", "//long-####", "-f", "1",
        ],
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
        env=real_blender_environment,
    )  # fmt: skip
    seen = b""
    try:
        ends = time.monotonic() + 60.0
        while not re.search(rb"Sample [1-9]", seen):
            assert time.monotonic() < ends, seen[-2000:]
            if select.select([process.stdout], [], [], 0.5)[0]:
                seen += os.read(process.stdout.fileno(), 4096)
        began = time.monotonic()
        os.kill(innermost(process.pid), signal.SIGINT)
        seen += process.communicate(timeout=20)[0]
        assert time.monotonic() - began < 10.0
    finally:
        process.kill()
    assert b"Traceback" not in seen, seen
    assert b"(stopped)" in seen, seen
