# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes in which effects of a lens can be seen, or cannot: `SCENES`, by name. Each has edges, depths and highlights of
its own kind, and a camera that looks along +y from the origin of the world.

Made by script when they are asked for, in the Blender that imports this; nothing is kept in files. As a program, it
writes them: `python -m plan_scenes FOLDER [NAME ...]`, tests and tests/scenes on the path.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import bpy


@dataclass(frozen=True)
class PlanScene:
    """A scene, and where a lens is to be focused in it."""

    name: str
    title: str
    #: Metres from the camera; None is infinity.
    focus_m: float | None
    #: Fills an empty file with it.
    fill: Callable[[], None]

    def open(self) -> None:
        """Makes it the scene that is open; its camera is Blender's own."""
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.fill()
        dof = bpy.context.scene.camera.data.dof
        # Blender has no infinity; Petzval's own is asked for where a lens is set.
        dof.use_dof, dof.focus_distance = True, self.focus_m or 1e4


SCENES: dict[str, PlanScene] = {}


def scene(title: str, focus_m: float | None):
    """Puts the function below it among the scenes, under its own name."""

    def added(fill: Callable[[], None]):
        SCENES[fill.__name__] = PlanScene(fill.__name__, title, focus_m, fill)
        return fill

    return added


from . import outdoors, indoors  # noqa: E402, F401, I001 (they add to SCENES, in this order)
