# SPDX-License-Identifier: GPL-3.0-or-later
"""The drawing of a camera's lens as it is set, for its panel: made by a timer when a setting has changed, never while a panel draws.

A panel can show square icons alone, and leaves a rim about each.
"""

from __future__ import annotations

import dataclasses
import json
import os
import time
from dataclasses import dataclass
from math import cos, degrees, hypot, sin
from typing import Any

import bpy
import bpy.utils.previews
import numpy as np

from petzval.description import CameraDescription, focused

from .. import redraw
from ..export import camera as camera_export
from ..export.errors import ExportError
from ..export.report import Report
from ..native import EngineMissing, engine
from ..queries import autofocus, lens_info
from . import lens_drawing

# So long nothing may have changed: less, and a slider that is dragged would stutter.
_QUIET_S = 0.12
# While a render runs, until it is asked again.
_BUSY_S = 1.0
_RAYS = 7
#: The three fields, as parts of the picture's half diagonal.
_FIELDS = (0.0, 0.7, 1.0)
#: The most pixels of the drawing's side: more are shown larger.
MOST_PX = 512
#: Blender's own about an icon, on each side.
_RIM_PX = 4
# One for each camera and editor that was shown.
_REMEMBERED = 4


@dataclass
class Drawn:
    """The drawing that the panel shows. `error`, one line, where there is no drawing."""

    icon: int
    #: Angle (degrees) of each field, and whether light comes through from it.
    fields: list[tuple[float, bool]]
    error: str = ""
    is_current: bool = True


#: Scene, camera with its library, pixels of the side: two editors may show two cameras, or one in two sizes.
_Place = tuple[str, tuple[str, str | None], int]


@dataclass
class _Kept:
    asked: tuple
    drawn: Drawn
    #: A preview collection, or None.
    previews: Any


_kept: dict[_Place, _Kept] = {}
#: The drawing that is asked for, and the time since which that has not changed.
_wanted: dict[_Place, tuple[tuple, float]] = {}


def for_panel(
    holder: bpy.types.Object, scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, side_px: int
) -> Drawn | None:
    """The last drawing; has a new one made soon where the lens has changed. `side_px`: of the place that the panel has for it."""
    library = holder.library.filepath if holder.library else None
    place = (scene.name, (holder.name, library), side_px)
    kept = _kept.get(place)
    if redraw.is_rendering():
        # As for the lens's data: nothing is asked meanwhile.
        return None if kept is None else dataclasses.replace(kept.drawn, is_current=False)
    asked = _asked(holder, scene, _found(holder, scene, view_layer))
    is_current = kept is not None and kept.asked == asked
    if not is_current:
        if _wanted.get(place, (None,))[0] != asked:
            _wanted[place] = asked, time.monotonic()
        # Another file takes timers away.
        if not bpy.app.timers.is_registered(_draw):
            bpy.app.timers.register(_draw, first_interval=_QUIET_S)
    return None if kept is None else dataclasses.replace(kept.drawn, is_current=is_current)


def _found(holder: bpy.types.Object, scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> dict | None:
    """The answer of autofocus, if the camera's focus is set by autofocus; else None."""
    if holder.data.petzval.focus_mode != "AUTO":
        return None
    found = autofocus.for_panel(holder, scene, view_layer)
    return None if found is None or "error" in found.answer else found.answer


def _asked(holder: bpy.types.Object, scene: bpy.types.Scene, found: dict | None) -> tuple:
    width, height = camera_export.resolution(scene.render)
    try:
        camera = _describe(holder, scene, found)
        changed = os.stat(camera.lens_path).st_mtime_ns
    except (ExportError, OSError) as error:
        return (str(error),)
    return repr(camera), width / height, changed


def _describe(holder: bpy.types.Object, scene: bpy.types.Scene, found: dict | None) -> CameraDescription:
    width, height = camera_export.resolution(scene.render)
    camera = camera_export.describe(holder, scene, width, height, Report())
    if found is not None:
        camera = focused(camera, found)
    if camera.focus.point_world is None:
        # The lens is the same wherever the camera stands.
        camera = dataclasses.replace(camera, matrix_world=((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)))
    return camera


def of_camera(holder: bpy.types.Object, scene: bpy.types.Scene, found: dict | None = None) -> dict[str, Any]:
    """The engine's `lens_drawing_json` of the lens as it is set, the film as large, turned and shifted as it is.

    Raises `ExportError`, `EngineMissing` and the engine's errors.
    """
    native = engine()
    info = lens_info.of_camera(holder, scene, found)
    if "error" in info:
        raise ExportError(info["error"])
    camera = _describe(holder, scene, found)
    lens = native.Lens(camera.lens_path)
    half = degrees(info["fov_diagonal_rad"] or 0.0) / 2.0 or json.loads(lens.summary_json())["half_field_deg"] or 0.0
    distance = info["focus_distance_mm"]
    options = {} if camera.wavelength_nm is None else {"wavelength_nm": camera.wavelength_nm}
    drawing = json.loads(
        native.lens_drawing_json(
            lens,
            camera.lens,
            [part * half for part in _FIELDS],
            _RAYS,
            # Beyond infinity there is no distance.
            focus_distance_mm=distance if distance is not None and distance > 0.0 else None,
            **options,
        )
    )
    _place_film(drawing, camera, info)
    return drawing


def _place_film(drawing: dict[str, Any], camera: CameraDescription, info: dict[str, Any]) -> None:
    """The film as it stands instead of as high as the drawn rays, and these go on to it. A retina stays."""
    film_z = info["film_z_mm"]
    depths = [place[0] for place in drawing["film"]]
    if depths and max(depths) - min(depths) > 1e-6 * max(abs(drawing["film_z_mm"]), 1.0):
        return
    # The fields go to the picture's corner, so its diagonal lies in the drawing.
    half, middle = 0.5 * hypot(info["picture_width_mm"], info["picture_height_mm"]), -camera.film.shift_mm[1]
    along = np.array([sin(camera.film.tilt_rad), cos(camera.film.tilt_rad)])
    base = np.array([film_z, 0.0])
    drawing["film_z_mm"] = film_z
    drawing["film"] = [list(base + v * along) for v in (middle - half, middle + half)]
    across = np.array([along[1], -along[0]])
    for field in drawing["fields"]:
        for ray in field["rays"]:
            last, end = np.array(ray[-2]), np.array(ray[-1])
            slope = float((end - last) @ across)
            part = float((base - last) @ across) / slope if abs(slope) > 1e-12 * hypot(*(end - last)) else 0.0
            if part > 0.0:
                ray[-1] = list(last + part * (end - last))


def _draw() -> float | None:
    """The timer: draws the lenses that have not changed for a while; gives the seconds until it is to be called again."""
    if bpy.app.is_job_running("RENDER"):
        return _BUSY_S
    ready = [place for place, (_, since) in _wanted.items() if time.monotonic() >= since + _QUIET_S]
    for place in ready:
        asked, _ = _wanted.pop(place)
        _draw_it(place, asked)
    if ready:
        redraw.properties()
    return _QUIET_S if _wanted else None


def _draw_it(place: _Place, asked: tuple) -> None:
    # By name: what a timer keeps may have gone meanwhile.
    scene, holder = bpy.data.scenes.get(place[0]), bpy.data.objects.get(place[1])
    if scene is None or holder is None or holder.type != "CAMERA":
        return
    try:
        drawing = of_camera(holder, scene, _found(holder, scene, scene.view_layers[0]))
        kept = _Kept(asked, *_shown(drawing, place[2]))
    except (ExportError, EngineMissing) as error:
        kept = _Kept(asked, Drawn(0, [], str(error)), None)
    except engine().PetzvalError as error:
        kept = _Kept(asked, Drawn(0, [], " ".join(str(error).split())), None)
    _drop(place)
    while len(_kept) >= _REMEMBERED:
        _drop(next(iter(_kept)))
    _kept[place] = kept


def _drop(place: _Place) -> None:
    """Gives a drawing's memory back."""
    kept = _kept.pop(place, None)
    if kept is not None and kept.previews is not None:
        bpy.utils.previews.remove(kept.previews)


def _shown(drawing: dict[str, Any], side_px: int) -> tuple[Drawn, Any]:
    """The picture as an icon, and the collection that holds it."""
    pixels = min(max(side_px - 2 * _RIM_PX, 16), MOST_PX)
    picture = lens_drawing.picture(drawing, pixels, pixels)
    previews = bpy.utils.previews.new()
    made = previews.new("drawing")
    made.image_size = (pixels, pixels)
    made.image_pixels_float.foreach_set(np.ascontiguousarray(picture, np.float32).ravel())
    fields = [(field["angle_deg"], bool(field["rays"])) for field in drawing["fields"]]
    return Drawn(made.icon_id, fields), previews


def forget() -> None:
    """Gives the memory back."""
    for place in list(_kept):
        _drop(place)
    _wanted.clear()


def register() -> None:
    """Does nothing: no drawing is made until a panel asks."""


def unregister() -> None:
    if bpy.app.timers.is_registered(_draw):
        bpy.app.timers.unregister(_draw)
    forget()
