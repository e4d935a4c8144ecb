# SPDX-License-Identifier: GPL-3.0-or-later
"""Dask: a script that sends the parts to a cluster's workers."""

from __future__ import annotations

from ..job import Job

_SCRIPT = """\
#!/bin/sh
# Renders this job on a Dask cluster: ./dask.sh tcp://SCHEDULER:8786
# The workers have Petzval and the same version of `distributed`, and see this folder under the same name.
job=$(cd "$(dirname "$0")" && pwd) || exit 1
exec ${PETZVAL:-petzval} farm run "$job" --dask "${1:?name the address of the scheduler}"
"""


def files(job: Job) -> dict[str, str]:
    """dask.sh."""
    del job
    return {"dask.sh": _SCRIPT}
