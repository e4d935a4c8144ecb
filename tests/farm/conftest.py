# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes for a render farm, and jobs that were made of them."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

import pytest

from support import farm_scenes, render_commands


@pytest.fixture(scope="session")
def farm_scenes_folder(tmp_path_factory):
    """The folder with shot.blend, small.blend and catcher.blend in shots/scene, and what they name around it."""
    pytest.importorskip("bpy")
    folder = tmp_path_factory.mktemp("farm") / "work"
    farm_scenes.save(folder)
    return folder / "shots/scene"


@pytest.fixture(scope="session")
def finished_job(farm_scenes_folder, tmp_path_factory):
    """A job of three parts, all of them rendered, and the picture that one machine makes: (folder, picture). It is to be copied."""
    folder = tmp_path_factory.mktemp("finished")
    scene, job, whole = farm_scenes_folder / "small.blend", folder / "job", folder / "whole.exr"
    engines = [word for name in ("shell", "slurm", "openjd", "flamenco", "dask") for word in ("--for", name)]
    done = render_commands.many(
        [
            ["farm", "plan", scene, "--parts", "3", *engines, "-o", job],
            ["render", scene, "-o", whole],
            *(["farm", "part", job, str(number)] for number in range(3)),
        ],
        folder,
    )
    assert [one.returncode for one in done] == [0] * 5, [one.stderr for one in done]
    return job, whole


@pytest.fixture
def job(finished_job, tmp_path):
    """A copy of the finished job, somewhere else."""
    folder = Path(tempfile.mkdtemp(dir=tmp_path)) / "a job"
    shutil.copytree(finished_job[0], folder)
    return folder


@pytest.fixture(scope="session")
def petzval_cli(tmp_path_factory):
    """As everywhere, but all in one process: the start of Blender is most of what a merge of a small picture takes. What is about processes
    starts its own."""
    waiting = render_commands.Waiting(tmp_path_factory.mktemp("waiting"))
    yield waiting.run
    waiting.end()


@pytest.fixture
def commands(tmp_path):
    """Runs several commands in one process, each `petzval WORDS`: what came of each."""

    def run(*several):
        return render_commands.many([list(one) for one in several], tmp_path)

    return run
