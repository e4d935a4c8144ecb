# SPDX-License-Identifier: GPL-3.0-or-later
"""The drawing of a camera's focus in 3D views: the geometry, without a screen. The window itself: test_window.py."""

from __future__ import annotations

from importlib import import_module
from math import radians

import pytest


@pytest.fixture
def overlay(blender):
    import petzval

    bpy = blender
    scene = bpy.context.scene
    scene.render.engine = "PETZVAL"
    bpy.ops.object.camera_add(location=(1.0, -6.0, 1.6), rotation=(radians(80.0), 0.0, radians(20.0)))
    scene.camera = bpy.context.object
    own = scene.camera.data.petzval
    own.lens_file, own.wide_open, own.f_number = "double-gauss-f2-tronnier.lens", False, 8.0
    scene.camera.data.dof.focus_distance = 4.0
    bpy.context.view_layer.update()
    return import_module(f"{petzval.load_addon().__name__}.drawing.overlay"), bpy


def test_the_surface_of_focus_is_where_the_camera_is_focused(overlay):
    """Across the axis at the focus distance, between its limits; and it fills the camera's frame."""
    part, bpy = overlay
    holder = bpy.context.scene.camera
    answer = part.of_camera(holder, bpy.context.scene)
    to_camera = holder.matrix_world.inverted()
    found = {which: part.surface(answer, which) for which in ("near", "sharp", "far")}
    middle = (part.ROWS // 2) * part.COLUMNS + part.COLUMNS // 2
    near, sharp, far = (-(to_camera @ found[which][middle]).z for which in ("near", "sharp", "far"))
    # Spherical aberration puts the least spot a little nearer than paraxial rays meet: here by 1.2 %.
    assert sharp == pytest.approx(4.0, rel=0.02)
    assert near < sharp < far
    # The frame's half width at that distance: by Blender's own camera, which was set to the lens's picture.
    corner = to_camera @ found["sharp"][0]
    view = [to_camera @ holder.matrix_world @ one for one in holder.data.view_frame(scene=bpy.context.scene)]
    own = holder.data
    assert own.petzval.in_step
    wanted = min(one.x / -one.z for one in view)
    # Distortion of a double Gauss at its corner.
    assert corner.x / -corner.z == pytest.approx(wanted, rel=0.03)
    assert len(part.pupil(answer, holder)) > 20


def test_it_is_asked_anew_only_where_the_camera_changed(overlay):
    part, bpy = overlay
    holder = bpy.context.scene.camera
    first = part.of_camera(holder, bpy.context.scene)
    assert part.of_camera(holder, bpy.context.scene) is first
    holder.data.petzval.f_number = 4.0
    assert part.of_camera(holder, bpy.context.scene) is not first
    holder.data.petzval.lens_file = "no-such.lens"
    assert part.of_camera(holder, bpy.context.scene) is None


def test_an_infinite_focus_has_no_surface(overlay):
    """A focus at infinity still has a near limit."""
    part, bpy = overlay
    holder = bpy.context.scene.camera
    holder.data.petzval.focus_mode = "INFINITY"
    answer = part.of_camera(holder, bpy.context.scene)
    assert part.surface(answer, "far")[0] is None
    assert any(point is not None for point in part.surface(answer, "near"))
