# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs of `petzval render` and of several commands in one process: their scenes, what came of them, their pictures.

Fixtures in conftest.py hand them on."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from support.places import ROOT, TESTS

MAKE = """
import os, sys
sys.path.insert(0, {tests!r})
import bpy
import petzval
bpy.ops.wm.read_factory_settings(use_empty=True)
petzval.load_addon().register()
from support import scenes as parts
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
#: process goes on. Exit statuses, and what each says, lie in files.
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
    for stream, name in ((1, "out"), (2, "err")):
        file = os.open(os.path.join({folder!r}, f"{{number}}.{{name}}"), os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(file, stream)
        os.close(file)
    try:
        status = cli.run_command(argv)
    except Ended as ended:
        status = ended.args[0]
    sys.stdout.flush()
    told.append(status)
    with open(os.path.join({folder!r}, "told.json"), "w") as out:
        json.dump(told, out)
sys.stdout.flush()
os._exit(0)
"""


def save_scenes(folder: Path) -> None:
    """Saves scene.blend and no-camera.blend; a script in them would write `ran`."""
    script = MAKE.format(
        tests=str(TESTS), path=str(folder / "scene.blend"), no_camera=str(folder / "no-camera.blend"),
        ran=str(folder / "ran"),
    )  # fmt: skip
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False, timeout=60)
    assert (folder / "no-camera.blend").exists(), done.stdout + done.stderr
    (folder / "ran").unlink(missing_ok=True)


@dataclass
class Done:
    """What came of one of several commands."""

    returncode: int
    stdout: str
    stderr: str


def many(commands: list[list[str]], folder: Path, timeout_s: float = 300.0) -> list[Done]:
    """Runs commands one after another in one process; another one goes on behind a command that took the process with it."""
    done: list[Done] = []
    while len(done) < len(commands):
        own = Path(tempfile.mkdtemp(dir=folder))
        # Words, as a shell would hand them over.
        left = json.dumps([[str(word) for word in command] for command in commands[len(done) :]])
        ended = subprocess.run(
            [sys.executable, "-c", MANY.format(folder=str(own)), left], stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=ROOT, timeout=timeout_s, check=False,
        )  # fmt: skip
        told = own / "told.json"
        statuses = json.loads(told.read_text()) if told.exists() else []
        if len(done) + len(statuses) < len(commands):
            statuses.append(ended.returncode or -1)
        for number, status in enumerate(statuses):
            said = [own / f"{number}.{name}" for name in ("out", "err")]
            done.append(Done(status, *(file.read_text(errors="replace") if file.exists() else "" for file in said)))
    return done


#: The same for commands that come one by one, while a test looks at what they have done: a line of words in, a line with the status out.
WAITING = """
import json, os, sys
from petzval import cli, render_in_blender

class Ended(Exception):
    pass

def end(status):
    raise Ended(status)

render_in_blender.finish = end
answers = os.fdopen(os.dup(1), "w", buffering=1)
while asked := sys.stdin.readline():
    argv, files = json.loads(asked)
    for stream, name in enumerate(files, 1):
        file = os.open(name, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(file, stream)
        os.close(file)
    try:
        status = cli.run_command(argv)
    except Ended as ended:
        status = ended.args[0]
    except SystemExit as ended:
        status = ended.code
    sys.stdout.flush()
    print(status, file=answers)
os._exit(0)
"""


class Waiting:
    """A process that runs commands one by one, with one start of Blender."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._count = folder, 0
        self._process: subprocess.Popen[str] | None = None

    def run(self, *words: object) -> Done:
        """What came of `petzval WORDS`. A command that takes the process with it has its status."""
        if self._process is None:
            self._process = subprocess.Popen(
                [sys.executable, "-c", WAITING], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                text=True, cwd=ROOT,
            )  # fmt: skip
        self._count += 1
        files = [self._folder / f"{self._count}.{name}" for name in ("out", "err")]
        self._process.stdin.write(json.dumps([[str(word) for word in words], [str(file) for file in files]]) + "\n")
        self._process.stdin.flush()
        answer = self._process.stdout.readline()
        status = int(answer) if answer else self._process.wait(timeout=30) or -1
        if not answer:
            self._process = None
        return Done(status, *(file.read_text(errors="replace") if file.exists() else "" for file in files))

    def end(self) -> None:
        """Ends the process."""
        if self._process is not None:
            self._process.stdin.close()
            self._process.wait(timeout=30)


@dataclass
class Render(Done):
    """And of a render."""

    out: Path
    stats: dict | None


def render_all(scene: Path, several: list[tuple], folder: Path) -> list[Render]:
    """Renders a scene with each of several lists of options, all in one process, which opens the file anew for each."""
    outs = [folder / f"{number}.exr" for number in range(len(several))]
    commands = [
        ["render", scene, *options, "-o", out, "--stats", f"{out}.json"]
        for options, out in zip(several, outs, strict=True)
    ]
    found = []
    for out, done in zip(outs, many(commands, folder), strict=True):
        stats = Path(f"{out}.json")
        told = json.loads(stats.read_text()) if stats.exists() else None
        found.append(Render(done.returncode, done.stdout, done.stderr, out, told))
    return found


def picture(path: Path):
    """The pixels of a picture, as `scenes.read` gives them."""
    from support import scenes

    return scenes.read(path)


def one_line(done) -> str:
    assert done.stderr.startswith("petzval: ") and done.stderr.count("\n") == 1, done.stderr
    assert "Traceback" not in done.stderr
    return done.stderr
