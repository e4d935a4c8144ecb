# SPDX-License-Identifier: GPL-3.0-or-later
"""Faces that lie on each other in the picture are named, with their objects and how much of the picture shows them; others are not."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.once

#: A second square, and what is said of both.
SECOND = {
    "the same place": ((0.0, 5.0, 0.0), 1.0, "'Square': faces of it and of 'Twin' lie on each other"),
    "partly over it": ((0.5, 5.0, 0.0), 1.0, "'Square': faces of it and of 'Twin' lie on each other"),
    "a millimetre behind": ((0.0, 5.001, 0.0), 1.0, None),
    "beside it": ((1.0, 5.0, 0.0), 1.0, None),
    "a hair over the edge": ((0.998, 5.0, 0.0), 1.0, None),
}


@pytest.mark.parametrize("name", SECOND)
def test_what_lies_on_each_other_is_named(blender, tmp_path, name):
    import petzval
    from support import scenes as parts

    place, size, said = SECOND[name]
    scene = parts.set_up(96, 64, 1)
    grey = parts.emitter((0.5, 0.5, 0.5), 1.0)
    parts.square("Square", (0.0, 5.0, 0.0), 1.0, grey)
    parts.square("Twin", place, size, grey)
    parts.render(tmp_path)
    texts = [one.text for one in petzval.load_addon().render.messages.all_of(scene.name)]
    found = [text for text in texts if "lie on each other" in text]
    assert bool(found) == bool(said), texts
    if said:
        assert said in found[0] and "% of the picture" in found[0]


def test_an_object_on_itself_is_named_alone(blender, tmp_path):
    """As after a Mirror modifier across its own middle."""
    import petzval
    from support import scenes as parts

    scene = parts.set_up(96, 64, 1)
    parts.square("Square", (0.0, 5.0, 0.0), 1.0, parts.emitter((0.5, 0.5, 0.5), 1.0))
    blender.data.objects["Square"].modifiers.new("Mirror", "MIRROR").use_mirror_merge = False
    parts.render(tmp_path)
    texts = [one.text for one in petzval.load_addon().render.messages.all_of(scene.name)]
    assert any("'Square': faces of it lie on each other" in text for text in texts), texts
