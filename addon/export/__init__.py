# SPDX-License-Identifier: GPL-3.0-or-later
"""From Blender's evaluated scene to the engine's builder: one file per kind of datablock.

Reads only; nothing here changes the scene, and what cannot be handed over is said in the report, once.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy

from ..description import Report
from . import world
from .aovs import Aovs
from .image import Images
from .instances import Stage
from .light_groups import LightGroups
from .material import Materials
from .motion import Motion


def send_scene(
    depsgraph: bpy.types.Depsgraph,
    builder: Any,
    report: Report,
    check_stop: Callable[[], None],
    motion: Motion | None = None,
) -> None:
    """Fills a `SceneBuilder`. `check_stop` is called between objects and may raise."""
    images = Images(builder, report)
    materials = Materials(builder, images, Aovs(depsgraph.view_layer_eval), report)
    scene = depsgraph.scene_eval
    groups = LightGroups(depsgraph.view_layer_eval)
    sky = world.describe(scene.world, images, report)
    sky.light_group = groups.number(scene.world)
    builder.set_world(sky)
    stage = Stage(builder, materials, images, groups, report, check_stop, motion)
    stage.send(depsgraph)
    if stage.holds_out and scene.petzval.integrator == "BIDIRECTIONAL":
        report.warn(f"Scene '{scene.name}': bidirectional paths know of no holdout, what holds out is seen")
    if stage.is_selective and scene.petzval.integrator == "BIDIRECTIONAL":
        report.warn(
            f"Scene '{scene.name}': bidirectional paths know of no ray visibility but the camera's and shadows', and of no "
            "light linking"
        )
    if groups.names and scene.petzval.integrator == "BIDIRECTIONAL":
        report.warn(f"Scene '{scene.name}': bidirectional paths know of no light groups, their passes are black")
    if (materials.fills_space or world.fills_space(scene.world)) and scene.petzval.integrator == "BIDIRECTIONAL":
        report.warn(f"Scene '{scene.name}': bidirectional paths know of no volumes, space is empty")
    if scene.render.use_motion_blur:
        report.warn(
            f"Scene '{scene.name}': motion blur is supported for the lens's settings only yet, that of objects is left out"
        )
    if scene.render.use_freestyle:
        report.warn(f"Scene '{scene.name}': Freestyle lines are not supported yet, they are left out")
