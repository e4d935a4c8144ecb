# SPDX-License-Identifier: GPL-3.0-or-later
"""A shell script: every part that is not finished, several at a time if asked to, then the merge."""

from __future__ import annotations

from ..job import Job

_SCRIPT = """\
#!/bin/sh
# Renders the {count} parts of this job and joins them: ./run.sh [PARTS AT A TIME]
# Run again after an interruption: what is finished is not rendered again. On several machines that share the folder each can run it with
# PARTS="0 1 2" for its own parts. PETZVAL is the command, "petzval" by default; it may have several words.
job=$(cd "$(dirname "$0")" && pwd) || exit 1
export job
export PETZVAL="${{PETZVAL:-petzval}}"
PARTS="${{PARTS:-$(seq 0 {last})}}"

# 75 and more than 128: another try may help.
printf '%s\\n' $PARTS | xargs -n 1 -P "${{1:-1}}" sh -c '
  for try in 1 2 3; do
    $PETZVAL farm part "$job" "$0" </dev/null
    status=$?
    if [ $status -ne 75 ] && [ $status -le 128 ]; then break; fi
  done
  # Others go on; the merge names what is missing.
  exit 0'
exec $PETZVAL farm merge "$job"
"""


def files(job: Job) -> dict[str, str]:
    """run.sh."""
    return {"run.sh": _SCRIPT.format(count=len(job.parts), last=len(job.parts) - 1)}
