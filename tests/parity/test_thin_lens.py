# SPDX-License-Identifier: GPL-3.0-or-later
"""Depth of field of a thin lens by Blender's own settings, against Cycles in the same Blender."""

from __future__ import annotations

import numpy as np
import pytest

SIDE, SAMPLES = 48, 2048

#: Of the blur of a small lamp: the diaphragm's blades, their turn, and its height over its width.
SHAPES = {
    "round": {},
    "tall": {"aperture_ratio": 2.0},
    "wide": {"aperture_ratio": 0.5},
    "three blades": {"aperture_blades": 3},
    "turned": {"aperture_blades": 3, "aperture_rotation": 0.4},
    "turned and tall": {"aperture_blades": 5, "aperture_rotation": 0.7, "aperture_ratio": 1.6},
}


@pytest.fixture
def lamps(blender, monkeypatch):
    """Small squares that glow far behind what is in focus, in the dark."""
    from support import beside_cycles
    from support import scenes as parts

    scene = parts.set_up(SIDE, SIDE, SAMPLES, model="THIN")
    scene.world = parts.grey_world(0.02)
    for x, z in ((-0.9, 0.7), (0.8, -0.8)):
        parts.square("Lamp", (x, 6.0, z), 0.4, parts.emitter((1.0, 0.8, 0.6), 10.0))
    dof = scene.camera.data.dof

    def focus() -> None:
        dof.use_dof, dof.focus_distance, dof.aperture_fstop = True, 2.0, 0.08

    # The comparison is without depth of field else.
    plain = beside_cycles.without_tricks
    monkeypatch.setattr(beside_cycles, "without_tricks", lambda samples: (plain(samples), focus()))
    focus()
    parts.dof = dof
    return parts


@pytest.mark.first_only("name")
@pytest.mark.parametrize("name", SHAPES)
def test_the_shape_of_blur(lamps, tmp_path, name):
    from support import beside_cycles

    for setting, value in SHAPES[name].items():
        setattr(lamps.dof, setting, value)
    # One sample in ten meets a lamp, fewer at the edge of the blur: seeds of either program differ by 2 % in the worst block.
    ours = beside_cycles.alike(tmp_path, SAMPLES, side=6, mean=0.015, block=0.06)
    if name != "round":
        for setting in SHAPES[name]:
            setattr(lamps.dof, setting, lamps.dof.bl_rna.properties[setting].default)
        plain = lamps.render(tmp_path, "round.exr")[..., :3]
        # No test passes because nothing happened.
        assert np.abs(ours - plain).mean() > 0.1 * plain.mean()


@pytest.mark.once
def test_blades_of_the_panel_have_a_turn_of_their_own(lamps):
    """Blender's turn is of Blender's blades."""
    own = lamps.bpy.context.scene.camera.data.petzval
    lamps.dof.aperture_blades, lamps.dof.aperture_rotation = 5, 0.7
    assert lamps.sent()[2].lens.blade_rotation_rad == pytest.approx(0.7 + np.pi / 5)
    own.blades, own.blade_rotation = 5, 0.2
    assert lamps.sent()[2].lens.blade_rotation_rad == pytest.approx(0.2)
