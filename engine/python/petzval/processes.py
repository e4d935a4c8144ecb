# SPDX-License-Identifier: GPL-3.0-or-later
"""Programs that are started, handed open files, and asked to end. Windows has no signals between processes: there it is Ctrl-Break, to
programs that share this one's console; and files go by their handles instead of their numbers."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from typing import Any

#: The first exit status by which Windows says that a program has crashed (NTSTATUS).
_CRASHED = 0xC0000000
_POLL_S = 0.05


def own_group() -> dict[str, Any]:
    """The arguments of `subprocess.Popen` that start a program in a group of its own: a terminal's Ctrl-C comes to this process alone."""
    if sys.platform == "win32":
        return {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
    return {"start_new_session": True}


def ask_to_end(process: subprocess.Popen[bytes]) -> None:
    """Asks a program to keep its work, and to end. On Windows it must have a group of its own; where it shares no console with this
    process, it ends at once."""
    if sys.platform != "win32":
        process.send_signal(signal.SIGTERM)
        return
    try:
        process.send_signal(signal.CTRL_BREAK_EVENT)
    except OSError:
        process.kill()


def signal_group(process: subprocess.Popen[bytes], number: int) -> None:
    """Hands a signal on to a program of `own_group` and to all that it has started."""
    if sys.platform == "win32":
        ask_to_end(process)
        return
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, number)


def end_group(process: subprocess.Popen[bytes]) -> None:
    """Ends a program of `own_group` and all that it has started, at once."""
    if sys.platform == "win32":
        # It ends the whole tree, where `kill` ends the program alone.
        subprocess.run(["taskkill", "/F", "/T", "/PID", str(process.pid)], capture_output=True, check=False)
        process.kill()
        return
    signal_group(process, signal.SIGKILL)


def wait(process: subprocess.Popen[bytes]) -> int:
    """Waits for a program's end; its exit status. Signals to this process are handled meanwhile, on Windows too."""
    if sys.platform != "win32":
        return process.wait()
    while (status := process.poll()) is None:
        time.sleep(_POLL_S)
    return status


def has_crashed(status: int) -> bool:
    """True if this exit status is no answer of a program, but says that it was killed or has crashed."""
    return status < 0 or status >= _CRASHED


def handed_down(*descriptors: int) -> tuple[dict[str, Any], list[int]]:
    """The arguments of `subprocess.Popen` that hand open files to a program, and the numbers by which `taken_over` finds them there."""
    if sys.platform == "win32":
        import msvcrt

        handles = [msvcrt.get_osfhandle(descriptor) for descriptor in descriptors]
        for handle in handles:
            os.set_handle_inheritable(handle, True)
        return {"startupinfo": subprocess.STARTUPINFO(lpAttributeList={"handle_list": handles})}, handles
    return {"pass_fds": descriptors}, list(descriptors)


def taken_over(number: int) -> int:
    """The descriptor, for writing, of a file that was handed down to this process."""
    if sys.platform == "win32":
        import msvcrt

        return msvcrt.open_osfhandle(number, os.O_WRONLY)
    return number


def has_byte(pipe: int) -> bool:
    """True if something was ever written into a pipe, of which nothing is read."""
    if sys.platform == "win32":
        import ctypes
        import msvcrt

        waiting = ctypes.c_ulong(0)
        handle = ctypes.c_void_p(msvcrt.get_osfhandle(pipe))
        is_open = ctypes.WinDLL("kernel32").PeekNamedPipe(handle, None, 0, None, ctypes.byref(waiting), None)
        return bool(is_open) and waiting.value > 0
    import select

    return bool(select.select([pipe], [], [], 0.0)[0])


def keep_own_voice() -> None:
    """Keeps stdout and stderr for Python alone from here on: output of other code of the process, as Blender's, must not stand in the
    answer."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for name, descriptor in (("stdout", 1), ("stderr", 2)):
        getattr(sys, name).flush()
        setattr(sys, name, os.fdopen(os.dup(descriptor), "w", encoding="utf-8", errors="replace"))
        os.dup2(nowhere, descriptor)
    os.close(nowhere)
