# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that catch shadows, against Cycles in the same Blender: the picture, its alpha, and the shadow as a pass."""

from __future__ import annotations

import numpy as np
import pytest


@pytest.fixture
def room(blender):
    import bpy

    from support import render_passes

    render_passes.room()
    bpy.data.objects["Floor"].is_shadow_catcher = True
    # What glows would light it, too.
    bpy.data.objects.remove(bpy.data.objects["Panel"])
    return render_passes


@pytest.mark.first_only("transparent", "has_pass")
@pytest.mark.parametrize(("transparent", "has_pass"), [(True, False), (True, True), (False, False), (False, True)])
def test_shadows_are_as_cycles_has_them(room, blender, tmp_path, transparent, has_pass):
    """With the pass the shadow is there alone, else it is in the picture's alpha."""
    from support import scenes

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
    assert not scenes.part("render.statistics").last("Scene").warnings


def test_an_opaque_film_is_the_transparent_one_over_the_sky(room, blender, tmp_path):
    """Cycles takes the sky away twice where the edge of a thing crosses a pixel of what catches its shadow, which leaves a dark
    seam: it lays the picture over a sky that is only there beside the thing already. Elsewhere it does as we do."""
    scene = blender.context.scene
    layer = scene.view_layers[0].cycles
    sky = 0.3
    for engine, seam in (("PETZVAL", 0.0), ("CYCLES", 1.0)):
        found = {}
        for name, transparent, has_pass in (("opaque", False, False), ("clear", True, False), ("things", True, True)):
            scene.render.film_transparent, layer.use_pass_shadow_catcher = transparent, has_pass
            found[name] = room.photograph(tmp_path / "one.exr", engine, samples=128)["Combined"]
        covered, alpha = found["things"][..., 3], found["clear"][..., 3]
        # Beyond the floor's end the sky is seen itself.
        rows = covered.shape[0] // 4
        expected = found["clear"][..., :3] + sky * (1 - alpha)[..., None]
        expected -= seam * (sky * (1 - alpha) * covered)[..., None]
        off = np.abs(expected - found["opaque"][..., :3])[:rows]
        print(engine, off.max(), covered[:rows].max())
        assert ((covered[:rows] > 0.2) & (covered[:rows] < 0.8)).any()
        # Sums of the same samples in another order. But Russian roulette goes by the noise of the picture, of which the sky is a part on an
        # opaque film alone: one path in some thousands goes on with one film and ends with the other, and brings up to 0.06. There are so
        # many samples that one such path is half of the limit.
        assert off.max() < 1e-3, engine
