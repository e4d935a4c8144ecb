# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that Simplify leaves out, by Blender's own camera, against Cycles in the same Blender."""

from __future__ import annotations

import numpy as np
import pytest

from support.ball_row import add_panel, alike

#: Where what glows stands, and at which settings it is left out: seen, beside the frame (its light on the floor is seen), behind the camera.
PLACES = {"before": (0.0, 2.2, 1.6), "beside": (4.6, 0.0, 1.6), "behind": (0.0, -9.0, 1.6)}


@pytest.fixture
def stage(room, blender):
    scene = blender.context.scene
    scene.render.use_simplify = True
    panel = add_panel(room, strength=8.0)

    def put(place: str, *kinds: str) -> object:
        """The panel at a place, to be left out by these kinds of culling."""
        panel.location, panel.rotation_euler = PLACES[place], (0.0, 0.0, 1.2 if place == "beside" else 0.0)
        for kind in kinds:
            setattr(scene.cycles, f"use_{kind}_cull", True)
            setattr(panel.cycles, f"use_{kind}_cull", True)
        return scene.cycles

    room.put = put
    return room


def both(stage, folder, is_left_out: bool) -> None:
    """Petzval shows what Cycles does, and without Simplify it would show something else if the panel is left out."""
    ours = alike(folder, mean=0.015, block=0.05)
    scene = stage.bpy.context.scene
    scene.render.use_simplify = False
    whole = stage.render(folder, "whole.exr")[..., :3]
    assert (np.abs(ours - whole).mean() > 0.01 * whole.mean()) == is_left_out


@pytest.mark.once
@pytest.mark.parametrize(
    ("place", "margin", "is_left_out"),
    [("before", 0.1, False), ("beside", 0.1, True), ("beside", 3.0, False), ("behind", 0.1, True)],
)
def test_what_the_camera_does_not_see(stage, tmp_path, place, margin, is_left_out):
    stage.put(place, "camera").camera_cull_margin = margin
    both(stage, tmp_path, is_left_out)


@pytest.mark.once
@pytest.mark.parametrize(("distance", "is_left_out"), [(8.0, True), (12.0, False), (0.0, False)])
def test_what_is_far(stage, tmp_path, distance, is_left_out):
    stage.put("before", "distance").distance_cull_margin = distance
    both(stage, tmp_path, is_left_out)


@pytest.mark.once
@pytest.mark.parametrize(("distance", "is_left_out"), [(4.0, True), (12.0, False)])
def test_what_asks_for_both_is_left_out_by_both(stage, tmp_path, distance, is_left_out):
    stage.put("beside", "camera", "distance").distance_cull_margin = distance
    both(stage, tmp_path, is_left_out)


@pytest.mark.once
def test_an_orthographic_camera(stage, blender, tmp_path):
    camera = blender.context.scene.camera.data
    camera.type, camera.ortho_scale = "ORTHO", 5.0
    stage.put("beside", "camera")
    both(stage, tmp_path, True)


@pytest.mark.once
def test_panoramas_leave_nothing_out(stage, blender, tmp_path):
    camera = blender.context.scene.camera.data
    camera.type, camera.panorama_type = "PANO", "EQUIRECTANGULAR"
    stage.put("behind", "camera")
    both(stage, tmp_path, False)
