# SPDX-License-Identifier: GPL-3.0-or-later
"""Petzval's Blender add-on: asks Blender, tells the engine, shows the answer. Here is the registration order alone."""

from __future__ import annotations

import sys

try:
    import petzval.description  # noqa: F401
except ImportError as error:
    raise ImportError(f"Petzval's package is missing ({error}): install the extension again") from None

from . import (
    autofocus,
    cost_operator,
    engine,
    favourites,
    focus_operators,
    focus_picking,
    framing_operator,
    gizmos,
    lens_export_operators,
    lens_operators,
    live_drawing,
    lookout,
    native,
    operators,
    overlay,
    plan_operator,
    preset_operators,
    properties,
    redraw,
    report_operator,
    scene_size,
    select_operator,
    thumbnails,
    ui,
    viewport_camera,
)

# What is used stands before what uses it.
PARTS = (
    properties,
    redraw,
    viewport_camera,
    lookout,
    autofocus,
    favourites,
    thumbnails,
    live_drawing,
    scene_size,
    operators,
    lens_operators,
    focus_operators,
    focus_picking,
    framing_operator,
    plan_operator,
    report_operator,
    lens_export_operators,
    cost_operator,
    preset_operators,
    select_operator,
    engine,
    overlay,
    gizmos,
    ui,
)


def register() -> None:
    complaint = native.missing()
    if complaint:
        # The add-on stays usable enough to say so in Blender, in its panel and when rendering.
        print(f"petzval: {complaint}", file=sys.stderr)
    for part in PARTS:
        part.register()


def unregister() -> None:
    for part in reversed(PARTS):
        part.unregister()
