# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts of a job make the picture that one machine makes, in every pass and to the last bit."""

from __future__ import annotations

import json
import shutil

import pytest

from support import render_commands
from support.exr_bytes import assert_same_picture

#: What is rendered: the scene and its options; how many parts are made, and in which order they come. The last comes after the first
#: merge, and the second is rendered twice.
KINDS = {
    # Two view layers of all kinds of passes, denoised, with ghosts and glare, through a lens of its own glass.
    "layers": ("shot.blend", ["--passes"], 7, [3, 6, 0, 5, 1, 4, 2]),
    "one-part": ("small.blend", ["--passes"], 1, [0]),
    "animation": ("small.blend", ["--frames", "1-3,2", "--samples", "2"], 2, [2, 1, 0, 3]),
    "adaptive": ("small.blend", ["--passes", "--samples", "64", "--noise-threshold", "0.05", "--denoise", "off"], 2, [1, 0]),
    "two-way": ("small.blend", ["--integrator", "bdpt"], 2, [1, 0]),
    "catcher": ("catcher.blend", ["--passes"], 2, [1, 0]),
    # By a file that the scene's camera names.
    "calibrated": ("small.blend", ["--camera", "calibrated"], 2, [1, 0]),
    "thin": ("small.blend", ["--camera", "thin", "--blue-noise", "on"], 3, [0, 2, 1]),
}  # fmt: skip


@pytest.fixture(scope="module")
def jobs(request, farm_scenes_folder, tmp_path_factory):
    """Of each kind that is tested: the folder of the job, planned on one machine and rendered on another, and the pictures of one machine;
    what came of the merge before the last part, of a part that was finished, and of the last merge."""
    params = [item.callspec.params for item in request.session.items if hasattr(item, "callspec")]
    kinds = [one["kind"] for one in params if "kind" in one]
    kinds = [kind for kind in KINDS if kind in kinds]
    folder = tmp_path_factory.mktemp("whole")
    here, there = folder / "here", folder / "another machine"
    here.mkdir()
    first, second = [], []
    for kind in kinds:
        name, options, parts, order = KINDS[kind]
        scene, job, moved = farm_scenes_folder / name, here / kind, there / kind
        first += [
            ["farm", "plan", scene, *options, "--parts", str(parts), "-o", job],
            ["render", scene, *options, "-o", here / f"{kind}.exr"],
        ]
        numbers = [*order[:-1], order[min(1, len(order) - 2)]] if len(order) > 1 else []
        second += [["farm", "part", moved, str(n), "--threads", str(1 + n % 2), "--again"] for n in numbers]
        second += [["farm", "merge", moved, "--json"]]
        second += [["farm", "part", moved, str(n)] for n in (order[-1], order[0])]
        second += [["farm", "merge", moved]]
    planned = render_commands.many(first, folder)
    assert not any(one.returncode for one in planned), [one.stderr for one in planned]
    # The pictures of one machine stay; the jobs go elsewhere.
    there.mkdir()
    for kind in kinds:
        shutil.move(here / kind, there / kind)
    done = iter(render_commands.many(second, folder))
    found = {}
    for kind in kinds:
        *_, order = KINDS[kind]
        rendered = [next(done) for _ in range(len(order) if len(order) > 1 else 0)]
        first_merge, last, repeated, merge = (next(done) for _ in range(4))
        assert not any(one.returncode for one in (*rendered, last)), (kind, [one.stderr for one in (*rendered, last)])
        found[kind] = there / kind, sorted(here.glob(f"{kind}*.exr")), first_merge, repeated, merge
    return found


@pytest.mark.parametrize(
    "kind", [pytest.param(kind, marks=() if kind == "layers" else pytest.mark.once) for kind in KINDS]
)
def test_parts_make_the_whole(kind, jobs):
    _, _, parts, order = KINDS[kind]
    job, theirs, first_merge, repeated, merge = jobs[kind]
    assert first_merge.returncode == 75 and json.loads(first_merge.stdout)["missing"] == [order[-1]]
    assert repeated.returncode == 0 and "it is finished already" in repeated.stdout
    assert (merge.returncode, merge.stderr) == (0, "")
    # What the job's scene names lies in the job.
    assert [one.name for one in job.rglob("camera.txt")] == ([] if kind == "layers" else ["camera.txt"])
    ours = sorted((job / "pictures").glob("*.exr"))
    assert len(ours) == len(theirs) == len(json.loads((job / "job.json").read_text())["parts"]) // parts
    for one, other in zip(ours, theirs, strict=True):
        assert_same_picture(one, other)


@pytest.mark.once
def test_a_growing_picture_is_that_of_its_parts(job, commands):
    """What is merged before all parts are there has the whole's pixels where they are, and nothing elsewhere."""
    from support import scenes

    pixels = []
    for lost in (None, 1):
        if lost is not None:
            (job / f"parts/{lost:04d}.json").unlink()
        (done,) = commands(["farm", "merge", job])
        assert done.returncode == (0 if lost is None else 75), done.stderr
        pixels.append(scenes.read(job / "pictures/small.exr"))
    whole, some = pixels
    is_there = (some == whole).all(axis=2)
    assert 0.5 < is_there.mean() < 0.9
    assert (some[..., :3][~is_there] <= whole[..., :3][~is_there] + 1e-6).all()
