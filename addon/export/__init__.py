# SPDX-License-Identifier: GPL-3.0-or-later
"""From Blender's evaluated scene to the engine's description: one file per kind of datablock."""

from .camera import camera
from .errors import ExportError
from .scene import scene
from .settings import picture_size, settings

__all__ = ["ExportError", "camera", "picture_size", "scene", "settings"]
