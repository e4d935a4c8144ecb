# SPDX-License-Identifier: GPL-3.0-or-later
"""A lens before a film, without a scene: for `petzval lens stmap`, `osl` and `calibrate`."""

from __future__ import annotations

import argparse
import math

from . import argument_types as types
from .description import IDENTITY, CameraDescription, FilmSettings, FocusSettings
from .lens_setting import add_focus, add_setting, setting_of
from .places import find_lens

#: Millimetres of a unit of the engine's description.
_SCALE = 1000.0


def add_camera(parser: argparse.ArgumentParser, kinds: str) -> None:
    """Adds the options of a lens, its setting, its film and the picture's pixels."""
    parser.add_argument("lens", metavar="FILE", help=f"a lens file ({kinds}), or the name of a shipped lens")
    parser.add_argument(
        "--film", type=types.film, metavar="WxH|NAME", required=True, help=f"millimetres, or {types.FILM_NAMES}"
    )
    parser.add_argument("--pixels", type=types.pixels, metavar="WxH", required=True, help="of the picture")
    add_setting(parser)
    add_focus(parser)
    add_pose(parser)


def add_pose(parser: argparse.ArgumentParser) -> None:
    """Adds the options for the pose of the film behind the lens."""
    parser.add_argument("--tilt", type=types.number, default=0.0, metavar="DEG", help="turn of the film about its horizontal axis")  # fmt: skip
    parser.add_argument("--swing", type=types.number, default=0.0, metavar="DEG", help="turn of the film about its vertical axis")  # fmt: skip
    parser.add_argument("--shift", type=types.pair, default=[0.0, 0.0], metavar="X,Y", help="the lens right and up against the film, mm")  # fmt: skip


def camera_of(
    arguments: argparse.Namespace, *, wavelength_nm: float | None = None, spectrum: str = "VISIBLE"
) -> CameraDescription:
    """The camera that the arguments of `add_camera` ask for, as the engine takes it."""
    distance = arguments.focus_distance
    is_far = distance is None or math.isinf(distance)
    width_mm, height_mm = arguments.film
    return CameraDescription(
        object_name="camera",
        matrix_world=IDENTITY,
        lens_path=str(find_lens(arguments.lens)),
        lens=setting_of(arguments),
        focus=FocusSettings(distance=None if is_far else distance / _SCALE),
        film=FilmSettings(
            width_mm, height_mm, math.radians(arguments.tilt), math.radians(arguments.swing), tuple(arguments.shift)
        ),
        wavelength_nm=wavelength_nm,
        spectrum=spectrum,
    )
