# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels: small, without arithmetic; their numbers come from the engine."""

from __future__ import annotations

from . import (
    bake,
    builtin,
    camera,
    effects,
    lens_gallery,
    light,
    material,
    objects,
    preset_panels,
    render,
    render_film,
    render_results,
    render_shapes,
    tools,
    view_layer,
    world,
)

# In the order in which they stand in a tab.
PARTS = (
    preset_panels,
    render,
    effects,
    render_shapes,
    render_film,
    bake,
    render_results,
    lens_gallery,
    camera,
    tools,
    light,
    material,
    objects,
    world,
    view_layer,
    builtin,
)


def register() -> None:
    for part in PARTS:
        part.register()


def unregister() -> None:
    for part in reversed(PARTS):
        part.unregister()
