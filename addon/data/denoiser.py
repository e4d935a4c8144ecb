# SPDX-License-Identifier: GPL-3.0-or-later
"""The path of the Open Image Denoise library for this Blender."""

from __future__ import annotations

import functools
from pathlib import Path

import bpy

#: A line for who has none.
INSTALL = "Open Image Denoise was not found beside Blender: install it for Petzval by `pip install pyoidn`, or denoise in the compositor"


@functools.cache
def library() -> Path | None:
    """The library's file, as it was found first; None: there is none."""
    from petzval import denoiser_library

    # Beside the folder of Blender's own scripts, of the program and of the module alike.
    local = _local()
    return denoiser_library.find([Path(local).parent] if local else [])


def _local() -> str:
    """The folder of the scripts that this Blender has of its own; empty: it has none."""
    return bpy.utils.resource_path("LOCAL")
