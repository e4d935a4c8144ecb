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
from .image import Images
from .instances import Stage
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
    materials = Materials(builder, images, report)
    scene = depsgraph.scene_eval
    builder.set_world(world.describe(scene.world, images, report))
    stage = Stage(builder, materials, images, report, check_stop, motion)
    stage.send(depsgraph)
    if stage.is_selective and scene.petzval.integrator == "BIDIRECTIONAL":
        report.warn(
            f"Scene '{scene.name}': bidirectional paths know of no ray visibility but the camera's and shadows', and of no "
            "light linking"
        )
    if depsgraph.view_layer_eval.lightgroups:
        report.warn(f"Scene '{scene.name}': light groups are not supported yet, no pictures of them are made")
    if scene.render.use_motion_blur:
        report.warn(
            f"Scene '{scene.name}': motion blur is supported for the lens's settings only yet, that of objects is left out"
        )
    if scene.render.use_freestyle:
        report.warn(f"Scene '{scene.name}': Freestyle lines are not supported yet, they are left out")
