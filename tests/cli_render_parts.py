# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests of `petzval render` share: its scenes, how it is run, its pictures. conftest.py hands on the fixtures."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent

MAKE = """
import os, sys
sys.path.insert(0, {tests!r})
import bpy
import petzval
bpy.ops.wm.read_factory_settings(use_empty=True)
petzval.load_addon().register()
import scene_parts as parts
scene = parts.set_up(48, 32, 4)
parts.square("Square", (0.1, 5, 0.2), 0.6, parts.emitter((1.0, 0.5, 0.2), 2.0))
for frame, x in ((1, 0.1), (2, 0.9)):
    bpy.data.objects["Square"].location.x = x
    bpy.data.objects["Square"].keyframe_insert("location", frame=frame)
# A picture that is not Petzval's to make, and a text that must never run.
scene.render.engine = "CYCLES"
text = bpy.data.texts.new("startup.py")
text.write("open({ran!r}, 'w').write('ran')")
text.use_module = True
driver = scene.camera.data.driver_add("passepartout_alpha").driver
driver.type = "SCRIPTED"
driver.expression = "open({ran!r}, 'w').write('ran') and 0.5"
bpy.ops.wm.save_as_mainfile(filepath={path!r})
scene.camera = None
bpy.ops.wm.save_as_mainfile(filepath={no_camera!r})
sys.stdout.flush()
os._exit(0)
"""


#: Several commands in one process, as Blender's start is most of what one takes: each through all of the command, but that the
#: process goes on. Answers with the exit status of each; what each says on stderr lies in a file.
MANY = """
import json, os, sys, tempfile
from petzval import cli, render_in_blender

class Ended(Exception):
    pass

def end(status):
    raise Ended(status)

render_in_blender.finish = end
told = []
for number, argv in enumerate(json.loads(sys.argv[1])):
    said = os.open(os.path.join({folder!r}, f"said-{{number}}.txt"), os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(said, 2)
    try:
        status = cli.run_command(argv)
    except Ended as ended:
        status = ended.args[0]
    told.append(status)
    with open(os.path.join({folder!r}, "told.json"), "w") as out:
        json.dump(told, out)
sys.stdout.flush()
os._exit(0)
"""


@pytest.fixture(scope="session")
def cli_scenes(tmp_path_factory):
    """The folder with scene.blend and no-camera.blend; a script in it would write `ran`."""
    pytest.importorskip("bpy")
    folder = tmp_path_factory.mktemp("cli-render")
    script = MAKE.format(
        tests=str(ROOT / "tests"), path=str(folder / "scene.blend"), no_camera=str(folder / "no-camera.blend"),
        ran=str(folder / "ran"),
    )  # fmt: skip
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False, timeout=60)
    assert (folder / "no-camera.blend").exists(), done.stdout + done.stderr
    (folder / "ran").unlink(missing_ok=True)
    return folder


@pytest.fixture
def cli_render(petzval_cli, cli_scenes, tmp_path):
    """`render(options...)` into out.exr: (finished process, picture, statistics)."""

    def run(*options, name: str = "out.exr", scene: str = "scene.blend"):
        out, stats = tmp_path / name, tmp_path / f"{name}.json"
        done = petzval_cli("render", cli_scenes / scene, *options, "-o", out, "--stats", stats)
        return done, out, json.loads(stats.read_text()) if stats.exists() else None

    return run


@dataclass
class Render:
    """What came of one of several renders."""

    returncode: int
    stderr: str
    out: Path
    stats: dict | None


@pytest.fixture
def cli_renders(cli_scenes, tmp_path):
    """`renders([options...], ...)`: each as `cli_render` does it, all in one process, which opens the file anew for each."""

    def run(*several) -> list[Render]:
        folder = Path(tempfile.mkdtemp(dir=tmp_path))
        outs = [folder / f"{number}.exr" for number in range(len(several))]
        commands = [
            ["render", str(cli_scenes / "scene.blend"), *map(str, options), "-o", str(out), "--stats", f"{out}.json"]
            for options, out in zip(several, outs, strict=True)
        ]
        done = subprocess.run(
            [sys.executable, "-c", MANY.format(folder=str(folder)), json.dumps(commands)], stdin=subprocess.DEVNULL,
            capture_output=True, text=True, cwd=ROOT, timeout=300, check=False,
        )  # fmt: skip
        told = folder / "told.json"
        statuses = json.loads(told.read_text()) if told.exists() else []
        assert done.returncode == 0 and len(statuses) == len(several), done.stdout[-2000:] + done.stderr
        found = []
        for number, (status, out) in enumerate(zip(statuses, outs, strict=True)):
            stats = Path(f"{out}.json")
            said = (folder / f"said-{number}.txt").read_text()
            found.append(Render(status, said, out, json.loads(stats.read_text()) if stats.exists() else None))
        return found

    return run


def picture(path: Path):
    import bpy  # noqa: F401

    sys.path.insert(0, str(ROOT / "tests"))
    import scene_parts

    return scene_parts.read(path)


def one_line(done) -> str:
    assert done.stderr.startswith("petzval: ") and done.stderr.count("\n") == 1, done.stderr
    assert "Traceback" not in done.stderr
    return done.stderr
