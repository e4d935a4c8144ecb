# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes of one feature each, for Petzval and Cycles to render alike: `SCENES`, by name.

Made by script when they are asked for, in the Blender that imports this; nothing is kept in files.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module

import bpy


@dataclass(frozen=True)
class ParityScene:
    """A scene that both are to render alike."""

    name: str
    #: The chapter of the page that lists it: the module's name.
    chapter: str
    title: str
    #: Fills an empty file with it.
    fill: Callable[[], None]
    #: How far the mean of a block of pixels may be off, relative.
    tolerance: float
    #: Why the tolerance is more than a hundredth.
    why: str
    #: What the noise of the tests' 65 thousand samples a block may add: more where rare paths are bright.
    noise: float
    #: Warnings that it is right to give: each a part of one.
    warns: tuple[str, ...]
    #: The passes to compare in the picture's place, by Blender 5's names; it asks for them itself.
    passes: tuple[str, ...]
    #: The frames to compare in the picture's place.
    frames: tuple[int, ...]
    #: How many times the tests' samples it takes, where their noise would be near the limit.
    times: int

    def open(self) -> None:
        """Makes it the scene that is open."""
        bpy.ops.wm.read_factory_settings(use_empty=True)
        bpy.context.scene.render.engine = "CYCLES"
        self.fill()


SCENES: dict[str, ParityScene] = {}


def scene(
    title: str,
    tolerance: float = 0.01,
    why: str = "",
    noise: float = 0.01,
    warns: tuple[str, ...] = (),
    passes: tuple[str, ...] = (),
    frames: tuple[int, ...] = (),
    times: int = 1,
):
    """Puts the function below it among the scenes, under its own name."""
    assert tolerance <= 0.01 or why, title

    def added(fill: Callable[[], None]):
        name, chapter = fill.__name__, fill.__module__.rsplit(".", 1)[-1]
        assert name not in SCENES, name
        SCENES[name] = ParityScene(name, chapter, title, fill, tolerance, why, noise, warns, passes, frames, times)
        return fill

    return added


for _chapter in (
    "surfaces", "textures", "coordinates", "lamps", "worlds", "volumes", "shapes", "hair", "points", "views", "motion", "frames",
    "passes", "light_passes", "data_passes",
):  # fmt: skip
    # Each adds to SCENES.
    import_module(f".{_chapter}", __name__)
