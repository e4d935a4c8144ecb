# SPDX-License-Identifier: GPL-3.0-or-later
"""Has the properties editors drawn anew: at once, or when the render that runs has ended."""

from __future__ import annotations

import bpy

# How often it is looked whether the render runs on.
_LOOK_S = 0.2


def properties() -> None:
    """Has the properties editors drawn at once."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "PROPERTIES":
                area.tag_redraw()


def is_rendering() -> bool:
    """True while a render runs; then the properties editors are drawn anew when it has ended."""
    if not bpy.app.is_job_running("RENDER"):
        return False
    if not bpy.app.timers.is_registered(_when_ended):
        bpy.app.timers.register(_when_ended, first_interval=_LOOK_S)
    return True


def _when_ended() -> float | None:
    if bpy.app.is_job_running("RENDER"):
        return _LOOK_S
    properties()
    return None


def unregister() -> None:
    if bpy.app.timers.is_registered(_when_ended):
        bpy.app.timers.unregister(_when_ended)


def register() -> None:
    """Does nothing: no timer is registered until it is asked for."""
