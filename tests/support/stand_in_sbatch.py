#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A stand-in for Slurm's sbatch and scontrol: runs a job at once, task by task, and honours what a script asks for by arrays, dependencies,
exported variables and requeueing. Called by the name of either, with the folder of its jobs in STAND_IN_SLURM."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

_FOLDER = Path(os.environ["STAND_IN_SLURM"])
_MOST_RESTARTS = 5


def options_of(script: Path, words: list[str]) -> dict[str, str]:
    """The options in the script's head, and those of the command, which go before."""
    lines = script.read_text().splitlines()
    head = [line.split(None, 1)[1] for line in lines if line.startswith("#SBATCH ")]
    given = {}
    for word in [*head, *words]:
        name, _, value = word.removeprefix("--").partition("=")
        given[name] = value
    return given


def run(script: Path, environment: dict[str, str], log: Path) -> int:
    """Runs a task as often as it asks to be requeued; the exit status of its last run."""
    requeued = _FOLDER / "requeued"
    for restart in range(_MOST_RESTARTS):
        requeued.unlink(missing_ok=True)
        with log.open("a") as out:
            own = environment | ({"SLURM_RESTART_COUNT": str(restart)} if restart else {})
            status = subprocess.run(["sh", str(script)], env=own, stdout=out, stderr=out, check=False).returncode
        if not requeued.exists():
            break
    return status


def sbatch(words: list[str]) -> None:
    place = next(i for i, word in enumerate(words) if not word.startswith("-"))
    script = Path(words[place])
    options = options_of(script, words[:place])
    known = json.loads((_FOLDER / "jobs.json").read_text()) if (_FOLDER / "jobs.json").exists() else {}
    number = str(100 + len(known))
    kind, *needed = options.get("dependency", "afterany").split(":")
    if kind != "afterany" or not all(one in known for one in needed):
        sys.exit(f"sbatch: error: Job dependency problem: {options.get('dependency')}")
    base = os.environ | {"SLURM_JOB_ID": number}
    base |= {"SLURM_CPUS_PER_TASK": options["cpus-per-task"]} if "cpus-per-task" in options else {}
    statuses = {}
    if "array" in options:
        first, last = map(int, options["array"].split("-"))
        # In no order that anybody promised.
        for task in reversed(range(first, last + 1)):
            own = base | {"SLURM_ARRAY_JOB_ID": number, "SLURM_ARRAY_TASK_ID": str(task)}
            log = Path(options["output"].replace("%A", number).replace("%a", str(task)))
            statuses[task] = run(script, own, log)
    else:
        statuses[0] = run(script, base, Path(options["output"].replace("%j", number)))
    known[number] = {"options": options, "statuses": statuses}
    (_FOLDER / "jobs.json").write_text(json.dumps(known))
    print(f"{number};cluster" if "parsable" in options else f"Submitted batch job {number}")


def main() -> None:
    """Does what the command of this file's name does."""
    if Path(sys.argv[0]).name == "scontrol":
        assert sys.argv[1] == "requeue", sys.argv
        (_FOLDER / "requeued").write_text(sys.argv[2])
        return
    sbatch(sys.argv[1:])


if __name__ == "__main__":
    main()
