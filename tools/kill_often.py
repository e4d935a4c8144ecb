# SPDX-License-Identifier: GPL-3.0-or-later
"""Kills a render with passes at random moments (`kill -9`), has it go on each time, and tells how much work each kill cost, and
whether the picture is that of a render which was left alone.

    python tools/kill_often.py [--kills 10] [--every S]     # some minutes; --every: default interval of checkpoints

A checkpoint holds the work that is in it, in seconds of rendering; the work since then is lost.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests"))

#: A scene whose materials ask for attributes, with passes of each kind, mattes and light groups.
MAKE = """
import os, sys
sys.path.insert(0, {tests!r})
import bpy
import petzval
bpy.ops.wm.read_factory_settings(use_empty=True)
petzval.load_addon().register()
from support import checkpoint_scene
checkpoint_scene.build({width}, {height}, {samples})
bpy.ops.wm.save_as_mainfile(filepath={path!r})
sys.stdout.flush()
os._exit(0)
"""


def make(path: Path, width: int, height: int, samples: int) -> None:
    """Saves the scene."""
    script = MAKE.format(tests=str(ROOT / "tests"), path=str(path), width=width, height=height, samples=samples)
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False, timeout=120)
    if not path.exists():
        sys.exit(done.stdout + done.stderr)


def start(scene: Path, out: Path, *more: object, **environment: str) -> subprocess.Popen:
    """Starts a render of the scene with all its passes."""
    options = ["--passes", "--threads", "1", "-o", str(out), *map(str, more)]
    return subprocess.Popen(
        [sys.executable, "-m", "petzval", "render", str(scene), *options],
        stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        env={**os.environ, **environment},
    )  # fmt: skip


def seconds_in(checkpoint: Path) -> float:
    """The work that a checkpoint holds: after its magic, its maker and its fingerprint (`job/checkpoint.rs`)."""
    data, at = checkpoint.read_bytes()[:4096], 16
    at += 1 + data[at] + 1
    at += 1 + data[at]
    return struct.unpack_from("<d", data, at)[0]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--every", type=float, default=None)
    parser.add_argument("--samples", type=int, default=2000)
    parser.add_argument("--size", default="240x160")
    arguments = parser.parse_args()
    width, height = map(int, arguments.size.split("x"))
    every = () if arguments.every is None else ("--checkpoint-every", arguments.every)
    span = 8.0 if arguments.every is None else arguments.every
    with tempfile.TemporaryDirectory() as folder:
        scene, out, whole = (Path(folder) / name for name in ("scene.blend", "out.exr", "whole.exr"))
        kept, stats = Path(f"{out}.checkpoint"), Path(folder) / "stats.json"
        make(scene, width, height, arguments.samples)
        worst, lost_work = 0.0, []
        for number in range(arguments.kills):
            held = seconds_in(kept) if kept.exists() else 0.0
            process = start(scene, out, *every)
            # Up to when the first checkpoint is there nothing says when rendering began.
            seen = kept.stat().st_mtime if kept.exists() else 0.0
            wait = random.uniform(0.3, 2.2) * span
            first, ends = None, None
            while process.poll() is None:
                time.sleep(0.01)
                now = kept.stat().st_mtime if kept.exists() else 0.0
                if now != seen and first is None:
                    # What it holds was there a little before it was written.
                    first = (seconds_in(kept), time.time())
                    ends = time.time() + wait
                if ends is not None and time.time() >= ends:
                    break
            if process.poll() is not None:
                print("done before it could be killed: give more --samples")
                return 1
            process.send_signal(signal.SIGKILL)
            killed = time.time()
            process.communicate()
            work = first[0] + killed - first[1]
            lost = work - seconds_in(kept)
            lost_work.append(lost)
            worst = max(worst, lost)
            print(
                f"kill {number + 1}: {held:.1f} s at its start, {work:.1f} s when killed, {lost:.1f} s lost", flush=True
            )
        last = start(scene, out, *every, "--stats", stats)
        _, said = last.communicate()
        if last.returncode != 0:
            sys.exit(said)
        done = json.loads(stats.read_text())
        alone = start(scene, whole, "--checkpoint", "off")
        _, said = alone.communicate()
        if alone.returncode != 0:
            sys.exit(said)
        same = same_pixels(out, whole)
        mean = sum(lost_work) / max(len(lost_work), 1)
        print(f"{arguments.kills} kills: {worst:.1f} s lost at most, {mean:.1f} s on average; went on from "
              f"{done['checkpoint']['resumed_seconds']:.1f} s; the picture is {'the same' if same else 'ANOTHER'}")  # fmt: skip
        return 0 if same and worst < 10.0 else 1


def same_pixels(one: Path, other: Path) -> bool:
    """True if all channels of two pictures have the same bits: everything in their files but the headers."""
    return _behind_header(one.read_bytes()) == _behind_header(other.read_bytes())


def _behind_header(exr: bytes) -> bytes:
    """The bytes of the first row of blocks and behind it."""
    is_multipart, at = bool(exr[5] & 0x10), 8
    while exr[at]:
        while exr[at]:
            # Name and type, each with an end of its own, then how long the value is.
            at = exr.index(0, exr.index(0, at) + 1) + 1
            at += 4 + int.from_bytes(exr[at : at + 4], "little")
        at += 1
        if not is_multipart:
            break
    at += is_multipart
    return exr[int.from_bytes(exr[at : at + 8], "little") :]


if __name__ == "__main__":
    sys.exit(main())
