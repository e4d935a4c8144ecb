# SPDX-License-Identifier: GPL-3.0-or-later
"""The version of the settings in a .blend. A file of an older version is brought up to date when it is opened; one of a newer version says
so at every render, as settings that this version does not know are not read.

A setting that is only added needs no version: an older file has its default. One that changes its meaning, its unit or its name does: raise
`VERSION`, and put the changes that older files need into `STEPS`.
"""

from __future__ import annotations

from collections.abc import Callable

import bpy
from bpy.app.handlers import persistent

#: The version that is saved. 0: of Petzval 0.1, which saved none.
VERSION = 1
#: The functions that bring the settings of a file to a version from the one before. Each is called once for each file, when all of it is
#: loaded.
STEPS: dict[int, Callable[[], None]] = {}


def of_file() -> int:
    """The version of the settings in the file that is open: the newest of its scenes."""
    return max((scene.petzval.settings_version for scene in bpy.data.scenes), default=VERSION)


def warnings() -> list[str]:
    """The warnings of a render about the settings of the open file."""
    if (found := of_file()) <= VERSION:
        return []
    return [
        f"The file was saved by a newer Petzval (settings {found}, and this one knows {VERSION}): what it does not know is not read: update Petzval"
    ]


def bring_up_to_date() -> None:
    """Takes the steps from the version of the open file to the current one."""
    found = of_file()
    for version in range(found + 1, VERSION + 1):
        if version in STEPS:
            STEPS[version]()
    # Settings of a newer version stay, and so does its number: this one may save them again.
    _mark(max(found, VERSION))


def _mark(version: int) -> None:
    for scene in bpy.data.scenes:
        if scene.library is None and scene.petzval.settings_version != version:
            scene.petzval.settings_version = version


@persistent
def _file_loaded(_file: str) -> None:
    bring_up_to_date()
    for line in warnings():
        print("petzval:", line)


@persistent
def _file_is_saved(_file: str) -> None:
    # Scenes that were added meanwhile.
    _mark(max(of_file(), VERSION))


_HANDLERS = (("load_post", _file_loaded), ("save_pre", _file_is_saved))


def register() -> None:
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)
    # Switched on while a file is open; at Blender's start there is none yet.
    if hasattr(bpy.data, "scenes"):
        bring_up_to_date()


def unregister() -> None:
    for name, handler in _HANDLERS:
        handlers = getattr(bpy.app.handlers, name)
        if handler in handlers:
            handlers.remove(handler)
