# SPDX-License-Identifier: GPL-3.0-or-later
"""The choice among the wheel's engines for a processor."""

from __future__ import annotations

import pytest

from petzval import processors
from petzval.processors import ProcessorError, choose

pytestmark = pytest.mark.once

V2 = processors.LEVELS["x86-64-v2"] | {"sse", "sse2"}
V3 = V2 | processors.LEVELS["x86-64-v3"]
V4 = V3 | processors.LEVELS["x86-64-v4"]
BOTH = ["x86-64-v3", "x86-64-v2"]
ALL = ["x86-64-v4", *BOTH]


@pytest.mark.parametrize(
    ("engines", "flags", "best"),
    [
        (BOTH, V2, "x86-64-v2"),
        (BOTH, V3, "x86-64-v3"),
        (BOTH, V4, "x86-64-v3"),
        (ALL, V4, "x86-64-v4"),
        (ALL, V3, "x86-64-v3"),
        # Wide registers without the rest, as a careful virtual machine or a kernel may have it.
        (ALL, V4 - {"avx2"}, "x86-64-v2"),
        (ALL, V4 - {"fma"}, "x86-64-v2"),
        # The kernel does not say: nothing is risked.
        (ALL, None, "x86-64-v2"),
        (["x86-64-v3"], V3, "x86-64-v3"),
    ],
)
def test_the_best_that_runs(engines, flags, best):
    assert choose(engines, flags) == best


@pytest.mark.parametrize("wish", ["v2", "x86-64-v2"])
def test_a_wish_overrules(wish):
    assert choose(ALL, V4, wish) == "x86-64-v2"


def test_a_wish_counts_where_the_kernel_says_nothing():
    assert choose(ALL, None, "v3") == "x86-64-v3"


@pytest.mark.parametrize("wish", ["v4", "v9", "3", "x86-64", "native"])
def test_a_wish_for_what_is_not_there(wish):
    with pytest.raises(ProcessorError, match=f"PETZVAL_PROCESSOR is '{wish}'.*x86-64-v2, x86-64-v3.*unset"):
        choose(BOTH, V4, wish)


def test_a_wish_beyond_the_processor():
    with pytest.raises(ProcessorError, match="PETZVAL_PROCESSOR is 'v3'.*lacks avx2, movbe: unset it"):
        choose(BOTH, V3 - {"avx2", "movbe"}, "v3")


def test_an_old_processor_is_told_what_to_do():
    with pytest.raises(ProcessorError, match=r"lacks sse4_2, and.*begin at x86-64-v2.*pip install"):
        choose(BOTH, V2 - {"sse4_2"})


@pytest.mark.parametrize(
    ("text", "flags"),
    [
        ("processor\t: 0\nflags\t\t: fpu sse2 avx\nvmx flags\t: vnmi\n\nprocessor\t: 1\nflags\t\t: fpu\n", {"fpu", "sse2", "avx"}),
        ("processor\t: 0\nFeatures\t: fp asimd\n", None),
        ("", None),
    ],
)  # fmt: skip
def test_what_the_kernel_says(tmp_path, monkeypatch, text, flags):
    file = tmp_path / "cpuinfo"
    file.write_text(text)
    monkeypatch.setattr(processors, "_CPUINFO", file)
    assert processors._flags_by_cpuinfo() == flags


def test_a_kernel_that_does_not_say(tmp_path, monkeypatch):
    monkeypatch.setattr(processors, "_CPUINFO", tmp_path / "none")
    assert processors._flags_by_cpuinfo() is None


def test_windows_numbers_its_features():
    old = {10, 13, 14}
    v2 = old | {36, 37, 38}
    assert processors._flags_by_windows(lambda number: number in old) is None, "it knows no newer numbers"
    assert choose(ALL, processors._flags_by_windows(lambda number: number in v2)) == "x86-64-v2"
    assert choose(ALL, processors._flags_by_windows(lambda number: number in v2 | {39, 40})) == "x86-64-v3"
    assert choose(ALL, processors._flags_by_windows(lambda number: number in v2 | {39, 40, 41})) == "x86-64-v4"


#: The output of `sysctl` on a Mac of 2015, and of 2012.
FEATURES = (
    "FPU VME DE PSE TSC MSR PAE MCE CX8 APIC SEP MTRR PGE MCA CMOV PAT PSE36 CLFSH DS ACPI MMX FXSR SSE SSE2 SS HTT TM PBE SSE3 PCLMULQDQ "
    "DTES64 MON DSCPL VMX EST TM2 SSSE3 CX16 TPR PDCM SSE4.1 SSE4.2 x2APIC POPCNT AES PCID XSAVE OSXSAVE TSCTMR AVX1.0 RDRAND F16C"
)
MAC_2015 = {
    "machdep.cpu.features": FEATURES.replace("SSSE3", "SSSE3 FMA").replace("x2APIC", "x2APIC MOVBE"),
    "machdep.cpu.extfeatures": "SYSCALL XD 1GBPAGE EM64T LAHF LZCNT PREFETCHW RDTSCP TSCI",
    "machdep.cpu.leaf7_features": "RDWRFSGS TSC_THREAD_OFFSET BMI1 AVX2 SMEP BMI2 ERMS INVPCID FPU_CSDS",
}
MAC_2012 = {"machdep.cpu.features": FEATURES, "machdep.cpu.extfeatures": "SYSCALL XD EM64T LAHF RDTSCP TSCI"}


@pytest.mark.parametrize(
    ("told", "best"),
    [(MAC_2015, "x86-64-v3"), (MAC_2012, "x86-64-v2"), ({}, "x86-64-v2")],
    ids=["2015", "2012", "silent"],
)
def test_a_mac_names_its_features(told, best):
    assert choose(ALL, processors._flags_by_sysctl(lambda name: told.get(name, ""))) == best


@pytest.mark.parametrize(("system", "best"), [("win32", "x86-64-v3"), ("darwin", "x86-64-v3")])
def test_each_system_is_asked_in_its_way(monkeypatch, system, best):
    class Library:
        def __init__(self, _name):
            pass

        @staticmethod
        def IsProcessorFeaturePresent(number):  # noqa: N802
            return number < 41

    monkeypatch.setattr(processors.sys, "platform", system)
    monkeypatch.setattr(processors.ctypes, "WinDLL", Library, raising=False)
    monkeypatch.setattr(processors, "_sysctl", lambda name: MAC_2015[name])
    assert choose(ALL, processors.flags_of_this_processor()) == best
