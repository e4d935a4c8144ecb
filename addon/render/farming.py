# SPDX-License-Identifier: GPL-3.0-or-later
"""A render on a farm, from Blender: the job is planned, handed to a scheduler, and merged as its parts come. All by `petzval farm` in processes
of their own, so that Blender stays free. No bpy."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO

from petzval import processes

#: Between two looks at the parts that have come, s.
LOOK_S = 3.0
_HTTP_S = 20.0
#: The ways to hand a job to each scheduler: words of `petzval farm`, or a script of the job's folder.
SENDS = ("LOCAL", "DASK", "SHELL", "SLURM", "FLAMENCO", "OPENJD")


class FarmError(Exception):
    """The message is one line for the user."""


@dataclass
class Asked:
    """The user's request: command, scene, folder, parts."""

    #: The command `petzval` as words.
    command: list[str]
    environment: dict[str, str]
    #: Words that name the Blender in which it runs.
    blender: list[str]
    scene: str
    folder: Path
    engine: str
    parts: int
    #: The frames, such as 1-250; empty: the frame of the file.
    frames: str = ""
    #: Parts at a time on this machine.
    at_a_time: int = 1
    #: The address of Dask's scheduler, or Flamenco's Manager.
    address: str = ""


@dataclass
class FarmRun:
    """One render on a farm, looked at now and then."""

    asked: Asked
    #: Told of each picture that was merged.
    show: Callable[[Path], None] = lambda _: None
    #: The current step, for the status.
    status: str = ""
    is_done: bool = False
    _process: subprocess.Popen[bytes] | None = None
    _merging: subprocess.Popen[bytes] | None = None
    #: The last process' stderr.
    _said: IO[bytes] | None = None
    _is_sent: bool = False
    _seen: set[str] = field(default_factory=set)
    _next_look: float = 0.0

    def advance(self) -> None:
        """Advances the job by a step; raises `FarmError` where it cannot."""
        if self._process is not None and not self._is_sent:
            if self._process.poll() is None:
                return
            self._ended(self._process, "planned")
            self._process = None
        if not (self.asked.folder / "job.json").is_file():
            self._plan()
        elif not self._is_sent:
            self._send()
            self._is_sent = True
        else:
            self._look()

    def stop(self) -> None:
        """Asks the processes on this machine to keep their work, and to end. Jobs of a scheduler go on."""
        for process in (self._process, self._merging):
            if process is not None and process.poll() is None:
                processes.ask_to_end(process)

    def _plan(self) -> None:
        own = self.asked
        self.status = "Packing the scene"
        words = ["plan", own.scene, "--parts", str(own.parts), "-o", str(own.folder), "--passes", *own.blender]
        words += ["--frames", own.frames] if own.frames else []
        if own.engine != "LOCAL":
            words += ["--for", own.engine.lower()]
        self._process = self._start([*own.command, "farm", *words])

    def _send(self) -> None:
        own = self.asked
        job = str(own.folder)
        if own.engine == "LOCAL":
            words = ["farm", "run", job, "--local", str(own.at_a_time), *own.blender]
            self._process = self._start([*own.command, *words])
        elif own.engine == "DASK":
            self._process = self._start([*own.command, "farm", "run", job, "--dask", own.address, *own.blender])
        elif own.engine == "SHELL":
            self._process = self._start(["sh", str(own.folder / "run.sh"), str(own.at_a_time)])
        elif own.engine == "SLURM":
            self._process = self._start(["sh", str(own.folder / "submit.sh")])
        elif own.engine == "FLAMENCO":
            self._submit()

    def _submit(self) -> None:
        """Hands the job to a Manager of Flamenco."""
        told = json.loads((self.asked.folder / "flamenco-job.json").read_text(encoding="utf-8"))
        told["settings"]["job_folder"] = str(self.asked.folder)
        address = f"{self.asked.address.rstrip('/')}/api/v3/jobs"
        if not address.startswith(("http://", "https://")):
            raise FarmError(f"{self.asked.address}: name the Manager's address, such as http://manager:8080")
        data, header = json.dumps(told).encode(), {"Content-Type": "application/json"}
        try:
            with urllib.request.urlopen(urllib.request.Request(address, data, header), timeout=_HTTP_S):
                pass
        except urllib.error.HTTPError as error:
            raise FarmError(f"{address} refuses the job: {error.read(300).decode(errors='replace')}") from None
        except (OSError, ValueError) as error:
            raise FarmError(f"{address} cannot be reached: {error}") from None

    def _look(self) -> None:
        """Merges the finished parts; ends when all are."""
        is_over = self._process is None or self._process.poll() is not None
        if self._merging is not None:
            if self._merging.poll() is None:
                return
            whole = self._merging.returncode == 0
            if self._merging.returncode not in (0, 75):
                self._ended(self._merging, "merged")
            self._merging = None
            for picture in sorted((self.asked.folder / "pictures").glob("[!.]*")):
                self.show(picture)
            if whole:
                self.is_done = True
                return
        if self._process is not None and is_over and self._process.returncode not in (0, 75):
            self._ended(self._process, "rendered")
        now = time.monotonic()
        if now < self._next_look:
            return
        self._next_look = now + LOOK_S
        there = {file.name for file in (self.asked.folder / "parts").glob("*.json")}
        count = len(json.loads((self.asked.folder / "job.json").read_text(encoding="utf-8"))["parts"])
        self.status = f"{len(there)} of {count} parts"
        if there != self._seen:
            self._seen = there
            self._merging = self._start(
                [*self.asked.command, "farm", "merge", str(self.asked.folder), *self.asked.blender]
            )

    def _start(self, words: list[str]) -> subprocess.Popen[bytes]:
        if self._said is not None:
            self._said.close()
        self._said = tempfile.TemporaryFile()  # noqa: SIM115 (read when the process has ended)
        return subprocess.Popen(
            words,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=self._said,
            env=os.environ | self.asked.environment,
            # On Windows none can be asked to end but a group.
            **(processes.own_group() if sys.platform == "win32" else {}),
        )

    def _ended(self, process: subprocess.Popen[bytes], what: str) -> None:
        """Raises `FarmError` where a process did not end well."""
        if process.returncode == 0:
            return
        said = ""
        if self._said is not None:
            self._said.seek(0)
            said = self._said.read().decode(errors="replace")
        lines = [line for line in said.splitlines() if line.startswith("petzval: ")]
        raise FarmError(
            lines[-1].removeprefix("petzval: ") if lines else f"nothing was {what}: status {process.returncode}"
        )
