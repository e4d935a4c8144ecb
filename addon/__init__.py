# SPDX-License-Identifier: GPL-3.0-or-later
"""Petzval's Blender add-on: asks Blender, tells the engine, shows the answer. Here is the registration order alone."""

from __future__ import annotations

import sys

try:
    import petzval.description  # noqa: F401
except ImportError as error:
    raise ImportError(f"Petzval's package is missing ({error}): install the extension again") from None

from . import engine, native, redraw, ui
from .data import favourites, settings_version
from .drawing import gizmos, live_drawing, overlay, thumbnails
from .operators import common as operators
from .operators import cost as cost_operator
from .operators import farm as farm_operator
from .operators import focus as focus_operators
from .operators import focus_picking
from .operators import framing as framing_operator
from .operators import lens as lens_operators
from .operators import lens_export as lens_export_operators
from .operators import plan as plan_operator
from .operators import presets as preset_operators
from .operators import report as report_operator
from .operators import sampling as sampling_operators
from .operators import select as select_operator
from .queries import autofocus, lookout, scene_size, viewport_camera
from .settings import properties

# What is used stands before what uses it.
PARTS = (
    properties,
    settings_version,
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
    sampling_operators,
    select_operator,
    engine,
    farm_operator,
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
