# SPDX-License-Identifier: GPL-3.0-or-later
"""The compiled engine: one way to it, and one line when it cannot be had.

The add-on registers without it, so that the user is told in Blender instead of finding a traceback in a console.
"""

from __future__ import annotations

from types import ModuleType


class EngineMissing(Exception):
    """The message is one line for the user."""


def engine() -> ModuleType:
    """The compiled module. Raises `EngineMissing` where it cannot be loaded."""
    try:
        from petzval.processors import ProcessorError

        try:
            from petzval import _native
        except ProcessorError as error:
            raise EngineMissing(f"Petzval's engine cannot be loaded: {error}") from error
    except ImportError as error:
        raise EngineMissing(f"Petzval's engine cannot be loaded ({error}); install the extension again") from error
    return _native


def missing() -> str:
    """The reason why the engine cannot be loaded; empty where it can."""
    try:
        engine()
    except EngineMissing as error:
        return str(error)
    return ""
