# SPDX-License-Identifier: GPL-3.0-or-later
"""The memory that this process takes, bytes. No bpy."""

from __future__ import annotations

import os
import sys


def used_bytes() -> int | None:
    """The memory of this process now, bytes; None where the system does not say."""
    if sys.platform == "linux":
        try:
            with open("/proc/self/statm", encoding="ascii") as file:
                return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
        except (AttributeError, OSError, ValueError, IndexError):
            return None
    return _of_windows("WorkingSetSize") if sys.platform == "win32" else None


def peak_bytes() -> int | None:
    """The largest memory of this process so far, bytes; None where the system does not say."""
    if sys.platform == "win32":
        return _of_windows("PeakWorkingSetSize")
    try:
        import resource
    except ImportError:
        return None
    # Kilobytes, but bytes on a Mac.
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit


def _of_windows(name: str) -> int | None:
    import ctypes
    from ctypes import wintypes

    # PROCESS_MEMORY_COUNTERS of psapi.h.
    sizes = ("PeakWorkingSetSize", "WorkingSetSize", "QuotaPeakPagedPoolUsage", "QuotaPagedPoolUsage",
             "QuotaPeakNonPagedPoolUsage", "QuotaNonPagedPoolUsage", "PagefileUsage", "PeakPagefileUsage")  # fmt: skip
    fields = [("cb", wintypes.DWORD), ("PageFaultCount", wintypes.DWORD), *((size, ctypes.c_size_t) for size in sizes)]
    counters = type("Counters", (ctypes.Structure,), {"_fields_": fields})()
    counters.cb = ctypes.sizeof(counters)
    kernel = ctypes.WinDLL("kernel32")
    kernel.GetCurrentProcess.restype = wintypes.HANDLE
    ask = kernel.K32GetProcessMemoryInfo
    ask.argtypes = [wintypes.HANDLE, ctypes.c_void_p, wintypes.DWORD]
    if not ask(kernel.GetCurrentProcess(), ctypes.byref(counters), counters.cb):
        return None
    return getattr(counters, name)
