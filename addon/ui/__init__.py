# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels: small, without arithmetic; what they show is asked of the engine."""

from __future__ import annotations

from . import builtin, camera, effects, lens_gallery, preset_panels, render, view_layer


def register() -> None:
    preset_panels.register()
    render.register()
    effects.register()
    lens_gallery.register()
    camera.register()
    view_layer.register()
    builtin.register()


def unregister() -> None:
    builtin.unregister()
    view_layer.unregister()
    camera.unregister()
    lens_gallery.unregister()
    effects.unregister()
    render.unregister()
    preset_panels.unregister()
