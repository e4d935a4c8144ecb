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
    ("holder", "settings", "named"),
    [
        ("scene", {"texture_limit_render": "512"}, "Simplify's limit of textures"),
        ("scene", {"film_transparent_glass": True}, "Transparent Glass"),
        ("world", {"use_shadows": False}, "a sky without shadows"),
        ("world", {"max_bounces": 1}, "a limit of the bounces"),
        ("material", {"use_bump_map_correction": False}, "Material 'Paint': Bump Map Correction"),
    ],
    ids=lambda value: "" if isinstance(value, dict) else value,
)
def test_it_is_named(square, blender, parts, holder, settings, named):
    scene = blender.context.scene
    scene.render.use_simplify = scene.render.film_transparent = True
    own = {"scene": scene, "world": scene.world, "material": square}[holder].cycles
    if not all(hasattr(own, name) for name in settings):
        pytest.skip("this Cycles has no such setting")
    for name, value in settings.items():
        setattr(own, name, value)
    warnings = parts.sent()[1]
    assert len(warnings) == 1 and named in warnings[0]
