# SPDX-License-Identifier: GPL-3.0-or-later
"""Petzval in Blender: what is registered, in which order."""

from . import builtin_panels, engine, properties, ui, viewport_camera

_PARTS = (properties, viewport_camera, engine, ui, builtin_panels)


def register() -> None:
    for part in _PARTS:
        part.register()


def unregister() -> None:
    for part in reversed(_PARTS):
        part.unregister()
