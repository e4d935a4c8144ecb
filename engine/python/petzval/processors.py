# SPDX-License-Identifier: GPL-3.0-or-later
"""The choice among the wheel's engines for this processor.

A wheel for x86-64 holds the engine several times, each compiled for one of the levels that the processors' makers agreed
on: `_engines/LEVEL/_native.abi3.so`, on Windows `_native.pyd`. Other wheels hold one engine, for every processor of their
kind, and need nothing of this.

The flags of the processor come from the system: that needs no other package, and leaves out features that the system has not enabled,
such as the wide registers. numpy knows too, but under a private name, and it would have to be loaded first.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import sys
from collections.abc import Callable, Collection, Iterable
from pathlib import Path

#: Each level, and the flags of /proc/cpuinfo that it adds to the one before.
LEVELS = {
    "x86-64-v2": {"cx16", "lahf_lm", "pni", "popcnt", "sse4_1", "sse4_2", "ssse3"},
    "x86-64-v3": {"abm", "avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "movbe", "xsave"},
    "x86-64-v4": {"avx512bw", "avx512cd", "avx512dq", "avx512f", "avx512vl"},
}
#: The environment variable that overrules the choice, for tests and comparisons: x86-64-v2, or short v2.
WISH = "PETZVAL_PROCESSOR"

_PACKAGE = Path(__file__).resolve().parent
_CPUINFO = Path("/proc/cpuinfo")
#: Names of compiled modules, by the system.
MODULES = ("_native.abi3.so", "_native.pyd")
#: Flags by the numbers of `IsProcessorFeaturePresent` (winnt.h). Windows has a number for AVX2 and none for the flags that came with it: no
#: processor on which Windows 10 runs has the one without the others.
_WINDOWS_FEATURES = {
    13: {"pni"}, 14: {"cx16", "lahf_lm", "popcnt"}, 36: {"ssse3"}, 37: {"sse4_1"}, 38: {"sse4_2"}, 39: {"avx", "xsave"},
    40: {"abm", "avx2", "bmi1", "bmi2", "f16c", "fma", "movbe"}, 41: {"avx512bw", "avx512cd", "avx512dq", "avx512f", "avx512vl"},
}  # fmt: skip
_SSE4_2 = 38
#: The names of flags by `sysctl` on a Mac, where they are not the names in small letters.
_MAC_NAMES = {"sse3": "pni", "sse4.1": "sse4_1", "sse4.2": "sse4_2", "avx1.0": "avx", "lahf": "lahf_lm", "lzcnt": "abm"}
_MAC_LISTS = ("machdep.cpu.features", "machdep.cpu.extfeatures", "machdep.cpu.leaf7_features")


class ProcessorError(ImportError):
    """The error of an installation without an engine for this processor, or without the one wished for. One line: the fault, its place, the
    remedy."""


def engine_file() -> Path:
    """The compiled module to load. Raises `ImportError`, or a `ProcessorError`, where there is none."""
    files = engines()
    if not files:
        raise ImportError(f"there is no compiled module in {_PACKAGE}")
    return files[choose(files, flags_of_this_processor(), os.environ.get(WISH, ""))]


def engines() -> dict[str, Path]:
    """The compiled modules of the package by their levels; none where it has one for all."""
    return {file.parent.name: file for name in MODULES for file in sorted((_PACKAGE / "_engines").glob(f"*/{name}"))}


def has_one_engine() -> bool:
    """True if a compiled module lies beside the package's files: Python loads it before any other."""
    return any((_PACKAGE / name).exists() for name in MODULES)


def flags_of_this_processor() -> frozenset[str] | None:
    """The flags of the first processor; None where the system does not say. All of a machine are alike."""
    if sys.platform == "win32":
        return _flags_by_windows(ctypes.WinDLL("kernel32").IsProcessorFeaturePresent)
    if sys.platform == "darwin":
        return _flags_by_sysctl(_sysctl)
    return _flags_by_cpuinfo()


def _flags_by_windows(is_present: Callable[[int], int]) -> frozenset[str] | None:
    # Before its version 2004 Windows knew no number above that of CMPXCHG16B.
    if not is_present(_SSE4_2):
        return None
    return frozenset().union(*(flags for number, flags in _WINDOWS_FEATURES.items() if is_present(number)))


def _flags_by_sysctl(ask: Callable[[str], str]) -> frozenset[str] | None:
    words = [word.lower() for name in _MAC_LISTS for word in ask(name).split()]
    # XSAVE is there, but it counts where the system has switched it on.
    words = ["" if word == "xsave" else "xsave" if word == "osxsave" else word for word in words]
    return frozenset(_MAC_NAMES.get(word, word) for word in words if word) or None


def _sysctl(name: str) -> str:
    """A text of the Mac's kernel; empty where it has none of this name."""
    length = ctypes.c_size_t(4096)
    text = ctypes.create_string_buffer(length.value)
    with contextlib.suppress(OSError, AttributeError):
        if ctypes.CDLL(None).sysctlbyname(name.encode(), text, ctypes.byref(length), None, ctypes.c_size_t(0)) == 0:
            return text.value.decode("ascii", errors="replace")
    return ""


def _flags_by_cpuinfo() -> frozenset[str] | None:
    try:
        with _CPUINFO.open(encoding="ascii", errors="replace") as lines:
            for line in lines:
                name, _, value = line.partition(":")
                if name.strip() == "flags":
                    return frozenset(value.split())
    except OSError:
        pass
    return None


def choose(engines: Collection[str], flags: Collection[str] | None, wish: str = "") -> str:
    """The best of these levels that a processor of these flags can run, or the one wished for.

    Where the flags are not known it is the lowest: Blender itself asks for as much of a processor as x86-64-v2.
    """
    held = [level for level in LEVELS if level in engines]
    if not held:
        raise ProcessorError(f"engines for {', '.join(engines)}, which nobody here knows: install the wheel again")
    if wish:
        level = wish if wish.startswith("x86-64-") else f"x86-64-{wish}"
        if level not in held:
            raise ProcessorError(f"{WISH} is '{wish}': there are engines for {', '.join(held)}: name one, or unset it")
        if missing := lacking(level, flags):
            raise ProcessorError(f"{WISH} is '{wish}': this processor lacks {_words(missing)}: unset it")
        return level
    fitting = [level for level in held if not lacking(level, flags)]
    if not fitting:
        raise ProcessorError(
            f"this processor lacks {_words(lacking(held[0], flags))}, and the wheel's engines begin at {held[0]}: "
            "build one for it, by `RUSTFLAGS=-Ctarget-cpu=native pip install .` in Petzval's source"
        )
    return fitting[-1] if flags is not None else held[0]


def lacking(level: str, flags: Collection[str] | None) -> set[str]:
    """The flags of a level that a processor with these flags lacks; empty where they are not known."""
    if flags is None:
        return set()
    names = list(LEVELS)
    return set().union(*(LEVELS[name] for name in names[: names.index(level) + 1])) - set(flags)


def _words(flags: Iterable[str]) -> str:
    return ", ".join(sorted(flags))
