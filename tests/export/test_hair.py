# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair of particles and hair curves, as the engine is told of them."""

from __future__ import annotations

import numpy as np
import pytest


def test_hair_of_particles(parts, blender):
    """Children stand for their parents; each system has its own material; the emitter may be hidden."""
    blender.ops.mesh.primitive_plane_add()
    made = blender.context.object
    for name in ("Skin", "Hair"):
        made.data.materials.append(blender.data.materials.new(name))
    for number, settings in enumerate(({"count": 7}, {"count": 3, "child_type": "SIMPLE", "rendered_child_count": 5})):
        made.modifiers.new("Hair", "PARTICLE_SYSTEM")
        hair = made.particle_systems[number].settings
        hair.type, hair.render_step, hair.material = "HAIR", 2, 2 - number
        hair.root_radius, hair.tip_radius, hair.radius_scale, hair.use_close_tip = 1.0, 0.5, 0.1, number == 1
        for name, value in settings.items():
            setattr(hair, name, value)
    made.location = (0.0, 5.0, 0.0)
    made.show_instancer_for_render = False
    recorder, warnings, _ = parts.sent()
    assert not warnings
    first, second = recorder.curves.values()
    assert [len(one["first_keys"]) - 1 for one in (first, second)] == [7, 15]
    assert (first["first_number"], second["first_number"]) == (0, 7)
    keys = first["keys"].reshape(7, 5, 4)
    assert np.allclose(keys[:, 0, 2], 0.0, atol=1e-5) and np.ptp(keys[:, 0, :2]) > 0.5
    assert np.allclose(keys[:, [0, -1], 3], [[0.05, 0.025]] * 7)
    assert (second["keys"].reshape(15, 5, 4)[:, -1, 3] == 0.0).all()
    assert first["uv_maps"]["UVMap"].shape == (7, 2)
    # A root's place in the plane is its place in the map.
    assert np.allclose(first["uv_maps"]["UVMap"], keys[:, 0, :2] / 2 + 0.5, atol=1e-4)
    placed = recorder.of("Plane")
    assert [recorder.materials[one["materials"][0]].name for one in placed] == ["Hair", "Skin"]


def test_hair_curves(parts, blender):
    data = blender.data.hair_curves.new("Strands")
    data.add_curves([3, 2])
    places = np.arange(15, dtype=np.float32).reshape(5, 3)
    data.attributes["position"].data.foreach_set("vector", places.ravel())
    data.attributes.new("radius", "FLOAT", "POINT").data.foreach_set("value", [0.1, 0.2, 0.3, 0.4, 0.5])
    data.attributes.new("surface_uv_coordinate", "FLOAT2", "CURVE").data.foreach_set("vector", [0.1, 0.2, 0.3, 0.4])
    blender.context.scene.collection.objects.link(blender.data.objects.new("Strands", data))
    blender.context.scene.cycles_curves.subdivisions = 1
    recorder, warnings, _ = parts.sent()
    assert not warnings
    (sent,) = recorder.curves.values()
    assert np.allclose(sent["keys"], np.c_[places, [0.1, 0.2, 0.3, 0.4, 0.5]])
    assert sent["first_keys"].tolist() == [0, 3, 5]
    assert (sent["shape"], sent["pieces"]) == ("RIBBON", 3)
    assert np.allclose(sent["uv_maps"]["surface_uv_coordinate"], [[0.1, 0.2], [0.3, 0.4]])
    assert len(recorder.of("Strands")) == 1
    empty = blender.data.objects.new("Empty", blender.data.hair_curves.new("Empty"))
    blender.context.scene.collection.objects.link(empty)
    recorder, warnings, _ = parts.sent()
    assert len(recorder.curves) == 1 and not warnings
    blender.context.view_layer.use_strand = False
    recorder, _, _ = parts.sent()
    assert not recorder.curves and not recorder.instances


def test_a_bad_strand_is_named(parts, blender, tmp_path):
    data = blender.data.hair_curves.new("Strands")
    data.add_curves([2, 2])
    places = np.array([(0, 4, -1), (0, 4, np.nan), (0, 4, -1), (0, 4, 1)], np.float32)
    data.attributes["position"].data.foreach_set("vector", places.ravel())
    data.attributes.new("radius", "FLOAT", "POINT").data.foreach_set("value", [0.5] * 4)
    data.materials.append(parts.emitter())
    blender.context.scene.collection.objects.link(blender.data.objects.new("Strands", data))
    picture = parts.render(tmp_path)
    assert np.isfinite(picture).all()
    assert picture[16, 24, :3] == pytest.approx([1.0] * 3, abs=1e-3)
    warnings = parts.part("render.statistics").last("Scene").warnings
    assert any("'Strands': 1 of 2 strands" in line for line in warnings), warnings
