# SPDX-License-Identifier: GPL-3.0-or-later
"""Open Job Description, version 2023-09 (github.com/OpenJobDescription/openjd-specifications, Template Schemas): a step of parts, and the
merge that depends on it. AWS Deadline Cloud and OpenCue take it, and `openjd run`."""

from __future__ import annotations

import json
import math
from typing import Any

from ..job import Job

#: A range of more tasks than a template may have is refused by services; parts of a step are then too many for them.
_NAME = "petzval: {name}"


def files(job: Job) -> dict[str, str]:
    """template.json; the standard takes JSON and YAML."""
    return {"template.json": json.dumps(template(job), indent=2) + "\n"}


def template(job: Job) -> dict[str, Any]:
    """The template as data."""
    command, folder = "{{Param.Petzval}}", "{{Param.JobFolder}}"
    part: dict[str, Any] = {
        "name": "Parts",
        "parameterSpace": {
            "taskParameterDefinitions": [{"name": "Part", "type": "INT", "range": f"0-{len(job.parts) - 1}"}]
        },
        "script": {
            "actions": {"onRun": _action(command, ["farm", "part", folder, "{{Task.Param.Part}}"], job.most_seconds)}
        },
    }
    if job.most_memory_mb:
        part["hostRequirements"] = {"amounts": [{"name": "amount.worker.memory", "min": math.ceil(job.most_memory_mb)}]}
    merge = {
        "name": "Merge",
        "dependencies": [{"dependsOn": "Parts"}],
        "script": {"actions": {"onRun": _action(command, ["farm", "merge", folder], None)}},
    }
    return {
        "specificationVersion": "jobtemplate-2023-09",
        "name": _NAME.format(name=job.picture)[:128],
        "description": f"{len(job.parts)} parts of {job.picture}, joined to the bits of one render",
        "parameterDefinitions": [
            {
                "name": "JobFolder",
                "type": "PATH",
                "objectType": "DIRECTORY",
                "dataFlow": "INOUT",
                "default": ".",
                "description": "The folder that petzval farm plan made",
            },
            {
                "name": "Petzval",
                "type": "STRING",
                "default": "petzval",
                "description": "The program petzval on the workers",
            },
        ],
        "steps": [part, merge],
    }


def _action(command: str, arguments: list[str], most_seconds: float | None) -> dict[str, Any]:
    action: dict[str, Any] = {
        "command": command,
        "args": arguments,
        # The first signal has a part kept; it needs some seconds for that.
        "cancelation": {"mode": "NOTIFY_THEN_TERMINATE", "notifyPeriodInSeconds": 60},
    }
    if most_seconds:
        # The part ends by itself before.
        action["timeout"] = math.ceil(most_seconds) + 300
    return action
