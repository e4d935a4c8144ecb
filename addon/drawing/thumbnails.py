# SPDX-License-Identifier: GPL-3.0-or-later
"""A small picture of each lens for menus: drawn when first asked for, a few at a time, kept in memory."""

from __future__ import annotations

import json
import time
from typing import Any

import bpy
import bpy.utils.previews
import numpy as np

from .. import redraw
from ..data import lens_files
from ..native import EngineMissing, engine
from . import lens_drawing

SIDE_PX = 128
# Rays of a field: more are a blot.
_RAYS = 3
# So long the window is kept from drawing, and so long it then may.
_BUSY_S, _REST_S = 0.03, 0.01
# While a render runs.
_WAIT_S = 1.0

_icons: Any = None
#: Lenses that cannot be drawn.
_failed: set[str] = set()
_wanted: list[str] = []


def icon(lens_key: str) -> int:
    """The number of a lens's icon, as `favourites.key` names lenses; 0 until it is drawn."""
    if _icons is not None and lens_key in _icons:
        return _icons[lens_key].icon_id
    if lens_key not in _failed:
        if lens_key not in _wanted:
            _wanted.append(lens_key)
        # Another file takes timers away.
        if not bpy.app.timers.is_registered(_draw_some):
            bpy.app.timers.register(_draw_some, first_interval=_REST_S)
    return 0


def pixels(lens_key: str) -> np.ndarray:
    """The picture, (side, side, 4), rows from below. Raises `EngineMissing`, the engine's errors, and `LensMissing`."""
    native = engine()
    lens = native.Lens(lens_files.resolve(lens_key))
    half = json.loads(lens.summary_json())["half_field_deg"]
    fields = [0.0, half] if half else [0.0]
    return lens_drawing.thumbnail(json.loads(native.lens_drawing_json(lens, None, fields, _RAYS)), SIDE_PX)


def draw(lens_key: str) -> None:
    """Makes the icon now, where there is none."""
    global _icons
    if _icons is not None and lens_key in _icons:
        return
    if _icons is None:
        _icons = bpy.utils.previews.new()
    try:
        picture = pixels(lens_key)
    except (EngineMissing, lens_files.LensMissing, engine().PetzvalError):
        _failed.add(lens_key)
        return
    made = _icons.new(lens_key)
    made.image_size = (SIDE_PX, SIDE_PX)
    made.image_pixels_float.foreach_set(np.ascontiguousarray(picture, np.float32).ravel())


def _draw_some() -> float | None:
    """The timer."""
    if bpy.app.is_job_running("RENDER"):
        return _WAIT_S
    began = time.monotonic()
    try:
        while _wanted and time.monotonic() - began < _BUSY_S:
            draw(_wanted.pop(0))
    except EngineMissing:
        _wanted.clear()
    if _wanted:
        return _REST_S
    redraw.properties()
    return None


def forget() -> None:
    """Gives the memory back."""
    global _icons
    if _icons is not None:
        bpy.utils.previews.remove(_icons)
        _icons = None
    _failed.clear()
    _wanted.clear()


def register() -> None:
    """Does nothing: no thumbnail is drawn until it is asked for."""


def unregister() -> None:
    if bpy.app.timers.is_registered(_draw_some):
        bpy.app.timers.unregister(_draw_some)
    forget()
