# SPDX-License-Identifier: GPL-3.0-or-later
"""Flamenco 3: a job type, a JavaScript file for the Manager's folder `scripts`. A task for each part, and the merge that waits for all.

Flamenco's interpreter of JavaScript (goja) copies a task when it is added to the job: dependencies are named before that.
"""

from __future__ import annotations

import json

from ..job import Job

_SCRIPT = """\
// SPDX-License-Identifier: GPL-3.0-or-later
// A job of petzval farm plan: each part is a task, and the merge waits for all of them.
// Put this file into the folder "scripts" beside the Flamenco Manager and restart it.

const JOB_TYPE = {{
    label: "Petzval: one picture on many machines",
    description: "Renders the parts of a folder that petzval farm plan made, and joins them.",
    settings: [
        {{ key: "job_folder", type: "string", subtype: "dir_path", required: true, visible: "submission",
          description: "Folder that petzval farm plan made, as the Workers see it" }},
        {{ key: "first_part", type: "int32", required: true, default: 0, propargs: {{ min: 0 }}, visible: "submission",
          description: "Number of the first part that is rendered" }},
        {{ key: "part_count", type: "int32", required: true, default: {count}, propargs: {{ min: 1 }}, visible: "submission",
          description: "How many parts are rendered; {picture} has {count}" }},
        {{ key: "petzval", type: "string", required: true, default: "petzval", visible: "submission",
          description: "The program petzval on the Workers" }},
        {{ key: "threads", type: "int32", required: true, default: 0, propargs: {{ min: 0, max: 1024 }}, visible: "submission",
          description: "Threads for each part; 0: one for each core" }},
    ]
}};

function compileJob(job) {{
    const settings = job.settings;
    if (!settings.job_folder) {{
        throw "no job folder: name the one that petzval farm plan made";
    }}
    const threads = settings.threads > 0 ? ["--threads", String(settings.threads)] : [];
    const merge = author.Task("merge", "misc");
    merge.addCommand(author.Command("exec", {{
        exe: settings.petzval,
        args: ["farm", "merge", settings.job_folder],
    }}));
    for (let i = 0; i < settings.part_count; i++) {{
        const part = String(settings.first_part + i);
        const task = author.Task("part-" + part, "misc");
        task.addCommand(author.Command("exec", {{
            exe: settings.petzval,
            args: ["farm", "part", settings.job_folder, part].concat(threads),
        }}));
        // Before the tasks are added: that copies them.
        merge.addDependency(task);
        job.addTask(task);
    }}
    job.addTask(merge);
}}
"""


def files(job: Job) -> dict[str, str]:
    """The job type, and the body of the HTTP call that submits it."""
    submission = {
        "name": job.picture,
        "type": "petzval-farm",
        "submitter_platform": "linux",
        "priority": 50,
        "settings": {
            "job_folder": "PUT THE FOLDER HERE",
            "first_part": 0,
            "part_count": len(job.parts),
            "petzval": "petzval",
            "threads": 0,
        },
        "metadata": {"project": "petzval"},
    }
    # Quotes in a name would end the text of JavaScript.
    picture = json.dumps(job.picture)[1:-1]
    return {
        "petzval-farm.js": _SCRIPT.format(count=len(job.parts), picture=picture),
        "flamenco-job.json": json.dumps(submission, indent=2) + "\n",
    }
