# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes of light by lobe against Cycles in the same Blender, block by block, and their sum against the picture."""

from __future__ import annotations

import numpy as np
import pytest

#: Noise is less then than these limits of the mean and of a block; with 4096 samples all but the next two agree to 0.003.
SAMPLES, LIMITS = 256, (0.025, 0.06)
#: Rough glass has sparks, whose mean is found late. Colours have no noise but that of edges.
WIDER = {"Transmission Indirect": (0.06, 0.12), "Glossy Color": (0.01, 0.02)}
NAMES = (
    "Diffuse Direct", "Diffuse Indirect", "Diffuse Color", "Glossy Direct", "Glossy Indirect", "Glossy Color",
    "Transmission Direct", "Transmission Indirect", "Transmission Color", "Volume Direct", "Volume Indirect", "Emission",
    "Environment",
)  # fmt: skip


@pytest.fixture
def room(blender):
    from support import render_passes

    scene = render_passes.room()
    render_passes.ask_for_light(scene.view_layers[0])
    return render_passes


def nothing(room):
    pass


def in_fog(room):
    room.fog((-0.4, 2.0, 0.2), 1.2, 0.8)


def behind_panes(room):
    """A pane that is half there, one of coloured air, and a thing of several lobes behind them."""
    from support import scenes as parts

    half = room.mixed("Half", 0.5, "BsdfGlossy", "BsdfTransparent", Color=(0.9, 0.8, 0.7, 1.0), Roughness=0.5)
    parts.square("Half", (-0.6, 1.4, 0.4), 0.8, half)
    parts.square("Air", (0.6, 1.2, 0.4), 0.8, room.surface("Air", "BsdfTransparent", Color=(0.4, 0.9, 0.6, 1.0)))
    lobes = room.mixed(
        "Lobes", 0.4, "BsdfPrincipled", "BsdfTranslucent", Base_Color=(0.8, 0.3, 0.2, 1.0), Coat_Weight=1.0
    )
    parts.square("Lobes", (0.3, 2.2, 0.5), 0.6, lobes)


def of_skin(room):
    import bpy

    skin = room.surface("Skin", "SubsurfaceScattering", Color=(0.8, 0.4, 0.3, 1.0), Scale=0.1)
    bpy.data.objects["Plastic"].data.materials[0] = skin


@pytest.mark.first_only("add")
@pytest.mark.parametrize("add", [nothing, in_fog, behind_panes, of_skin])
def test_each_is_as_cycles_has_it(room, blender, tmp_path, add):
    if add is of_skin and blender.app.version < (5, 0, 0):
        pytest.skip("light walks otherwise through bodies there: tests/parity/test_closures.py")
    add(room)
    ours = room.photograph(tmp_path / "petzval.exr", samples=SAMPLES)
    theirs = room.photograph(tmp_path / "cycles.exr", "CYCLES", samples=SAMPLES)
    assert ours.keys() == theirs.keys()
    for name in NAMES:
        room.same(ours, theirs, [name], *WIDER.get(name, LIMITS))
    sums_up(room, ours)


def sums_up(room, passes) -> None:
    """To the rounding of quotients and products in single precision."""
    combined = passes["Combined"][..., :3]
    assert np.abs(room.summed(passes) - combined).max() < 1e-5 * np.abs(combined).max()


@pytest.mark.parametrize("is_glass", [False, True], ids=["film", "film and glass"])
def test_the_sky_is_kept_behind_a_transparent_film(room, blender, tmp_path, is_glass):
    """As in Cycles: it is no part of the picture, and what sees it has it all the same."""
    scene = blender.context.scene
    scene.render.film_transparent = True
    scene.cycles.film_transparent_glass = is_glass
    ours = room.photograph(tmp_path / "petzval.exr", samples=SAMPLES)
    theirs = room.photograph(tmp_path / "cycles.exr", "CYCLES", samples=SAMPLES)
    assert ours["Environment"].max() > 0.01 and ours["Combined"][..., 3].min() < 0.5
    for name in ("Environment", "Transmission Direct", "Transmission Indirect", "Combined"):
        room.same(ours, theirs, [name], *WIDER.get(name, LIMITS))
