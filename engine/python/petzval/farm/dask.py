# SPDX-License-Identifier: GPL-3.0-or-later
"""`petzval farm run --dask ADDRESS`: the parts of a job on the workers of a Dask cluster, which have Petzval and see the job's folder, then
the merge. Dask's package `distributed` is asked for here alone."""

from __future__ import annotations

import subprocess
from pathlib import Path

from ..errors import CommandError, complain
from . import job as jobs
from .local import TRIES, command, may_try_again


class PartFailed(Exception):
    """A part that another try may finish."""


def part(folder: str, number: int, blender: str | None, threads: int | None) -> int:
    """Renders a part on a worker; its exit status. Raises `PartFailed` where it should be tried again."""
    own = command(Path(folder), "part", str(number), blender=blender, threads=threads)
    done = subprocess.run(own, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace", check=False)
    if may_try_again(done.returncode):
        raise PartFailed(f"part {number} ended with status {done.returncode}: {done.stderr.strip()[-500:]}")
    if done.returncode:
        raise RuntimeError(f"part {number} cannot be rendered: {done.stderr.strip()[-500:]}")
    return 0


def run(folder: Path, address: str, *, blender: str | None, threads: int | None) -> int:
    """Renders all parts that are not finished on the cluster, and merges here; the exit status of the merge."""
    job = jobs.load(folder)
    try:
        from distributed import Client, as_completed
    except ImportError:
        raise CommandError("Dask is not installed in this Python: pip install distributed") from None
    try:
        client = Client(address)
    except (OSError, ValueError) as error:
        raise CommandError(f"no Dask cluster at {address}: {error}") from None
    with client:
        due = [number for number in range(len(job.parts)) if not job.is_done(number)]
        # The first parts are the largest: they are to begin first.
        futures = {
            client.submit(
                part, str(folder.absolute()), number, blender, threads,
                key=f"petzval-{folder.absolute()}-{number}", retries=TRIES - 1, priority=-number, pure=False,
            ): number
            for number in due
        }  # fmt: skip
        for future in as_completed(futures):
            if future.status == "error":
                complain(f"given up: {future.exception()}")
    return subprocess.run(command(folder, "merge", blender=blender), stdin=subprocess.DEVNULL, check=False).returncode
