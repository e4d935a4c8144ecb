# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture in a camera's diaphragm, as the engine takes it."""

from __future__ import annotations

import bpy
import numpy as np

from petzval.description import ApertureMask, CameraDescription, changed

from .errors import ExportError


def load(path: str) -> bpy.types.Image:
    """The image of a file, its numbers as they are. Raises `RuntimeError` where Blender cannot read it."""
    image = bpy.data.images.load(path)
    # What lies in the file counts, not what a screen would show of it.
    image.colorspace_settings.name = "Non-Color"
    return image


def added(description: CameraDescription, camera: bpy.types.Camera) -> CameraDescription:
    """The description with the camera's mask. Raises `ExportError`."""
    return changed(description, {"lens.aperture_mask": read(camera)})


def read(camera: bpy.types.Camera) -> ApertureMask | None:
    """The camera's mask; `None` if it has none, or no opening. Raises `ExportError`."""
    image = camera.petzval.aperture_mask
    if image is None or camera.petzval.model == "PINHOLE":
        return None
    return of_image(image.original)


def of_image(image: bpy.types.Image) -> ApertureMask:
    """An image as a mask. Raises `ExportError`."""
    width, height = image.size
    if width == 0 or height == 0 or image.channels == 0:
        path = bpy.path.abspath(image.filepath, library=image.library) or "no file"
        raise ExportError(f"Aperture mask '{image.name}' cannot be read ({path}): restore the file, or clear the mask")
    if width != height:
        raise ExportError(f"Aperture mask '{image.name}' is {width} x {height} pixels: make it square")
    values = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(values)
    colours = values.reshape(-1, image.channels)[:, : 3 if image.channels >= 3 else 1]
    grey = np.clip(np.nan_to_num(colours.mean(axis=1)), 0.0, 1.0)
    return ApertureMask(image.name, width, (grey * 255.0 + 0.5).astype(np.uint8).tobytes())
