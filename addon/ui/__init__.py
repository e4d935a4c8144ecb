# SPDX-License-Identifier: GPL-3.0-or-later
"""The panels, in the order in which they stand."""

import bpy

from . import lens, sampling

_CLASSES = (*lens.CLASSES, *sampling.CLASSES)


def register() -> None:
    for cls in _CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
