# SPDX-License-Identifier: GPL-3.0-or-later
"""A lens with the frame of Blender's own camera, and the film of a lens; remembered so that a view may ask at every redraw."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from typing import Any

from petzval.description import CameraDescription

from ..native import engine
from .report import Report

# A slider being dragged leaves one entry a step.
_REMEMBERED = 64

_found: dict[tuple, Any] = {}


class Refused(Exception):
    """The error of a lens that cannot have the frame: the engine's message, one line."""


def like_blender(
    description: CameraDescription, shift: tuple[float, float], size: tuple[int, int], report: Report
) -> CameraDescription:
    """The camera with its lens scaled or zoomed to the frame of its `perspective` with this shift, in a picture of so many pixels on
    its film; shifts of the lens add to those of Blender's camera. As it was, and a warning, where the lens cannot."""
    perspective, film = replace(description.perspective, shift=shift), description.film
    shape = size[0] / (size[1] * description.pixel_aspect)
    width_mm = min(film.width_mm, film.height_mm * shape)
    on_film = replace(
        perspective,
        focal_length_mm=perspective.focal_length_mm * width_mm / perspective.film_width_mm,
        film_width_mm=width_mm,
    )
    try:
        found = json.loads(_ask("framing_json", replace(description, perspective=on_film), size, "FOCAL_LENGTH"))
    except Refused as error:
        report.warn(f"{error}; it keeps its published size until then")
        return description
    shift_mm = found["shift_mm"]
    return replace(
        description,
        lens=replace(description.lens, focal_length={"MILLIMETRES": found["focal_length_mm"]}),
        film=replace(film, shift_mm=(film.shift_mm[0] + shift_mm[0], film.shift_mm[1] + shift_mm[1])),
    )


def turned(description: CameraDescription, size: tuple[int, int], turn: float, report: Report) -> CameraDescription:
    """The camera with its film shifted until its picture's middle lies to the right by a tangent. As it was, and a warning, where the lens
    cannot be asked."""
    try:
        info = json.loads(_ask("camera_info_json", description, size))
    except Refused as error:
        report.warn(f"{error}; its film stays where it is, and the eyes do not converge")
        return description
    x, y = description.film.shift_mm
    across, _, along = description.scale_mm_per_unit
    to_the_right = turn * across / along * info["viewport_focal_length_mm"]
    return replace(description, film=replace(description.film, shift_mm=(x + to_the_right, y)))


def film_of_lens_mm(description: CameraDescription, size: tuple[int, int]) -> tuple[float, float]:
    """Width and height of the film for which the lens is made. Raises `Refused`."""
    return tuple(_ask("film_of_lens_mm", description, size))


def _ask(function: str, description: CameraDescription, size: tuple[int, int], *others: str) -> Any:
    """The answer of a function of the engine. Raises `Refused`."""
    if description.focus.point_world is None:
        # Else the camera's place says how far away the point is.
        identity = tuple(tuple(float(row == column) for column in range(4)) for row in range(4))
        description = replace(description, matrix_world=identity)
    try:
        changed = os.stat(description.lens_path).st_mtime_ns
    except OSError:
        changed = 0
    key = (function, repr(description), size, changed)
    if key not in _found:
        while len(_found) >= _REMEMBERED:
            del _found[next(iter(_found))]
        native = engine()
        try:
            _found[key] = getattr(native, function)(description, *size, *others)
        except native.PetzvalError as error:
            _found[key] = Refused(" ".join(str(error).split()))
    found = _found[key]
    if isinstance(found, Refused):
        raise found
    return found
