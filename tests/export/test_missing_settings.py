# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings that would show and are not done are named, with what has them."""

from __future__ import annotations

import pytest


@pytest.fixture
def square(parts):
    """A square in a grey world."""
    parts.set_up()
    made, *_ = parts.material("Paint")
    parts.square("Square", (0.0, 5.0, 0.0), 1.0, made)
    return made


def test_nothing_is_named_of_a_plain_scene(square, parts):
    assert not parts.sent()[1]


@pytest.mark.parametrize(
    ("holder", "setting", "named"),
    [
        ("cycles", "use_pixel_jitter", "Pixel Jitter"),
        ("render", "use_freestyle", "Freestyle"),
    ],
)
def test_it_is_named(square, blender, parts, holder, setting, named):
    own = getattr(blender.context.scene, holder)
    if not hasattr(own, setting):
        pytest.skip("this Cycles has no such setting")
    setattr(own, setting, True)
    warnings = parts.sent()[1]
    assert len(warnings) == 1 and named in warnings[0]
