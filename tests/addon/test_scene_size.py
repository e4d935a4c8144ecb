# SPDX-License-Identifier: GPL-3.0-or-later
"""The Scale panel's measure of the scene: spans, the nearest thing in view, and what makes no sense."""

from __future__ import annotations

from math import sqrt

import pytest


@pytest.fixture
def scene(blender, parts):
    """A square of 2 units, 5 before the camera, with a lens of 50 mm."""
    made = parts.set_up(model="LENS", width=300, height=200)
    made.camera.data.petzval.lens_file = "cooke-triplet-50mm.lens"
    parts.square("Square", (0.0, 5.0, 0.0), 2.0)
    blender.context.view_layer.update()
    return made


def measured(blender, parts, scene):
    blender.context.view_layer.update()
    return parts.part("queries.scene_size").measure(scene.camera, scene, blender.context.evaluated_depsgraph_get())


def test_span_and_nearest(blender, parts, scene):
    found = measured(blender, parts, scene)
    assert found.span == pytest.approx(2.0 * sqrt(2.0), rel=1e-6) and found.nearest == pytest.approx(5.0, rel=1e-5)
    assert (found.span_mm, found.nearest_mm) == pytest.approx((found.span * 1000.0, 5000.0), rel=1e-5)
    assert found.nearest_name == "Square" and found.warnings == []
    # What is not rendered, or out of view, does not count as near; what is out of view is of the scene.
    hidden = parts.square("Hidden", (0.0, 1.0, 0.0), 0.5)
    hidden.hide_render = True
    parts.square("Behind", (0.0, -7.0, 0.0), 1.0)
    found = measured(blender, parts, scene)
    assert found.nearest_name == "Square" and found.span == pytest.approx(sqrt(12.0**2 + 8.0), rel=1e-5)


def test_the_scale_counts(blender, parts, scene):
    own = scene.camera.data.petzval
    own.scale_from_scene, own.scale = False, (10.0, 10.0, 10.0)
    found = measured(blender, parts, scene)
    assert found.nearest_mm == pytest.approx(50.0, rel=1e-5) and found.span_mm == pytest.approx(
        20.0 * sqrt(2.0), rel=1e-5
    )
    scene.unit_settings.scale_length, own.scale_from_scene = 0.01, True
    assert measured(blender, parts, scene).nearest_mm == pytest.approx(50.0, rel=1e-5)


@pytest.mark.parametrize(
    ("mm_per_unit", "words"),
    [
        (1000.0, ""),
        (1.0, "front of the lens"),
        (4.0, "half the focal length"),
        (1e6, "infinitely far"),
        (1e9, "1000 km"),
    ],
)
def test_what_makes_no_sense_is_said(blender, parts, scene, mm_per_unit, words):
    own = scene.camera.data.petzval
    own.scale_from_scene, own.scale = False, (mm_per_unit,) * 3
    said = measured(blender, parts, scene).warnings
    assert any(words in one for one in said) if words else said == []


def test_nothing_at_all(blender, parts):
    scene = parts.set_up(model="LENS")
    found = measured(blender, parts, scene)
    assert found.span is None and found.nearest is None and found.warnings == []


def test_it_is_measured_by_the_timer_once_nothing_changes(blender, parts, scene, monkeypatch):
    size = parts.part("queries.scene_size")
    size.forget()
    place = scene.camera, scene, blender.context.view_layer
    assert size.for_panel(*place) is None and blender.app.timers.is_registered(size.LOOKOUT.timer)
    size.LOOKOUT.changed_at = 0.0
    assert size.LOOKOUT.timer() is None
    assert size.for_panel(*place).is_current
    scene.objects["Square"].location.y = 6.0
    blender.context.view_layer.update()
    assert not size.for_panel(*place).is_current and size.LOOKOUT.timer() > 0.0
    size.LOOKOUT.changed_at = 0.0
    size.LOOKOUT.timer()
    found = size.for_panel(*place)
    assert found.is_current and found.nearest == pytest.approx(6.0, rel=1e-5)
    scene.camera.data.petzval.scale_from_scene = False
    assert size.for_panel(*place) is not None
    blender.app.timers.unregister(size.LOOKOUT.timer)


@pytest.mark.once
def test_lengths_are_written_for_people(blender, parts):
    scale = parts.part("ui.scale")
    assert scale.millimetres(12400.0) == "12\u2009400 mm" and scale.millimetres(0.01) == "0.0100 mm"
    units = blender.context.scene.unit_settings
    assert scale.length(12.4, units) == "12.4 m"
    units.scale_length = 0.01
    assert scale.length(12.4, units) == "12.4 cm"
    units.system = "NONE"
    assert scale.length(12.4, units) == "12.4 units"
