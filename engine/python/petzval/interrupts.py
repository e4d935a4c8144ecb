# SPDX-License-Identifier: GPL-3.0-or-later
"""Ctrl-C and SIGTERM while a command works with Blender.

The first signal asks a render to stop and to keep its samples; before there is a render to ask, it ends the process. A later
signal ends the process at once. Nothing half written stays.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Callable

#: Exit status of a command that was broken off.
INTERRUPTED = 130
# A terminal and the program before this one may both hand on one Ctrl-C; only a later one means: at once.
_ONE_KEYPRESS_SECONDS = 1.0
#: The signals that break a command off; Windows has Ctrl-Break too.
SIGNALS: tuple[signal.Signals, ...] = (signal.SIGINT, signal.SIGTERM)
if sys.platform == "win32":
    SIGNALS += (signal.SIGBREAK,)


class _Listener:
    """The handler of interrupt signals in this process."""

    def __init__(self) -> None:
        self.is_listening = False
        #: Asks the render to stop; None: there is none.
        self.stop: Callable[[], None] | None = None
        #: The time of the first request, in seconds of the monotonic clock.
        self._first: float | None = None
        self._voice = 2

    def start(self) -> None:
        self.is_listening = True
        # Blender's own words take the place of stderr later.
        self._voice = os.dup(2)

    def heard(self, *_: object) -> None:
        now = time.monotonic()
        if self.stop is None:
            self._leave(b"petzval: broken off before the first sample: nothing was written\n")
        elif self._first is None:
            self._first = now
            self.stop()
        elif now - self._first > _ONE_KEYPRESS_SECONDS:
            self._leave(b"")

    def _leave(self, words: bytes) -> None:
        files = sys.modules.get("petzval.atomic_files")
        if files is not None:
            files.abandon_all()
        if words:
            os.write(self._voice, words)
        os._exit(INTERRUPTED)


_listener = _Listener()


def end_at_ctrl_c() -> None:
    """Ends the process at Ctrl-C, without a word, until `raise_at_ctrl_c` or `listen`: while modules are imported, nothing is
    there to be cleaned up."""
    if _is_handled_by(signal.default_int_handler):
        signal.signal(signal.SIGINT, _end)


def raise_at_ctrl_c() -> None:
    """Raises KeyboardInterrupt at Ctrl-C again, as Python does by itself."""
    if _is_handled_by(_end):
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _is_handled_by(handler: object) -> bool:
    """True if Ctrl-C calls `handler`. A handler that a host program or a parent process has set stays."""
    return signal.getsignal(signal.SIGINT) is handler


def _end(*_: object) -> None:
    os._exit(INTERRUPTED)


def listen() -> None:
    """Hears signals from now on, in a thread of its own: whatever Blender does with signals when it is imported, and while the main
    thread is inside Blender. Called before bpy is imported; of several calls the first counts."""
    if _listener.is_listening:
        return
    _listener.start()
    if sys.platform == "win32":
        _listen_to_console()
        return
    # Threads that start later inherit the mask.
    signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)

    def wait() -> None:
        while True:
            signal.sigwait(SIGNALS)
            _listener.heard()

    threading.Thread(target=wait, name="petzval signals", daemon=True).start()


def listen_by_handlers() -> None:
    """Hears signals from now on where other threads run already, as inside of a Blender program."""
    if not _listener.is_listening:
        _listener.start()
    if sys.platform == "win32":
        _listen_to_console()
        return
    for number in SIGNALS:
        signal.signal(number, _listener.heard)


if sys.platform == "win32":
    #: The callbacks of the console, kept while it may call them.
    _console_calls: list[object] = []

    def _listen_to_console() -> None:
        """Has the console call, in a thread of its own: Python's handlers run in the main thread, which may be inside Blender."""
        import ctypes

        def heard(_event: int) -> int:
            _listener.heard()
            return 1

        _console_calls.append(call := ctypes.WINFUNCTYPE(ctypes.c_int, ctypes.c_uint)(heard))
        ctypes.WinDLL("kernel32").SetConsoleCtrlHandler(call, 1)


def ask(stop: Callable[[], None]) -> None:
    """The first signal from now on calls `stop`."""
    _listener.stop = stop
