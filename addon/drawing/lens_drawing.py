# SPDX-License-Identifier: GPL-3.0-or-later
"""A lens drawn as a small picture, from the engine's surfaces and rays (`lens_drawing_json`). No bpy.

The colours are read on the panels' grey, light or dark.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .canvas import Canvas, Colour

View = tuple[float, float, float, float]

_GLASS: Colour = (0.56, 0.77, 0.93, 0.45)
_RIM: Colour = (0.55, 0.75, 0.9, 1.0)
_DARK: Colour = (0.86, 0.86, 0.88, 1.0)
_AXIS: Colour = (0.6, 0.6, 0.6, 0.7)
_PLANE: Colour = (0.75, 0.75, 0.75, 1.0)
_PUPIL: Colour = (0.8, 0.5, 0.95, 1.0)
#: The colours of the fields, from the axis on.
FIELDS: tuple[Colour, ...] = ((0.35, 0.62, 1.0, 1.0), (0.35, 0.82, 0.47, 1.0), (0.98, 0.48, 0.36, 1.0))
# As in the drawings of `petzval lens draw`: of the lens's height, and the room about all, of its.
_MARK, _ROOM = 0.09, 0.06
_ROOM_FOR_RAYS = 0.12
#: The height of letters, as a part of the picture's.
_LETTERS = 0.04


def view_of(found: dict[str, Any]) -> View:
    """Left, right, low and high (mm) of the drawing, the axis in the middle."""
    places = [place for surface in found["surfaces"] for place in surface["points"]]
    places += [place for field in found["fields"] for ray in field["rays"] for place in ray]
    places += [*found["film"], [found["film_z_mm"], 0.0]]
    depths, heights = np.asarray(places, float).T
    left, right = float(depths.min()), float(depths.max())
    high = max(float(np.abs(heights).max()), 0.05 * (right - left), 1e-9) * (1.0 + 2.0 * _ROOM)
    room = max(0.02 * (right - left), 1e-9)
    return left - room, right + room, -high, high


def _view_of_glass(found: dict[str, Any]) -> View:
    """The bounds of the glass alone, with some room for the rays."""
    places = np.asarray([place for surface in found["surfaces"] for place in surface["points"]], float)
    if not len(places):
        return view_of(found)
    (left, low), (right, high) = places.min(axis=0), places.max(axis=0)
    room = _ROOM_FOR_RAYS * max(right - left, high - low, 1e-9)
    high = max(high, -low) + room
    return left - room, right + room, -high, high


def with_shape(view: View, width_by_height: float) -> View:
    """The view made wider or higher about its middle until it has this width over its height."""
    left, right, low, high = view
    wide, tall = right - left, high - low
    grow_x = max(tall * width_by_height - wide, 0.0) / 2.0
    grow_y = max(wide / width_by_height - tall, 0.0) / 2.0
    return left - grow_x, right + grow_x, low - grow_y, high + grow_y


def thumbnail(found: dict[str, Any], side_px: int) -> np.ndarray:
    """Glass, stop and the rays near it in a square: (side, side, 4), rows from below."""
    canvas = Canvas(side_px, side_px, with_shape(_view_of_glass(found), 1.0), fine=3)
    _glass(canvas, found, 1.0)
    _rays(canvas, found, 0.8)
    _stop(canvas, found, 1.5)
    return canvas.pixels


def picture(found: dict[str, Any], width_px: int, height_px: int) -> np.ndarray:
    """The picture of a lens: (height, width, 4), rows from below. Dashed: the principal planes H and H'; dotted: the pupils EP and XP."""
    view = with_shape(view_of(found), width_px / height_px)
    canvas = Canvas(width_px, height_px, view)
    line = max(height_px / 300.0, 1.0)
    canvas.draw([[[view[0], 0.0], [view[1], 0.0]]], _AXIS, line, (12.0 * line, 5.0 * line))
    _glass(canvas, found, line)
    _rays(canvas, found, line)
    if len(found["film"]) > 1:
        canvas.draw([found["film"]], _DARK, 2.5 * line)
    _stop(canvas, found, 2.5 * line)
    _planes(canvas, found, view, line)
    return canvas.pixels


def _glass(canvas: Canvas, found: dict[str, Any], width_px: float) -> None:
    surfaces = found["surfaces"]
    outlines = [
        _outline(surface["points"], after["points"])
        for surface, after in zip(surfaces, surfaces[1:], strict=False)
        if surface["glass_behind"] is not None and surface["points"] and after["points"]
    ]
    canvas.fill(outlines, _GLASS)
    canvas.draw([[*outline, outline[0]] for outline in outlines], _RIM, width_px)
    mirrors, shades = [], []
    for number, surface in enumerate(surfaces):
        if surface["is_mirror"]:
            mirrors += _beside(surface["points"], surface["hole_mm"])
        elif surface["hole_mm"] > 0.0 and number != found["stop"]:
            # Something dark in the middle.
            shades.append([place for place in surface["points"] if abs(place[1]) <= surface["hole_mm"]])
    canvas.draw([*mirrors, *(shade for shade in shades if len(shade) > 1)], _DARK, 2.5 * width_px)


def _outline(front: list, back: list) -> list:
    """About the glass between two surfaces: the smaller one's rim goes straight out to the larger one's height."""

    def out_to(rim: list, other: list) -> list:
        return [[rim[0], other[1]]] if abs(other[1]) > abs(rim[1]) else []

    return [
        *out_to(front[0], back[0]), *front, *out_to(front[-1], back[-1]),
        *out_to(back[-1], front[-1]), *reversed(back), *out_to(back[0], front[0]),
    ]  # fmt: skip


def _beside(points: list, hole_mm: float) -> list[list]:
    """A surface's line, in two where its middle is missing."""
    if hole_mm <= 0.0:
        return [points]
    parts = [[place for place in points if side * place[1] >= hole_mm] for side in (-1.0, 1.0)]
    return [part for part in parts if len(part) > 1]


def _rays(canvas: Canvas, found: dict[str, Any], width_px: float) -> None:
    for number, field in enumerate(found["fields"]):
        canvas.draw(field["rays"], FIELDS[number % len(FIELDS)], width_px)


def _stop(canvas: Canvas, found: dict[str, Any], width_px: float) -> None:
    points, opening = found["surfaces"][found["stop"]]["points"], found["stop_semi_diameter_mm"]
    if not points:
        return
    mark = _MARK * 2.0 * max(abs(place[1]) for surface in found["surfaces"] for place in surface["points"])
    marks = []
    for side in (-1.0, 1.0):
        z = min(points, key=lambda place: abs(place[1] - side * opening))[0]
        marks.append([[z, side * opening], [z, side * (opening + mark)]])
    canvas.draw(marks, _DARK, width_px)


def _planes(canvas: Canvas, found: dict[str, Any], view: View, line: float) -> None:
    """Principal planes and pupils that lie in the picture."""
    left, right, low, high = view
    letters = max(_LETTERS * canvas.height, 7.0)
    step = 1.4 * letters * (high - low) / canvas.height
    # A little higher than the lens and its rays, where there is room for the letters.
    tall = min(1.1 * view_of(found)[3], high - 2.2 * step)
    planes = (("H", found["object_principal_plane_mm"]), ("H'", found["image_principal_plane_mm"]))
    for number, (name, z) in enumerate(planes):
        if z is not None and left < z < right:
            canvas.draw([[[z, -tall], [z, tall]]], _PLANE, line, (6.0 * line, 4.0 * line))
            # One above the other: they can be close.
            canvas.write(name, (z, tall + (0.2 + number) * step), _PLANE, letters)
    for number, (key, name) in enumerate((("entrance_pupil", "EP"), ("exit_pupil", "XP"))):
        z, diameter = found[key]["z_mm"], found[key]["diameter_mm"]
        if z is None or diameter is None or not left < z < right or diameter > high - low:
            continue
        canvas.draw([[[z, -0.5 * diameter], [z, 0.5 * diameter]]], _PUPIL, line, (2.0 * line, 3.0 * line))
        tick = 0.012 * (right - left)
        ends = [[[z - tick, side * diameter], [z + tick, side * diameter]] for side in (-0.5, 0.5)]
        canvas.draw(ends, _PUPIL, 2.0 * line)
        canvas.write(name, (z, -tall - (1 + number) * step), _PUPIL, letters)
