# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes by other people: each opens and renders, and says what it could not show.

None of them is part of the project; PETZVAL_SCENES names a folder of them.
"""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from support.render_commands import Done, many

pytestmark = [pytest.mark.once, pytest.mark.slow]

# Collected here: the fixture `other_peoples_scenes` says why there are none.
FOLDER = os.environ.get("PETZVAL_SCENES", "")
SCENES = sorted(Path(FOLDER).rglob("*.blend")) if FOLDER and Path(FOLDER).is_dir() else []
# Without a camera of their own they are parts for other files; and Cycles shows black in these.
MAY_BE_BLACK = {"space_sky_nebula", "engineer_bedroom"}
TIMES_OUT_AFTER_S = 120.0


def test_there_are_scenes(other_peoples_scenes):
    assert SCENES, f"no .blend in {other_peoples_scenes}"


@dataclass
class Rendered:
    """What `petzval render` did with a scene."""

    done: Done
    out: Path
    stats: Path
    size: tuple[int, int]
    samples: int


@pytest.fixture(scope="module")
def rendered(other_peoples_scenes, tmp_path_factory):
    """`rendered(scene)`: each is rendered once for all tests that ask; those of one folder, most of which are parts of one
    scene, in one process."""
    known: dict[Path, Rendered] = {}

    def together(scenes: list[Path]) -> None:
        folder = tmp_path_factory.mktemp("other-peoples-scenes")
        asked, commands = [], []
        for scene in scenes:
            out, stats = folder / f"{scene.stem}.exr", folder / f"{scene.stem}.json"
            # The nebula is a volume that fills the whole picture, and slow.
            (width, height), samples = ((16, 9), 1) if scene.stem == "space_sky_nebula" else ((160, 90), 4)
            asked.append((out, stats, (width, height), samples))
            options = ["--camera", "pinhole", "--resolution", f"{width}x{height}", "--samples", samples, "--threads", 2]
            commands.append(["render", scene, *options, "-o", out, "--stats", stats])
        for scene, done, one in zip(scenes, many(commands, folder, TIMES_OUT_AFTER_S), asked, strict=True):
            known[scene] = Rendered(done, *one)

    def one(scene: Path) -> Rendered:
        if scene not in known:
            is_alone = scene.parent == other_peoples_scenes
            together([scene] if is_alone else [one for one in SCENES if one.parent == scene.parent])
        return known[scene]

    return one


@pytest.mark.parametrize("scene", SCENES, ids=lambda path: path.stem)
def test_a_scene_of_other_people(rendered, scene):
    from support import scenes

    one = rendered(scene)
    if one.done.returncode == 1 and "no camera" in one.done.stderr:
        assert one.done.stderr.count("\n") == 1
        pytest.skip(f"{scene.name} is a library of parts: it has no camera")
    assert one.done.returncode == 0, one.done.stderr
    assert one.done.stderr == ""
    told = json.loads(one.stats.read_text())
    assert told["non_finite_samples"] == 0
    assert told["samples"] == one.samples
    assert len(told["warnings"]) == len(set(told["warnings"]))
    assert all(line and "\n" not in line for line in told["warnings"])
    pixels = scenes.read(one.out)
    assert pixels.shape[1::-1] == one.size
    assert np.isfinite(pixels).all()
    assert pixels[..., :3].mean() > 0.0 or scene.stem in MAY_BE_BLACK, told["warnings"]


@pytest.mark.parametrize("scene", [one for one in SCENES if one.stem in {"cornell_emitter", "dof_monkeys"}],
                         ids=lambda path: path.stem)  # fmt: skip
def test_a_scene_through_a_lens(petzval_cli, other_peoples_scenes, tmp_path, scene):
    from support import scenes

    out, stats = tmp_path / "out.exr", tmp_path / "stats.json"
    done = petzval_cli(
        "render", scene, "--lens", "double-gauss-f2-tronnier", "--focal-length", 35, "--resolution", "160x90",
        "--samples", 4, "-o", out, "--stats", stats, timeout_s=TIMES_OUT_AFTER_S,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    told = json.loads(stats.read_text())
    assert told["non_finite_samples"] == 0 and told["camera_rays"] > told["camera_rays_lost"]
    pixels = scenes.read(out)
    assert np.isfinite(pixels).all() and pixels[..., :3].mean() > 0.0


WHAT_IS_MISSING = {
    "kitchen_blueprint": ["201906_lwtechSnow_panorama.hdr", "magenta"],
}


@pytest.mark.parametrize("name", WHAT_IS_MISSING)
def test_what_is_missing_is_named(rendered, name):
    scene = next((one for one in SCENES if one.stem == name), None)
    if scene is None:
        pytest.skip(f"{name}.blend is not there")
    one = rendered(scene)
    assert one.done.returncode == 0, one.done.stderr
    told = "\n".join(json.loads(one.stats.read_text())["warnings"])
    for word in WHAT_IS_MISSING[name]:
        assert word in told, told
