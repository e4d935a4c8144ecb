# SPDX-License-Identifier: GPL-3.0-or-later
"""Jobs inside of bpy, begun anew where Blender crashes or takes too long."""

from __future__ import annotations

import json
import os
import queue
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

TOP = Path(__file__).resolve().parents[2]
#: A question that takes longer, s, is given up.
LONGEST_S = 180.0
MARK = "settings-walk: "


class Worker:
    """A process with bpy that answers questions one after the other."""

    def __init__(self, samples: int) -> None:
        self.samples = samples
        self.process: subprocess.Popen[str] | None = None

    def _begin(self) -> subprocess.Popen[str]:
        folders = [
            TOP / "tools",
            TOP / "tests",
            TOP / "tests" / "scenes",
            *filter(None, [os.environ.get("PYTHONPATH")]),
        ]
        return subprocess.Popen(
            [sys.executable, "-m", "settings_walk.job", str(self.samples)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            errors="replace",
            env={**os.environ, "PYTHONPATH": os.pathsep.join(map(str, folders))},
        )

    def ask(self, question: dict[str, Any]) -> Any:
        """The answer; `{"failed": WHY}` where Blender has none, and another process for the next question."""
        self.process = self.process or self._begin()
        process, is_late = self.process, threading.Event()
        assert process.stdin is not None and process.stdout is not None

        def end() -> None:
            is_late.set()
            process.kill()

        late = threading.Timer(LONGEST_S, end)
        late.start()
        try:
            asked = {key: value for key, value in question.items() if key in {"walk", "set", "context", "look"}}
            process.stdin.write(json.dumps(asked) + "\n")
            process.stdin.flush()
            for line in process.stdout:
                if line.startswith(MARK):
                    return json.loads(line.removeprefix(MARK))
        except BrokenPipeError:
            pass
        finally:
            late.cancel()
        process.wait()
        self.process = None
        return {"failed": f"no answer after {LONGEST_S:.0f} s" if is_late.is_set() else "Blender crashed"}

    def close(self) -> None:
        if self.process is not None:
            self.process.kill()
            self.process.wait()


def all_asked(questions: list[dict[str, Any]], samples: int, told: Callable[[dict[str, Any], Any], None]) -> None:
    """Asks all by as many processes as there are processors; `told` hears each answer, one after the other."""
    waiting: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
    for question in questions:
        waiting.put(question)
    lock = threading.Lock()

    def work() -> None:
        worker = Worker(samples)
        try:
            while True:
                try:
                    question = waiting.get_nowait()
                except queue.Empty:
                    return
                answer = worker.ask(question)
                with lock:
                    told(question, answer)
        finally:
            worker.close()

    threads = [threading.Thread(target=work) for _ in range(min(os.cpu_count() or 1, max(len(questions), 1)))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
