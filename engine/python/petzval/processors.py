# SPDX-License-Identifier: GPL-3.0-or-later
"""Which of the wheel's engines is for this processor.

A wheel for Linux on x86-64 holds the engine several times, each compiled for one of the levels that the processors'
makers agreed on: `_engines/LEVEL/_native.abi3.so`. Other wheels hold one engine, for every processor of their kind, and
need nothing of this.

What the processor can do the kernel says: /proc/cpuinfo needs no other package, and leaves out what the kernel has not
switched on, such as the wide registers. numpy knows too, but under a private name, and it would have to be loaded first.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Iterable
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


class ProcessorError(ImportError):
    """There is an engine, but none for this processor, or not the one wished for. One line: what, where, what to do."""


def engine_file() -> Path:
    """The compiled module to load. Raises `ImportError`, or a `ProcessorError`, where there is none."""
    files = {file.parent.name: file for file in sorted((_PACKAGE / "_engines").glob("*/_native.abi3.so"))}
    if not files:
        raise ImportError(f"there is no compiled module in {_PACKAGE}")
    return files[choose(files, flags_of_this_processor(), os.environ.get(WISH, ""))]


def flags_of_this_processor() -> frozenset[str] | None:
    """What the first processor can do; None where the kernel does not say. All of a machine are alike."""
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
        if lacking := _lacking(level, flags):
            raise ProcessorError(f"{WISH} is '{wish}': this processor lacks {_words(lacking)}: unset it")
        return level
    fitting = [level for level in held if not _lacking(level, flags)]
    if not fitting:
        raise ProcessorError(
            f"this processor lacks {_words(_lacking(held[0], flags))}, and the wheel's engines begin at {held[0]}: "
            "build one for it, by `RUSTFLAGS=-Ctarget-cpu=native pip install .` in Petzval's source"
        )
    return fitting[-1] if flags is not None else held[0]


def _lacking(level: str, flags: Collection[str] | None) -> set[str]:
    """What a processor of these flags lacks for a level; nothing where they are not known."""
    if flags is None:
        return set()
    names = list(LEVELS)
    return set().union(*(LEVELS[name] for name in names[: names.index(level) + 1])) - set(flags)


def _words(flags: Iterable[str]) -> str:
    return ", ".join(sorted(flags))
