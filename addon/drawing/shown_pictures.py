# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures that are not renders, where the user sees them: an image of the file, in an image editor."""

from __future__ import annotations

import functools

import bpy
import numpy as np

# An editor smaller than this, in pixels of an unscaled interface, shows nothing of a page.
_LEAST_PX = (400, 300)
# Until a window that was opened has its size.
_SETTLED_S = 0.3


def keep(name: str, pixels: np.ndarray) -> bpy.types.Image:
    """The image of that name, new or as it was last time with other pixels: (height, width, 4), sRGB, packed into the file."""
    height, width = pixels.shape[:2]
    image = bpy.data.images.get(name)
    if image is not None and (image.library or tuple(image.size) != (width, height)):
        users = image if not image.library else None
        image = _new(name, width, height)
        if users is not None:
            # Whoever shows the old one shows this one.
            users.user_remap(image)
            bpy.data.images.remove(users)
            image.name = name
    elif image is None:
        image = _new(name, width, height)
    image.pixels.foreach_set(np.ascontiguousarray(pixels, dtype=np.float32).ravel())
    image.update()
    image.pack()
    return image


def _new(name: str, width: int, height: int) -> bpy.types.Image:
    return bpy.data.images.new(name, width, height, alpha=False)


def show(context: bpy.types.Context, image: bpy.types.Image) -> bool:
    """Shows an image in the largest image editor if that is large enough, else in a window of its own; False: there is no window."""
    manager = context.window_manager
    if bpy.app.background or manager is None or not manager.windows:
        return False
    editors = [
        (area.width * area.height, area)
        for window in manager.windows
        for area in window.screen.areas
        if area.ui_type == "IMAGE_EDITOR" and _is_large(context, area)
    ]
    if editors:
        area = max(editors, key=lambda editor: editor[0])[1]
    else:
        bpy.ops.wm.window_new()
        area = manager.windows[-1].screen.areas[0]
        area.ui_type = "IMAGE_EDITOR"
    area.spaces.active.image = image
    area.tag_redraw()
    # A new window has no size yet.
    bpy.app.timers.register(functools.partial(_fit, image.name), first_interval=_SETTLED_S)
    return True


def _is_large(context: bpy.types.Context, area: bpy.types.Area) -> bool:
    scale = context.preferences.system.ui_scale
    return area.width >= _LEAST_PX[0] * scale and area.height >= _LEAST_PX[1] * scale


def _fit(name: str) -> None:
    """The whole picture, as large as it can be shown."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            shown = area.spaces.active.image if area.type == "IMAGE_EDITOR" else None
            if shown is None or shown.name != name:
                continue
            region = next(region for region in area.regions if region.type == "WINDOW")
            with bpy.context.temp_override(window=window, area=area, region=region):
                bpy.ops.image.view_all(fit_view=True)
