# SPDX-License-Identifier: GPL-3.0-or-later
"""A job goes through each scheduler, or what stands for it: the commands that its file names are really run, and the picture is that of one
machine."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import time
from collections import Counter

import pytest

from petzval.farm.engines import ENGINES
from support.exr_bytes import assert_same_picture
from support.places import ROOT, TESTS

pytestmark = pytest.mark.once

#: The command petzval of this checkout, in two words at least.
PETZVAL = f"{sys.executable} -m petzval"


def lose(job, *parts) -> None:
    """Parts that are yet to be rendered."""
    for part in parts:
        for file in (job / "parts").glob(f"{part:04d}.*"):
            file.unlink()
    shutil.rmtree(job / "pictures")


@pytest.fixture
def program(tmp_path):
    """A folder with a program called petzval."""
    folder = tmp_path / "bin"
    folder.mkdir()
    file = folder / "petzval"
    file.write_text(f'#!/bin/sh\nexec {PETZVAL} "$@"\n')
    file.chmod(0o755)
    return folder


def run(command, cwd, folder=None, **environment) -> subprocess.CompletedProcess[str]:
    own = os.environ | environment
    own["PYTHONPATH"] = os.pathsep.join(filter(None, (str(ROOT / "engine/python"), os.environ.get("PYTHONPATH"))))
    if folder is not None:
        own["PATH"] = f"{folder}{os.pathsep}{own['PATH']}"
    return subprocess.run(command, cwd=cwd, env=own, capture_output=True, text=True, check=False, timeout=240)


def test_every_engine_has_files(job):
    from petzval.farm import engines
    from petzval.farm.job import load

    for name in ENGINES:
        files = engines.files(name, load(job))
        assert files and all((job / file).read_text() == text for file, text in files.items()), name
        # The folder may be moved.
        assert not any(str(job.parent) in text for text in files.values())


def test_shell(job, finished_job, tmp_path):
    lose(job, 0, 1, 2)
    done = run(["sh", "-n", job / "run.sh"], tmp_path)
    assert done.returncode == 0, done.stderr
    done = run([job / "run.sh", "2"], tmp_path, PETZVAL=PETZVAL)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count(": finished in ") == 3
    assert_same_picture(job / "pictures/small.exr", finished_job[1])


def test_shell_tries_again(job, tmp_path, program):
    """A command that fails twice for the moment, and one that never will do."""
    told = tmp_path / "told"
    (program / "petzval").write_text(
        f'#!/bin/sh\necho "$2 $4" >> {told}\ncase "$2 $4" in "part 0") [ $(grep -c "part 0" {told}) -ge 3 ] || exit 75;; "part 1") exit 1;; esac\n'
    )
    assert run([job / "run.sh"], tmp_path, program).returncode == 0
    assert told.read_text().split("\n")[:-1] == ["part 0"] * 3 + ["part 1", "part 2", "merge "]


@pytest.fixture
def slurm(program, tmp_path):
    """The stand-in for Slurm beside the program, and the folder of its jobs."""
    for name in ("sbatch", "scontrol"):
        (program / name).write_text((TESTS / "support/stand_in_sbatch.py").read_text())
        (program / name).chmod(0o755)
    folder = tmp_path / "slurm"
    folder.mkdir()
    return folder


def test_slurm(job, finished_job, tmp_path, program, slurm):
    lose(job, 2)
    done = run([job / "submit.sh", "--cpus-per-task=1"], tmp_path, program, STAND_IN_SLURM=str(slurm))
    assert done.returncode == 0, done.stderr
    parts, merge = json.loads((slurm / "jobs.json").read_text()).values()
    assert parts["options"]["array"] == "0-2" and parts["statuses"] == {"0": 0, "1": 0, "2": 0}
    assert merge["options"]["dependency"] == "afterany:100" and merge["statuses"] == {"0": 0}
    assert_same_picture(job / "pictures/small.exr", finished_job[1])


def test_slurm_asks_for_another_try(job, tmp_path, program, slurm):
    """A part that fails for the moment is requeued, no more than three times; one that cannot be rendered is not."""
    (program / "petzval").write_text(
        '#!/bin/sh\ncase "$2 $4" in "part 0") exit 75;; "part 1") exit 1;; "part 2") [ "$SLURM_RESTART_COUNT" = 1 ] || exit 75;; esac\n'
    )
    assert run([job / "submit.sh"], tmp_path, program, STAND_IN_SLURM=str(slurm)).returncode == 0
    parts, merge = json.loads((slurm / "jobs.json").read_text()).values()
    assert parts["statuses"] == {"2": 0, "1": 1, "0": 75} and merge["statuses"] == {"0": 0}


def test_slurm_stops_a_part(job, tmp_path, program):
    """The signal before the time is over reaches the part, and its own exit status comes back."""
    (program / "petzval").write_text(
        "#!/bin/sh\ntrap 'echo kept; exit 130' TERM\necho begun\nwhile :; do sleep 0.02; done\n"
    )
    own = os.environ | {
        "PATH": f"{program}{os.pathsep}{os.environ['PATH']}",
        "SLURM_ARRAY_TASK_ID": "0",
        "SLURM_RESTART_COUNT": "3",
    }
    part = subprocess.Popen(["sh", "part.sbatch.sh"], cwd=job, env=own, stdout=subprocess.PIPE, text=True)
    assert part.stdout.readline() == "begun\n"
    time.sleep(0.1)
    part.terminate()
    out, _ = part.communicate(timeout=20)
    assert (part.returncode, out) == (130, "kept\n")


def test_openjd(job, finished_job, tmp_path, program):
    """By the reference implementation, where it is installed: pip install openjd-cli."""
    openjd = shutil.which("openjd")
    if openjd is None:
        pytest.skip("no openjd: pip install openjd-cli, and have it on PATH")
    lose(job, 1)
    checked = run([openjd, "check", "template.json"], job)
    assert checked.returncode == 0, checked.stdout + checked.stderr
    own = ["-p", f"JobFolder={job}", "-p", f"Petzval={program / 'petzval'}"]
    done = run([openjd, "run", "template.json", *own], job)
    assert done.returncode == 0, done.stdout + done.stderr
    assert_same_picture(job / "pictures/small.exr", finished_job[1])


def test_openjd_has_the_shape_of_the_specification(job):
    """The shape that Open Job Description 2023-09 asks of a template, where no openjd is there to check it."""
    template = json.loads((job / "template.json").read_text())
    assert template["specificationVersion"] == "jobtemplate-2023-09"
    assert {one["name"]: one["type"] for one in template["parameterDefinitions"]} == {
        "JobFolder": "PATH",
        "Petzval": "STRING",
    }
    parts, merge = template["steps"]
    assert parts["parameterSpace"]["taskParameterDefinitions"] == [{"name": "Part", "type": "INT", "range": "0-2"}]
    assert parts["script"]["actions"]["onRun"]["args"] == ["farm", "part", "{{Param.JobFolder}}", "{{Task.Param.Part}}"]
    assert merge["dependencies"] == [{"dependsOn": "Parts"}]
    assert merge["script"]["actions"]["onRun"]["args"] == ["farm", "merge", "{{Param.JobFolder}}"]


def test_flamenco(job, finished_job, tmp_path, program):
    """The job type in node, with the Manager's globals imitated; the commands of its tasks are run in an order that its dependencies allow."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("no node: apt install nodejs")
    lose(job, 0)
    settings = {"job_folder": str(job), "petzval": str(program / "petzval"), "threads": 1}
    imitated = TESTS / "support/flamenco_globals.js"
    done = run([node, imitated, job / "petzval-farm.js", json.dumps(settings)], tmp_path)
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    # The kinds of settings that the Manager knows (pkg/api: AvailableJobSetting).
    for setting in told["jobType"]["settings"]:
        assert setting["type"] in {"string", "int32", "float", "bool"}
        assert setting.get("visible") in {"visible", "hidden", "submission", "web", None}
        assert set(setting) <= {"key", "type", "subtype", "required", "default", "visible", "description", "propargs"}
    submission = json.loads((job / "flamenco-job.json").read_text())
    assert set(submission["settings"]) == {one["key"] for one in told["jobType"]["settings"]}
    *parts, merge = told["tasks"]
    assert merge["dependencies"] == [one["name"] for one in parts] == ["part-0", "part-1", "part-2"]
    assert not any(one["dependencies"] for one in parts)
    for task in [*reversed(parts), merge]:
        (command,) = task["commands"]
        assert command["name"] == "exec" and set(command["parameters"]) == {"exe", "args"}
        done = run([command["parameters"]["exe"], *command["parameters"]["args"]], tmp_path)
        assert done.returncode == 0, done.stderr
    assert_same_picture(job / "pictures/small.exr", finished_job[1])
    refused = run([node, imitated, job / "petzval-farm.js", "{}"], tmp_path)
    assert refused.returncode != 0 and "no job folder" in refused.stderr


def test_flamenco_submission_fits_the_job_type(job):
    """Without an interpreter of JavaScript: the keys are those of the submission."""
    script = (job / "petzval-farm.js").read_text()
    settings = json.loads((job / "flamenco-job.json").read_text())["settings"]
    assert settings["part_count"] == 3
    assert all(f'key: "{key}"' in script for key in settings) and script.count("key: ") == len(settings)


def test_local(job, finished_job, petzval_cli):
    lose(job, 0, 2)
    done = petzval_cli("farm", "run", job, "--local", "2")
    assert done.returncode == 0, done.stderr
    assert_same_picture(job / "pictures/small.exr", finished_job[1])


def test_a_process_takes_several_parts(job, finished_job, petzval_cli):
    """Blender starts once for each process, and once for the merge."""
    lose(job, 0, 1, 2)
    done = petzval_cli("farm", "run", job, "--local", "1")
    assert done.returncode == 0, done.stderr
    assert done.stdout.count(": finished in ") == 3 and done.stdout.count("Read blend") == 2, done.stdout
    assert_same_picture(job / "pictures/small.exr", finished_job[1])


def test_parts_that_a_process_leaves_are_tried_alone(job, capsys):
    from petzval.farm import local
    from petzval.farm.job import load

    lose(job, 1, 2)
    loaded, tries = load(job), Counter()
    # It was killed at part 1: neither the part before, which is finished, nor the one behind has had a try that failed.
    for _ in range(local.TRIES - 1):
        assert local._left(loaded, [0, 1, 2], -9, tries) == [[1], [2]]
    assert local._left(loaded, [1], -9, tries) == []
    assert "part 1: given up after 3 tries, with status -9" in capsys.readouterr().err
    assert local._left(loaded, [1, 2], 1, tries) == [[2]] and local._left(loaded, [2], 0, tries) == []
    # In a row, the first being the largest.
    assert local._dealt(loaded, [0, 1, 2], 1) == [[0, 1, 2]] and local._dealt(loaded, [0, 1, 2], 9) == [[0], [1], [2]]
    assert local._dealt(loaded, [0, 1, 2], 2) == [[0], [1, 2]] and local._dealt(loaded, [], 2) == []


def test_dask(job, finished_job, petzval_cli):
    """A cluster of two workers on this machine."""
    distributed = pytest.importorskip("distributed", reason="no Dask: pip install distributed")
    lose(job, 0, 2)
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        done = petzval_cli("farm", "run", job, "--dask", cluster.scheduler_address, "--threads", "1")
    assert done.returncode == 0, done.stderr
    assert_same_picture(job / "pictures/small.exr", finished_job[1])


def test_dask_that_is_missing_is_named(job, monkeypatch, capsys):
    from petzval import cli

    monkeypatch.setitem(sys.modules, "distributed", None)
    assert cli.run_command(["farm", "run", str(job), "--dask", "tcp://127.0.0.1:1"]) == 1
    assert "pip install distributed" in capsys.readouterr().err
