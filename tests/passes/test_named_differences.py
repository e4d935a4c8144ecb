# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes that Cycles has otherwise are named after the render, and nothing is where they are not asked for."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.once


def said(parts, scene, folder) -> str:
    parts.render(folder)
    return " ".join(parts.part("render.statistics").last(scene.name).warnings)


def test_shadow_catchers_behind_volumes(parts, blender, tmp_path):
    scene = parts.set_up(8, 8, 1)
    blender.ops.mesh.primitive_plane_add(size=4.0, location=(0.0, 4.0, -1.0))
    blender.context.object.is_shadow_catcher = True
    assert not said(parts, scene, tmp_path)
    blender.ops.mesh.primitive_cube_add(location=(0.0, 3.0, 0.0))
    made, tree, surface = parts.material("Fog")
    fog = tree.nodes.new("ShaderNodeVolumeScatter")
    tree.links.new(fog.outputs[0], surface.node.inputs["Volume"])
    blender.context.object.data.materials.append(made)
    assert "shadow catchers behind volumes" in said(parts, scene, tmp_path)
