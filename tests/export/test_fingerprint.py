# SPDX-License-Identifier: GPL-3.0-or-later
"""The fingerprint of what the engine is told: different things leave different marks, equal things the same."""

from __future__ import annotations

import hashlib
import itertools

import numpy as np
import pytest

pytestmark = pytest.mark.once

#: No two of these are the same to the engine.
DIFFERENT = (
    None, 1, 1.0, True, "1", b"1", (None,), (1,), (1.0,), ("1",), (b"1",), ((1,),), (1, 2), ((1,), 2), (1, (2,)), ((), 1), (1, ()),
    {"a": 1}, {"a": 1.0}, {"b": 1}, (("a", 1),), np.zeros((2, 3)), np.zeros((3, 2)), np.zeros((2, 3), np.float32), (np.zeros(6),),
    ("ab", "c"), ("a", "bc"), float("inf"), -0.0, 0.0,
)  # fmt: skip


def mark(value) -> str:
    from support import scenes as parts

    digest = hashlib.blake2b(digest_size=16)
    parts.part("data.fingerprint").feed(digest, value)
    return digest.hexdigest()


def test_different_things_leave_different_marks(blender):
    marks = [mark(value) for value in DIFFERENT]
    for (a, one), (b, other) in itertools.combinations(zip(DIFFERENT, marks, strict=True), 2):
        assert one != other, f"{a!r} and {b!r}"


def test_equal_things_leave_the_same_mark(blender):
    # Equal, but other objects: of the first both strings are one object, and of the second two.
    text = "a name"
    same, copied = (text, text, [1.0, (2.0,)]), (text, "".join(text), [float("1"), (2.0,)])
    assert copied[1] is not text and mark(same) == mark(copied)
    assert mark((1, (2.0, "x"))) == mark([1, [2.0, "x"]])
    assert mark(np.arange(6.0).reshape(2, 3).T) == mark(np.ascontiguousarray(np.arange(6.0).reshape(2, 3).T))
