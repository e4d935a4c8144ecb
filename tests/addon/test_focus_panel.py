# SPDX-License-Identifier: GPL-3.0-or-later
"""The Focus panel's buttons and what it shows: three sharp points, what autofocus finds, and keeping it."""

from __future__ import annotations

import json
import time
from math import degrees

import pytest

from petzval import _native
from support.photograph.chart import LENSES

TRIPLET = LENSES / "cooke-triplet-50mm.lens"
DEPTH_M = 5.0


@pytest.fixture
def scene(blender):
    """A camera at the origin that looks along +y through a triplet at f/11, at a square 5 m away."""
    from support import scenes

    made = scenes.set_up(model="LENS")
    own = made.camera.data.petzval
    own.lens_file, own.wide_open, own.f_number = str(TRIPLET), False, 11.0
    scenes.square("Square", (0.0, DEPTH_M, 0.0), 1.0)
    blender.context.view_layer.update()
    return made


def empties(bpy, scene, *places):
    made = []
    for number, place in enumerate(places):
        empty = bpy.data.objects.new(f"Place {number}", None)
        empty.location = place
        scene.collection.objects.link(empty)
        made.append(empty)
    bpy.context.view_layer.update()
    return made


def choose(own, objects):
    own.sharp_object_1, own.sharp_object_2, own.sharp_object_3 = objects


def film_mm(scene) -> float:
    from support import scenes

    return scenes.part("queries.lens_info").of_camera(scene.camera, scene)["film_distance_mm"]


# Three sharp points ------------------------------------------------------------------------------------------------


def test_three_objects_turn_the_film(blender, scene):
    from support import scenes

    places = [(-0.4, 4.0, -0.3), (0.5, 5.0, -0.2), (0.1, 6.0, 0.4)]
    own = scene.camera.data.petzval
    choose(own, empties(blender, scene, *places))
    before = own.tilt, own.swing, own.focus_mode
    assert blender.ops.petzval.sharp_points() == {"FINISHED"}
    report = scenes.part("export.report").Report()
    camera = scenes.part("export.camera").describe(scene.camera, scene, 48, 32, report)
    asked = json.loads(_native.sharp_points_json(camera, 48, 32, places))
    assert own.focus_mode == "FILM" and before != (own.tilt, own.swing, own.focus_mode)
    assert abs(degrees(own.tilt)) > 0.5 and abs(degrees(own.swing)) > 0.05
    # Blender keeps settings and places in f32.
    assert own.tilt == pytest.approx(asked["tilt_rad"], rel=1e-5)
    assert own.swing == pytest.approx(asked["swing_rad"], rel=1e-5)
    assert own.film_distance == pytest.approx(asked["film_distance_mm"], rel=1e-6)


def test_the_objects_count_where_they_are_now(blender, scene):
    """Parented objects are where their parents have put them."""
    own = scene.camera.data.petzval
    objects = empties(blender, scene, (-0.4, 4.0, -0.3), (0.5, 5.0, -0.2), (0.1, 6.0, 0.4))
    choose(own, objects)
    blender.ops.petzval.sharp_points()
    alone = own.tilt, own.swing, own.film_distance
    (parent,) = empties(blender, scene, (0.0, 2.0, 0.0))
    for one in objects:
        one.parent = parent
    blender.context.view_layer.update()
    blender.ops.petzval.sharp_points()
    assert own.film_distance < alone[2]
    parent.location = (0.0, 0.0, 0.0)
    blender.context.view_layer.update()
    blender.ops.petzval.sharp_points()
    assert (own.tilt, own.swing, own.film_distance) == pytest.approx(alone, rel=1e-6)


def test_undo_brings_the_film_back(blender, scene):
    own = scene.camera.data.petzval
    choose(own, empties(blender, scene, (-0.4, 4.0, -0.3), (0.5, 5.0, -0.2), (0.1, 6.0, 0.4)))
    blender.ops.ed.undo_push(message="before")
    # An operator that Python calls makes no undo step of its own unless it is told to.
    assert blender.ops.petzval.sharp_points("EXEC_DEFAULT", True) == {"FINISHED"}
    assert own.tilt != 0.0
    blender.ops.ed.undo()
    own = blender.context.scene.camera.data.petzval
    assert (own.tilt, own.swing, own.focus_mode) == (0.0, 0.0, "CAMERA")


@pytest.mark.parametrize(
    ("places", "word"),
    [
        (((0.0, 3.0, 0.0), (0.0, 4.0, 0.0), (0.0, 5.0, 0.0)), "one line"),
        (((0.0, -3.0, 0.0), (1.0, 4.0, 0.0), (0.0, 5.0, 1.0)), "sharp point 1 of 3"),
        (((0.0, 3.0, 0.3), (1.0, 0.02, 0.0), (0.0, 5.0, 1.0)), "sharp point 2 of 3"),
    ],
)
def test_what_cannot_be_sharp_is_said(blender, scene, places, word):
    own = scene.camera.data.petzval
    choose(own, empties(blender, scene, *places))
    with pytest.raises(RuntimeError, match=word):
        blender.ops.petzval.sharp_points()
    assert (own.tilt, own.swing, own.focus_mode) == (0.0, 0.0, "CAMERA")


def test_it_asks_for_a_lens_and_three_objects(blender, scene):
    own = scene.camera.data.petzval
    objects = empties(blender, scene, (-0.4, 4.0, -0.3), (0.5, 5.0, -0.2), (0.1, 6.0, 0.4))
    choose(own, [*objects[:2], None])
    assert not blender.ops.petzval.sharp_points.poll()
    choose(own, objects)
    assert blender.ops.petzval.sharp_points.poll()
    own.model = "THIN"
    assert not blender.ops.petzval.sharp_points.poll()


def test_the_selected_objects_are_taken(blender, scene):
    own = scene.camera.data.petzval
    objects = empties(blender, scene, (-0.4, 4.0, -0.3), (0.5, 5.0, -0.2), (0.1, 6.0, 0.4))
    for one in scene.objects:
        one.select_set(one in [*objects, scene.camera])
    assert blender.ops.petzval.sharp_from_selection() == {"FINISHED"}
    assert {own.sharp_object_1, own.sharp_object_2, own.sharp_object_3} == set(objects)
    objects[0].select_set(False)
    with pytest.raises(RuntimeError, match="2 are selected"):
        blender.ops.petzval.sharp_from_selection()


# Autofocus ---------------------------------------------------------------------------------------------------------


def find(bpy, scene):
    from support import scenes

    depsgraph = bpy.context.evaluated_depsgraph_get()
    return scenes.part("queries.autofocus").find(scene.camera, scene, depsgraph)


@pytest.mark.parametrize("point", [(0.5, 0.5), (0.45, 0.55), (0.02, 0.98)])
@pytest.mark.parametrize("away", [(0.0, 0.0, 0.0), (300.0, -200.0, 50.0)])
def test_the_panel_finds_what_the_render_finds(blender, scene, point, away):
    """Blender's rays and the engine's, on one scene, far from the world's origin too."""
    from support import scenes

    for one in (scene.camera, scene.objects["Square"]):
        one.location = [a + b for a, b in zip(one.location, away, strict=True)]
    blender.context.view_layer.update()
    own = scene.camera.data.petzval
    own.focus_mode, own.autofocus_point = "AUTO", point
    found = find(blender, scene)
    assert blender.ops.render.render() == {"FINISHED"}
    rendered = scenes.part("render.statistics").last(scene.name).stats["autofocus"]
    # Both place the square in f32.
    assert found["film_distance_mm"] == pytest.approx(rendered["film_distance_mm"], rel=1e-6)
    assert (found["subject_world"] is None) == (rendered["subject_world"] is None) == (point == (0.02, 0.98))
    assert found["object_name"] == ("" if point == (0.02, 0.98) else "Square")


def test_what_a_render_does_not_show_is_looked_past(blender, scene):
    from support import scenes

    own = scene.camera.data.petzval
    own.focus_mode = "AUTO"
    near = scenes.square("Near", (0.0, 3.0, 0.0), 1.0)
    blender.context.view_layer.update()
    assert find(blender, scene)["object_name"] == "Near"
    for name in ("hide_render", "visible_camera"):
        setattr(near, name, name == "hide_render")
        blender.context.view_layer.update()
        found = find(blender, scene)
        assert found["object_name"] == "Square"
        assert found["subject_world"][1] == pytest.approx(DEPTH_M, rel=1e-5)
        setattr(near, name, name != "hide_render")


@pytest.mark.parametrize("relation", ["EXACT", "THIN"])
@pytest.mark.parametrize("anchor", ["ENTRANCE_PUPIL", "FRONT_VERTEX", "FILM"])
def test_focus_here_keeps_what_was_found(blender, scene, anchor, relation):
    camera = scene.camera.data
    own = camera.petzval
    own.anchor, own.focus_relation, own.focus_mode = anchor, relation, "AUTO"
    camera.dof.focus_object = scene.objects["Square"]
    found = find(blender, scene)
    assert blender.ops.petzval.focus_here() == {"FINISHED"}
    assert own.focus_mode == "CAMERA" and camera.dof.focus_object is None
    # Newton: aberrations move the film by a tenth of a millimetre at most, a third of what f/11 lets pass.
    assert abs(50.0**2 * (1.0 / camera.dof.focus_distance - 1.0 / DEPTH_M) / 1000.0) < 0.1
    assert found["subject_mm"] == pytest.approx(1000.0 * DEPTH_M, rel=1e-5)
    # The distance is kept in f32.
    assert film_mm(scene) == pytest.approx(found["film_distance_mm"], rel=1e-7)


def test_focus_here_where_nothing_is(blender, scene):
    own = scene.camera.data.petzval
    own.focus_mode, own.autofocus_point = "AUTO", (0.02, 0.98)
    found = find(blender, scene)
    assert found["subject_world"] is None
    assert blender.ops.petzval.focus_here() == {"FINISHED"}
    assert own.focus_mode in ("INFINITY", "FILM", "CAMERA")
    # In a corner the smallest spot of what is infinitely far may lie beside the focal plane, on either side.
    assert film_mm(scene) == pytest.approx(found["film_distance_mm"], rel=1e-6)


def test_focus_here_says_why_not(blender, scene):
    own = scene.camera.data.petzval
    own.focus_mode, own.lens_file = "AUTO", "no-such.lens"
    with pytest.raises(RuntimeError, match="no such lens"):
        blender.ops.petzval.focus_here()
    assert own.focus_mode == "AUTO"


def test_a_panel_never_looks_by_itself(blender, scene, monkeypatch):
    """It asks, gets what is known, and the timer does the work."""
    from support import scenes

    part = scenes.part("queries.autofocus")
    looks = []
    looking = part.LOOKOUT.find
    monkeypatch.setattr(part.LOOKOUT, "find", lambda *asked: looks.append(asked) or looking(*asked))
    own = scene.camera.data.petzval
    own.focus_mode = "AUTO"
    layer = blender.context.view_layer
    part.forget()
    try:
        assert part.for_panel(scene.camera, scene, layer) is None and not looks
        assert blender.app.timers.is_registered(part.LOOKOUT.timer)
        # Something has just changed: not yet.
        assert part.LOOKOUT.timer() > 0.0 and not looks
        time.sleep(part.LOOKOUT.quiet_s)
        assert part.LOOKOUT.timer() is None and len(looks) == 1
        finding = part.for_panel(scene.camera, scene, layer)
        assert finding.is_current and finding.answer["object_name"] == "Square"
        # Out of date by a setting, then by the scene; shown meanwhile.
        own.f_number = 8.0
        assert not part.for_panel(scene.camera, scene, layer).is_current
        part.LOOKOUT.changed_at = 0.0
        part.LOOKOUT.timer()
        assert part.for_panel(scene.camera, scene, layer).is_current and len(looks) == 2
        scene.objects["Square"].location.y = 4.0
        layer.update()
        finding = part.for_panel(scene.camera, scene, layer)
        assert not finding.is_current and finding.answer["object_name"] == "Square"
        part.LOOKOUT.changed_at = 0.0
        part.LOOKOUT.timer()
        finding = part.for_panel(scene.camera, scene, layer)
        assert finding.is_current and finding.answer["subject_world"][1] == pytest.approx(4.0, rel=1e-5)
        assert len(looks) == 3
    finally:
        if blender.app.timers.is_registered(part.LOOKOUT.timer):
            blender.app.timers.unregister(part.LOOKOUT.timer)


def test_rays_that_fail_are_told(scene):
    """An exception in the caller's rays comes back as it was."""
    from support import scenes

    own = scene.camera.data.petzval
    own.focus_mode = "AUTO"
    report = scenes.part("export.report").Report()
    camera = scenes.part("export.camera").describe(scene.camera, scene, 48, 32, report)

    def fails(_origin, _direction):
        raise ZeroDivisionError("on purpose")

    with pytest.raises(ZeroDivisionError, match="on purpose"):
        _native.autofocus_by_json(camera, 48, 32, (0.5, 0.5), fails)
    with pytest.raises(TypeError):
        _native.autofocus_by_json(camera, 48, 32, (0.5, 0.5), lambda *_: "far")


# Words -------------------------------------------------------------------------------------------------------------


def test_everything_has_a_tooltip(blender, scene):
    for holder in (scene.petzval, scene.camera.data.petzval):
        for one in holder.bl_rna.properties:
            if one.identifier in ("rna_type", "name"):
                continue
            assert one.description, one.identifier
            if one.type == "ENUM":
                assert all(item.description for item in one.enum_items), one.identifier
    for name in dir(blender.ops.petzval):
        assert getattr(blender.ops.petzval, name).get_rna_type().description, name
