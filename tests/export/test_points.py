# SPDX-License-Identifier: GPL-3.0-or-later
"""Point clouds, as the engine is told of them."""

from __future__ import annotations

import numpy as np
import pytest


def _cloud(blender, parts, places, radii=(0.2, 0.3), name: str = "Cloud"):
    """A mesh of loose vertices that nodes make points of, with a colour `paint`."""
    from parity_scenes import points

    made = points.holder_of(np.array(places, np.float32), radii, name)
    blender.context.scene.collection.objects.link(made)
    glow, tree, surface = parts.material("Painted")
    colour = tree.nodes.new("ShaderNodeAttribute")
    colour.attribute_name = "paint"
    emission = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(colour.outputs["Color"], emission.inputs["Color"])
    tree.links.new(emission.outputs[0], surface)
    return points.nodes_on(made, points._as_points(glow))


def test_points_of_nodes(parts, blender):
    """Places, radii and what is asked for; one of the same data for all instances; hidden as surfaces are not."""
    places = [(0.0, 5.0, 0.0), (1.0, 6.0, 0.5)]
    made = _cloud(blender, parts, places)
    blender.context.view_layer.use_solid = False
    recorder, warnings, _ = parts.sent()
    assert not warnings
    (sent,) = recorder.points.values()
    assert np.allclose(sent["points"], np.c_[places, [0.2, 0.3]])
    assert set(sent["attributes"]) == {"paint"} and sent["attributes"]["paint"].shape == (2, 4)
    assert sent["moved_points"] is None and sent["poses"] is None
    (placed,) = recorder.of("Cloud")
    assert recorder.materials[placed["materials"][0]].name == "Painted"
    made.hide_render = True
    recorder, _, _ = parts.sent()
    assert not recorder.points


def test_points_without_radius(parts, blender):
    if not hasattr(blender.types.PointCloud, "resize"):
        pytest.skip("this Blender's points cannot be made by script")
    data = blender.data.pointclouds.new("Points")
    data.resize(2)
    data.attributes["position"].data.foreach_set("vector", [0.0, 1.0, 2.0, 3.0, 4.0, 5.0])
    blender.context.scene.collection.objects.link(blender.data.objects.new("Points", data))
    blender.context.scene.collection.objects.link(
        blender.data.objects.new("Empty", blender.data.pointclouds.new("Empty"))
    )
    recorder, warnings, _ = parts.sent()
    assert not warnings
    (sent,) = recorder.points.values()
    assert np.allclose(sent["points"], [(0, 1, 2, 0.01), (3, 4, 5, 0.01)])


def test_a_bad_point_is_named(parts, blender, tmp_path):
    _cloud(blender, parts, [(0.0, 4.0, 0.0), (0.0, 4.0, np.nan)], (1.0, 1.0))
    picture = parts.render(tmp_path)
    assert np.isfinite(picture).all()
    colour = blender.data.objects["Cloud"].data.attributes["paint"].data[0].color
    assert picture[16, 24, :3] == pytest.approx(list(colour)[:3], abs=1e-3)
    warnings = parts.part("render.statistics").last("Scene").warnings
    assert any("1 of 2 are not finite" in line for line in warnings), warnings
