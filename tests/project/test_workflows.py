# SPDX-License-Identifier: GPL-3.0-or-later
"""The workflow file for real machines of every system: its form, and that what it calls is there."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import platforms
import pytest

from support.places import ROOT, SCENES

pytestmark = pytest.mark.once

WORKFLOWS = sorted((ROOT / ".github/workflows").glob("*.yml"))
#: Words in which a job and a step are written, by GitHub's reference of workflow syntax.
JOB = {"name", "runs-on", "needs", "if", "permissions", "strategy", "steps", "timeout-minutes", "defaults", "env"}
STEP = {
    "name",
    "uses",
    "run",
    "with",
    "env",
    "if",
    "shell",
    "id",
    "working-directory",
    "continue-on-error",
    "timeout-minutes",
}
RUNNERS = {
    "linux-x64": "ubuntu-24.04", "linux-arm64": "ubuntu-24.04-arm", "windows-x64": "windows-2022", "windows-arm64": "windows-11-arm",
    "macos-x64": "macos-15-intel", "macos-arm64": "macos-15",
}  # fmt: skip


def read(file: Path) -> dict[str, Any]:
    """A YAML file, by the environment of the docs, which has a reader. `on` is a truth value of YAML."""
    python = ROOT / ".venv-docs/bin/python"
    if not python.exists():
        pytest.skip("no .venv-docs: run tools/setup-python.sh docs")
    program = "import json, sys, yaml; print(json.dumps(yaml.safe_load(sys.stdin)))"
    done = subprocess.run([python, "-c", program], input=file.read_text(), capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


@pytest.fixture(params=WORKFLOWS, ids=lambda file: file.name)
def jobs(request) -> dict[str, Any]:
    return read(request.param)["jobs"]


def steps(jobs: dict[str, Any]) -> list[dict[str, Any]]:
    return [step for job in jobs.values() for step in job["steps"]]


def test_there_is_one():
    assert [file.name for file in WORKFLOWS] == ["systems.yml"]


def test_jobs_and_steps_are_well_formed(jobs):
    for name, job in jobs.items():
        assert not set(job) - JOB and job["runs-on"] and job["steps"], name
        needs = job.get("needs", [])
        assert set([needs] if isinstance(needs, str) else needs) <= set(jobs), name
    for step in steps(jobs):
        assert not set(step) - STEP and ("run" in step) != ("uses" in step), step
        assert re.fullmatch(r"actions/[\w-]+@v\d+", step.get("uses", "actions/x@v1")), "GitHub's own actions alone"


def test_each_job_runs_on_the_systems_that_it_names(jobs):
    assert set(jobs["engine"]["strategy"]["matrix"]["system"]) == set(RUNNERS.values())
    rows = jobs["installed"]["strategy"]["matrix"]["include"]
    assert {row["platform"]: row["system"] for row in rows} == RUNNERS
    assert set(RUNNERS) == set(platforms.PLATFORMS)
    assert all(platforms.PLATFORMS[row["platform"]].tag == row["wheel"] for row in rows)


def test_commands_are_shell_and_what_they_call_is_there(jobs):
    targets = set(re.findall(r"^([a-z][a-z-]*):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    for step in steps(jobs):
        if "run" not in step:
            continue
        command = re.sub(r"\$\{\{.*?\}\}", "x", step["run"])
        assert subprocess.run(["bash", "-n"], input=command, text=True, check=False).returncode == 0, command
        for target in re.findall(r"\bmake ([a-z-]+)", command):
            assert target in targets, target
        for file in re.findall(r"\b(?:tools|tests)/[\w./-]+", command):
            assert (ROOT / file).exists(), file


def test_values_of_expressions_are_there(jobs):
    text = "\n".join(file.read_text() for file in WORKFLOWS)
    rows = jobs["installed"]["strategy"]["matrix"]["include"]
    for name in re.findall(r"matrix\.(\w+)", text):
        assert name == "system" or all(name in row for row in rows), name
    uploaded = {step["with"]["name"] for step in steps(jobs) if "upload-artifact" in step.get("uses", "")}
    assert {step["with"]["name"] for step in steps(jobs) if "download-artifact" in step.get("uses", "")} <= uploaded


@pytest.mark.skipif(shutil.which("actionlint") is None, reason="no actionlint: install it")
def test_the_linter_finds_nothing():
    done = subprocess.run(["actionlint", *map(str, WORKFLOWS)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


def test_what_is_installed_is_tried(tmp_path):
    """The step that real machines run, here."""
    pytest.importorskip("bpy")
    command = [sys.executable, ROOT / "tools/installed.py", SCENES / "demo.blend"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert (
        len(re.findall(r"^ok ", done.stdout, re.MULTILINE)) >= 7
        and "WRONG" not in done.stdout
        and "renders" in done.stdout
    )
