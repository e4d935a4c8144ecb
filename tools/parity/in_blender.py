# SPDX-License-Identifier: GPL-3.0-or-later
"""A job of `make parity` in a process that has bpy: its beginning and its end."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from types import ModuleType


def registered() -> ModuleType:
    """The add-on, registered beside Cycles."""
    # bpy has it once it is there.
    import addon_utils

    from petzval import load_addon

    addon_utils.enable("cycles")
    addon = load_addon()
    addon.register()
    return addon


def end(main: Callable[..., None], *arguments) -> None:
    """Runs `main` and ends the process: 0, or 1 with the error as the last line."""
    code = 1
    try:
        main(*arguments)
        code = 0
    except Exception as error:  # noqa: BLE001 (it is the last line that is read)
        print(f"{type(error).__name__}: {error}", file=sys.stderr, flush=True)
    # bpy with an engine registered may hang or crash at its end.
    os._exit(code)
