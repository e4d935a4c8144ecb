# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels: small, without arithmetic; what they show is asked of the engine."""

from __future__ import annotations

from . import builtin, camera, effects, render, tools, view_layer


def register() -> None:
    render.register()
    effects.register()
    camera.register()
    tools.register()
    view_layer.register()
    builtin.register()


def unregister() -> None:
    builtin.unregister()
    view_layer.unregister()
    tools.unregister()
    camera.unregister()
    effects.unregister()
    render.unregister()
