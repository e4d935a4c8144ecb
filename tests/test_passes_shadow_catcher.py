# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that catch shadows, against Cycles in the same Blender: the picture, its alpha, and the shadow as a pass."""

from __future__ import annotations

import numpy as np
import pytest


@pytest.fixture
def room(blender):
    import bpy

    import pass_parts

    pass_parts.room()
    bpy.data.objects["Floor"].is_shadow_catcher = True
    # What glows would light it, too.
    bpy.data.objects.remove(bpy.data.objects["Panel"])
    return pass_parts


@pytest.mark.parametrize(("transparent", "has_pass"), [(True, False), (True, True), (False, False), (False, True)])
def test_shadows_are_as_cycles_has_them(room, blender, tmp_path, transparent, has_pass):
    """With the pass the shadow is there alone, else it is in the picture's alpha."""
    import scene_parts

    scene = blender.context.scene
    scene.render.film_transparent, scene.view_layers[0].cycles.use_pass_shadow_catcher = transparent, has_pass
    ours = room.photograph(tmp_path / "petzval.exr", samples=256)
    theirs = room.photograph(tmp_path / "cycles.exr", "CYCLES", samples=256)
    assert ours.keys() == theirs.keys()
    for name in ours:
        a, b = room.blocks(ours[name]), room.blocks(theirs[name])
        off = np.abs(a - b)
        print(name, off.max((0, 1)), a.mean((0, 1)), b.mean((0, 1)))
        # Their quotients have more noise than pictures have.
        assert off.max() < 0.03 and np.abs(a.mean((0, 1)) - b.mean((0, 1))).max() < 0.008, name
    assert not scene_parts.part("statistics").last("Scene").warnings
