# SPDX-License-Identifier: GPL-3.0-or-later
"""Cameras other than a plain pinhole, and what the film makes of their light."""

from __future__ import annotations

import bpy

from . import scene
from .studio import BLUE, CREAM, GREEN, RED, ball, cube, empty_studio, monkey, plain


def _row() -> bpy.types.Camera:
    """Things at several depths."""
    empty_studio()
    monkey(plain(CREAM), (0.0, 0.0, 0.9), 1.7)
    ball(plain(RED), (-1.5, -1.5, 0.6), 0.6)
    cube(plain(BLUE), (1.6, 1.2, 0.6), 1.2)
    ball(plain(GREEN), (1.2, -2.2, 0.4), 0.4)
    return bpy.context.scene.camera.data


@scene("An orthographic camera, shifted")
def orthographic():
    camera = _row()
    camera.type, camera.ortho_scale = "ORTHO", 6.0
    camera.shift_x, camera.shift_y = 0.05, -0.08


@scene("A shifted camera, the sensor fitted to the height")
def shifted():
    camera = _row()
    camera.sensor_fit, camera.sensor_height = "VERTICAL", 20.0
    camera.shift_x, camera.shift_y = -0.1, 0.12


@scene("What is too near or too far is clipped")
def clipping():
    camera = _row()
    camera.clip_start, camera.clip_end = 4.9, 9.0


@scene("The film's exposure")
def film_exposure():
    _row()
    bpy.context.scene.cycles.film_exposure = 0.6
