# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that catch shadows: the picture is to be laid over a photograph, and holds of them what light they lose. No bpy.

As in Cycles the scene is seen twice, with all that is in it and with those objects alone, and the shadow is the one by the
other (its manual, "Shadow Catcher"). Both by the same rays and random numbers, so noise that they share cancels.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from . import passes

#: What is kept of the render of everything.
PARTS = ("CAUGHT", "CATCHES")
#: The pass of the shadow alone, for multiplying the photograph.
NAME = passes.SHADOW.name


def shadow(everything: Any, alone: Any) -> np.ndarray:
    """What of the light is left on what catches shadows, (height, width, 3); 1 where nothing is seen. Of finished jobs of all
    objects, and of those that catch shadows alone."""
    caught, lit = everything.part("CAUGHT"), alone.image()[..., :3]
    left = np.divide(caught, lit, out=np.ones_like(caught), where=lit != 0.0)
    covered = everything.image()[..., 3:]
    return (1.0 - covered) + covered * left


def picture(everything: Any, alone: Any, sky: Any, *, is_opaque: bool, has_pass: bool) -> np.ndarray:
    """The picture to be laid over a photograph, (height, width, 4): what catches shadows is gone, and the mean of its shadow
    is alpha; with a pass for it (`has_pass`) it is there alone. With an opaque film it is laid over the finished render of the
    `sky`, if there is one."""
    whole, catches = everything.image(), everything.part("CATCHES")
    seen = np.ones_like(catches[..., 1:2]) if is_opaque else catches[..., 1:2]
    others = 1.0 - np.divide(catches[..., :1], seen, out=np.zeros_like(seen), where=seen != 0.0)
    light, alpha = whole[..., :3] - everything.part("CAUGHT"), whole[..., 3:] * others
    if not has_pass:
        dark = 1.0 - np.clip(shadow(everything, alone).mean(-1, keepdims=True), 0.0, 1.0)
        alpha = (1.0 - alpha) * dark + alpha
    if sky is not None:
        light, alpha = light + sky.image()[..., :3] * (1.0 - alpha), np.ones_like(alpha)
    return np.concatenate([light, alpha], axis=-1)
