# SPDX-License-Identifier: GPL-3.0-or-later
"""Which of the wheel's engines is picked for which processor."""

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
    assert processors.flags_of_this_processor() == flags


def test_a_kernel_that_does_not_say(tmp_path, monkeypatch):
    monkeypatch.setattr(processors, "_CPUINFO", tmp_path / "none")
    assert processors.flags_of_this_processor() is None
