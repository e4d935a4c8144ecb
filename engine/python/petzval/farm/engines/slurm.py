# SPDX-License-Identifier: GPL-3.0-or-later
"""Slurm: an array of parts, and the merge when all of them have ended."""

from __future__ import annotations

import math

from ..job import Job

#: Slurm's own limit for an array is MaxArraySize, 1001 by default; a longer one is sent in several.
_LONGEST_ARRAY = 1000

_PART = """\
#!/bin/sh
#SBATCH --job-name=petzval-part
#SBATCH --output=work/slurm-%A_%a.log
#SBATCH --open-mode=append
#SBATCH --requeue
# Asked to stop a minute before the time is over: the part is kept, and goes on where it was.
#SBATCH --signal=TERM@60
{limits}# One task of an array: part OFFSET + SLURM_ARRAY_TASK_ID of the job in the folder from which it was sent.
PETZVAL="${{PETZVAL:-petzval}}"
part=$(( ${{OFFSET:-0}} + SLURM_ARRAY_TASK_ID ))
$PETZVAL farm part . "$part" ${{SLURM_CPUS_PER_TASK:+--threads "$SLURM_CPUS_PER_TASK"}} </dev/null &
child=$!
trap 'kill -TERM $child' TERM
wait $child
status=$?
trap - TERM
# The signal ends the wait, not the part.
if kill -0 $child 2>/dev/null; then
  wait $child
  status=$?
fi
# 75 and more than 128: another try may help.
if {{ [ $status -eq 75 ] || [ $status -gt 128 ]; }} && [ "${{SLURM_RESTART_COUNT:-0}}" -lt 3 ]; then
  scontrol requeue "${{SLURM_ARRAY_JOB_ID}}_${{SLURM_ARRAY_TASK_ID}}" && exit 0
fi
exit $status
"""

_MERGE = """\
#!/bin/sh
#SBATCH --job-name=petzval-merge
#SBATCH --output=work/slurm-merge-%j.log
PETZVAL="${PETZVAL:-petzval}"
exec $PETZVAL farm merge . </dev/null
"""

_SUBMIT = """\
#!/bin/sh
# Sends this job to Slurm: ./submit.sh [OPTIONS OF sbatch FOR THE PARTS, such as --cpus-per-task=16 --partition=render]
# PETZVAL is the command on the nodes, "petzval" by default. The folder must be one that all nodes see.
cd "$(dirname "$0")" || exit 1
after=
{arrays}# Also where a part has failed: it joins what is there and names what is missing.
sbatch --parsable --dependency="afterany$after" merge.sbatch.sh
"""


def files(job: Job) -> dict[str, str]:
    """The array's script, that of the merge, and the one that sends both."""
    limits = ""
    if job.most_seconds:
        # Slurm counts in minutes; the part itself ends in time.
        limits += f"#SBATCH --time={math.ceil(job.most_seconds / 60.0) + 5}\n"
    if job.most_memory_mb:
        limits += f"#SBATCH --mem={math.ceil(job.most_memory_mb)}M\n"
    arrays = ""
    for offset in range(0, len(job.parts), _LONGEST_ARRAY):
        last = min(len(job.parts) - offset, _LONGEST_ARRAY) - 1
        arrays += (
            f'id=$(OFFSET={offset} sbatch --parsable --export=ALL --array=0-{last} "$@" part.sbatch.sh) || exit 1\n'
        )
        # A cluster's name may follow.
        arrays += 'after="$after:${id%%;*}"\n'
    return {
        "part.sbatch.sh": _PART.format(limits=limits),
        "merge.sbatch.sh": _MERGE,
        "submit.sh": _SUBMIT.format(arrays=arrays),
    }
