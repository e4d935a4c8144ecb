# SPDX-License-Identifier: GPL-3.0-or-later
"""The profile of real scenes: what `perf` and the symbolizer print is read as it is meant."""

from __future__ import annotations

from collections import Counter

import cpu_profile as profile
import pytest

SCRIPT = """\
 4711.000100: PERF_RECORD_MMAP2 12/12: [0x7f0000001000(0x5000) @ 0x2000 08:01 77 0]: r-xp /opt/petzval/_native.abi3.so
 4711.000200: PERF_RECORD_MMAP2 12/12: [0x7f1000000000(0x1000) @ 0 08:01 78 0]: r-xp /usr/lib/libm.so.6
 4711.200000:   cpu-clock:      7f1000000010 (/usr/lib/libm.so.6)
 4711.100000:   cpu-clock:      7f0000001234 (/opt/petzval/_native.abi3.so)
 4711.300000:   cpu-clock:  ffffffff81000000 ([kernel.kallsyms])
"""


def test_looks_are_read_in_their_order_with_the_parts_of_the_engine_in_memory():
    starts, looks = profile.read(SCRIPT, "_native.abi3.so")
    assert starts == [(0x7F0000001000, 0x5000, 0x2000)]
    assert [look.file for look in looks] == ["_native.abi3.so", "libm.so.6", "[kernel.kallsyms]"]
    assert looks[0].address == 0x7F0000001234 and looks[0].second == pytest.approx(4711.1)


def test_what_is_inlined_counts_for_the_file_it_was_written_in():
    of_library = {"FileName": "/cargo/glam-0.30/src/vec3.rs", "FunctionName": "glam::Vec3::dot", "Line": 7}
    inner = {"FileName": "/src/engine/render/src/lights/tree.rs", "FunctionName": "a::LightTree<T>::sample", "Line": 31}  # fmt: skip
    outer = {"FileName": "/src/engine/render/src/integrator/path/wave.rs", "FunctionName": "b::scatter", "Line": 9}
    found = profile.own([of_library, inner, outer])
    assert found == profile.Source("render/src/lights/tree.rs", "LightTree::sample", 31)
    assert profile.own([of_library]).file == ""


def test_shares_are_of_all_cores_and_waiting_counts():
    looks = Counter({
        profile.Source("render/src/accel/node.rs", "", 1): 30,
        profile.Source("render/src/scene/texture.rs", "", 1): 10,
        profile.Source("render/src/scene/mesh.rs", "", 1): 5,
        profile.Source("denoise/src/lib.rs", "", 1): 2,
        profile.NOWHERE: 3,
    })  # fmt: skip
    found = profile.shares(looks, libraries=25, idle=25)
    assert sum(found.values()) == pytest.approx(1.0)
    assert {part: round(100 * share) for part, share in found.items() if share} == {
        "trees": 30,
        "nodes, textures": 10,
        "points hit": 5,
        "other": 5,
        profile.LIBRARIES: 25,
        profile.WAITING: 25,
    }
